#include <raybundle/solver/linear_work.h>

#include <raybundle/linalg/dense_cholesky.h>
#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/memory.h>

#include <algorithm>

namespace raybundle {

using linalg::index;

namespace {

// Measured with one thread of an AMD EPYC with AVX-512 where a dense factorisation does 40
// multiplications with addition in a nanosecond (docs/decisions.md).
constexpr double per_nanosecond = 40;
constexpr double row_nanoseconds = 8.5;  // of a product
constexpr double eliminated_nanoseconds = 25;
constexpr double diagonal_nanoseconds = 15;
constexpr double coarse_nanoseconds = 130;   // matrix and factor of a coarse space
constexpr double pair_nanoseconds = 18;      // of the products of two rows of a leaf ...
constexpr double far_pair_nanoseconds = 50;  // ... where they go to a matrix beyond all caches
constexpr double cache_bytes = 16e6;         // where it is halfway between
constexpr double number_nanoseconds = 0.3;   // of the matrix, in a product with it
constexpr double planning_share = 0.5;       // of an assembly

// Work of an assembly into a matrix of so many bytes over that into one which fits the caches.
double assembly_factor(double matrix_bytes) {
  const double far = matrix_bytes / (matrix_bytes + cache_bytes);
  return 1 + far * (far_pair_nanoseconds / pair_nanoseconds - 1);
}

}  // namespace

LinearWork linear_work(const linalg::BlockLayout& layout) {
  const double width = static_cast<double>(layout.hub_size) / 9;
  const auto rows = static_cast<double>(layout.rows);
  double pairs = 0;
  for (std::int64_t l = 0; l < layout.leaves; ++l) {
    const auto& begin = layout.leaf_side.begin;
    const auto track = static_cast<double>(begin[index(l + 1)] - begin[index(l)]);
    pairs += track * (track + 1) / 2;
  }
  return {.product = per_nanosecond * row_nanoseconds * width * rows,
          .elimination = per_nanosecond * eliminated_nanoseconds * width * width * rows,
          .preconditioner = per_nanosecond * diagonal_nanoseconds * width * width * rows,
          .coarse = per_nanosecond * coarse_nanoseconds * width * width * rows,
          .assembly = per_nanosecond * pair_nanoseconds * width * width * pairs};
}

InnerIterations expected_after(const StepReport& report) {
  if (report.two_level || !report.two_level_next) {
    return {report.inner_iterations, report.two_level};
  }
  constexpr int mostly_of_two_levels = 20;
  return {mostly_of_two_levels, true};
}

LinearForecast::LinearForecast(const linalg::BlockLayout& layout, double memory_limit)
    : work_(linear_work(layout)),
      order_(static_cast<double>(layout.size(linalg::Side::hubs))),
      size_(layout.hub_size),
      memory_limit_(memory_limit) {
  // The diagonal of the matrix is the least there is of it.
  const double product = per_nanosecond * number_nanoseconds * order_ * size_;
  candidates_ = {{.linear = Linear::dense_cholesky, .work = formed(), .lower_bound = true},
                 {.linear = Linear::sparse_cholesky, .work = formed(), .lower_bound = true},
                 {.linear = Linear::explicit_pcg,
                  .work = formed(),
                  .inner_work = product,
                  .coarse_work = work_.coarse,
                  .lower_bound = true},
                 {.linear = Linear::implicit_pcg,
                  .work = work_.elimination + work_.preconditioner,
                  .inner_work = work_.product,
                  .coarse_work = work_.coarse}};
  candidate(Linear::dense_cholesky).work += linalg::front_work(order_, 0);
}

LinearCandidate& LinearForecast::candidate(Linear linear) {
  return *std::find_if(candidates_.begin(), candidates_.end(),
                       [linear](const LinearCandidate& each) { return each.linear == linear; });
}

void LinearForecast::expect(double blocks) { weigh(0.5 * blocks * size_ * size_); }

void LinearForecast::add(const linalg::SymmetricPattern& pattern) {
  const auto numbers = static_cast<double>(pattern.scalar_nonzeros());
  weigh(numbers);
  LinearCandidate& dense = candidate(Linear::dense_cholesky);
  LinearCandidate& iterated = candidate(Linear::explicit_pcg);
  dense.memory = linalg::DenseCholesky::memory(pattern.order());
  iterated.memory = linalg::ExplicitSystem::memory(pattern);
  candidate(Linear::sparse_cholesky).memory = 2 * 8 * numbers;
  dense.lower_bound = iterated.lower_bound = false;
  see_what_fits();
}

// Of a matrix of so many numbers. Columns of h numbers take h^2 / 2 each, in whatever order; least
// where all are as long.
void LinearForecast::weigh(double numbers) {
  assembly_factor_ = assembly_factor(8 * numbers);
  LinearCandidate& dense = candidate(Linear::dense_cholesky);
  LinearCandidate& iterated = candidate(Linear::explicit_pcg);
  dense.work = formed() + linalg::front_work(order_, 0);
  iterated.work = formed();
  iterated.inner_work = per_nanosecond * number_nanoseconds * numbers;
  candidate(Linear::sparse_cholesky).work =
      std::min(formed() + 0.5 * numbers * numbers / order_, dense.work);
}

void LinearForecast::add(const linalg::CholeskyPlan& plan) {
  const LinearCandidate& dense = candidate(Linear::dense_cholesky);
  LinearCandidate& sparse = candidate(Linear::sparse_cholesky);
  const bool analysed = plan.supernodes.count() > 0;  // else not worth it
  sparse.work = analysed ? formed() + linalg::factor_work(plan.supernodes) : dense.work;
  sparse.memory = analysed ? plan.sparse_memory : dense.memory;
  sparse.lower_bound = false;
  see_what_fits();
}

void LinearForecast::leave(double memory_limit) {
  memory_limit_ = memory_limit;
  see_what_fits();
}

void LinearForecast::see_what_fits() {
  const double left = std::min(linalg::available_memory(), memory_limit_);
  for (LinearCandidate& each : candidates_) each.fits = each.memory <= left;
}

const LinearCandidate& LinearForecast::best(InnerIterations expected) const {
  return *std::min_element(candidates_.begin(), candidates_.end(),
                           [&](const LinearCandidate& a, const LinearCandidate& b) {
                             if (a.fits != b.fits) return a.fits;
                             return weighed(a, expected) < weighed(b, expected);
                           });
}

double LinearForecast::weighed(const LinearCandidate& way, InnerIterations expected) {
  return (iterates(way.linear) ? worth_of_exact_steps : 1) * way.work_with(expected);
}

double LinearForecast::planning() const { return planning_share * work_.assembly; }

}  // namespace raybundle
