#include <raybundle/linalg/coarse_space.h>
#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/pcg.h>
#include <raybundle/linalg/preconditioner.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/solver/block_region.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/step.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <string>
#include <utility>

namespace raybundle {
namespace {

using linalg::index;

constexpr double least_forcing = 1e-12;

// The inexact step of [Qu18, Alg. 4, 7]: conjugate gradients, within a trust region or not, on the
// (reduced) system, whose matrix is formed or not. In the scaled unknowns x~ = D x the matrix is
// D^-1 A D^-1 and the right side D^-1 b  [Qu18, Eq. 3.96-3.99]; the region bounds |x~|, which is
// that of the unknowns solved for, since the others follow from them  [Qu18, Eq. 3.101].
class PcgStep final : public StepSolver {
 public:
  PcgStep(const Options& options, Elimination elimination, const linalg::BlockLayout& layout,
          linalg::ThreadPool& pool, std::unique_ptr<linalg::ReducedSystem> system,
          double matrix_memory)
      : elimination_(elimination),
        block_region_(layout, eliminated_side(elimination)),
        preconditioner_kind_(*options.preconditioner),
        adaptive_(*options.preconditioner == Preconditioner::adaptive),
        max_iterations_(*options.max_inner_iterations),
        layout_(layout),
        pool_(pool),
        matrix_memory_(matrix_memory),
        memory_limit_(options.memory_limit - matrix_memory),
        system_(std::move(system)),
        pcg_(system_->size(), pool),
        b_(index(system_->size())),
        x_(index(system_->size())) {
    if (preconditioner_kind_ == Preconditioner::two_level) {
      coarse_.emplace(layout, pool, memory_limit_);
    }
  }

  StepReport solve(const StepRequest& request, double* step) override {
    system_->prepare(request.at, block_region_.hold(request));
    inverse_ = request.inverse_scaling;
    if (inverse_ != nullptr) {
      inverse_ += system_->offset();
      scaled_.resize(x_.size());
    }
    build_preconditioner(request);
    for (double& b : b_) b = -b;
    scale(b_.data());
    StepReport report;
    const linalg::Pcg::Result result = iterate(request, report);
    report.eliminated = elimination_;
    report.inner_capped = result.end == linalg::Pcg::End::max_iterations;
    report.on_boundary = result.end == linalg::Pcg::End::boundary;
    report.length = norm(x_);
    // A breakdown after some progress still gives a step; one at the start gives none.
    report.solved = result.end != linalg::Pcg::End::breakdown || result.iterations > 0;
    scale(x_.data());
    report.curvature = system_->expand(x_.data(), step);
    block_region_.measure(request, step, report);
    return report;
  }

  Linear linear() const override {
    return matrix_memory_ > 0 ? Linear::explicit_pcg : Linear::implicit_pcg;
  }
  double matrix_memory() const override { return matrix_memory_; }
  std::string description() const override {
    std::string text = std::string("conjugate gradients on the ") +
                       (matrix_memory_ > 0 ? "explicit" : "implicit") + " system of order " +
                       std::to_string(system_->size()) + ", preconditioner " +
                       name(preconditioner_kind_);
    if (coarse_acts_) text += " with " + std::to_string(coarse_->clusters()) + " clusters";
    return text;
  }

 private:
  double norm(const std::vector<double>& x) const {
    return std::sqrt(linalg::dot(x.data(), x.data(), system_->size(), pool_));
  }

  linalg::Pcg::Stop stop(const StepRequest& request) const {
    const InnerTolerance& tolerance = request.tolerance;
    const double b = norm(b_);
    const double eta = tolerance.relative_residual;
    const double relative = std::max(tolerance.by_norm ? std::min(eta, b) : eta, least_forcing);
    return {.residual = relative * b,
            .model_decrease = tolerance.model_decrease,
            .max_iterations = max_iterations_,
            .radius = request.radius};
  }

  // `adaptive` begins without a coarse space, and begins anew with one where the inner iterations
  // turn out to be too many; where they are merely many, the next step has it.
  linalg::Pcg::Result iterate(const StepRequest& request, StepReport& report) {
    linalg::Pcg::Stop until = stop(request);
    const bool may_begin_anew = adaptive_ && max_iterations_ > too_many_inner_iterations;
    if (may_begin_anew) until.max_iterations = too_many_inner_iterations;
    linalg::Pcg::Result result = iterate(until);
    report.inner_iterations = result.iterations;
    report.two_level = coarse_acts_;
    if (adaptive_ && result.iterations > many_inner_iterations) make_coarse_space(request.grown);
    if (may_begin_anew && result.end == linalg::Pcg::End::max_iterations) {
      if (coarse_) build_coarse_space(request);
      until.max_iterations = max_iterations_;
      result = iterate(until);
      report.inner_iterations += result.iterations;
    }
    report.two_level_next = coarse_.has_value();
    return result;
  }

  linalg::Pcg::Result iterate(const linalg::Pcg::Stop& until) {
    return pcg_.solve([this](const double* x, double* y) { apply(x, y); },
                      [this](const double* r, double* z) { precondition(r, z); }, b_.data(), until,
                      x_.data());
  }

  void precondition(const double* r, double* z) {
    preconditioner_.apply(r, z, system_->size(), pool_);
    if (coarse_acts_) coarse_->add_correction(r, z);
  }

  // Without the memory for it things stay as they are.
  void make_coarse_space(double grown) {
    adaptive_ = false;
    try {
      coarse_.emplace(layout_, pool_, memory_limit_ - grown);
    } catch (const std::bad_alloc&) {
      coarse_.reset();
    }
  }

  void build_coarse_space(const StepRequest& request) {
    try {
      coarse_acts_ = coarse_->build(*system_, request.at, blocks_, inverse_);
    } catch (const std::bad_alloc&) {
      coarse_.reset();
      coarse_acts_ = false;
    }
  }

  // The preconditioner of the scaled matrix: that of A, with its blocks scaled. The right side, b_,
  // comes with the diagonal of A.
  void build_preconditioner(const StepRequest& request) {
    using Form = linalg::Preconditioner::Form;
    const Preconditioner kind = preconditioner_kind_;
    if (needs_schur_complement(kind)) {
      system_->reduced_diagonal(blocks_, b_.data());
    } else {
      system_->gradient(b_.data());
      if (kind == Preconditioner::identity)
        return preconditioner_.build(Form::identity, blocks_, pool_);
      system_->diagonal_blocks(blocks_);
    }
    if (inverse_ != nullptr) scale_blocks();
    const bool diagonal = kind == Preconditioner::diag_b || kind == Preconditioner::diag_s;
    preconditioner_.build(diagonal ? Form::diagonal : Form::blocks, blocks_, pool_);
    if (coarse_) build_coarse_space(request);
  }

  void scale_blocks() {
    const double* s = inverse_;
    for (auto& run : blocks_.runs) {
      double* value = run.values.data();
      for (std::int64_t block = 0; block < run.count; ++block, s += run.size) {
        for (int i = 0; i < run.size; ++i) {
          for (int j = 0; j < run.size; ++j) *value++ *= s[i] * s[j];
        }
      }
    }
  }

  void apply(const double* x, double* y) {
    if (inverse_ == nullptr) return system_->apply(x, y);
    linalg::for_entries(system_->size(), pool_,
                        [&](std::size_t i) { scaled_[i] = x[i] * inverse_[i]; });
    system_->apply(scaled_.data(), y);
    scale(y);
  }

  void scale(double* x) const {
    if (inverse_ == nullptr) return;
    linalg::for_entries(system_->size(), pool_, [&](std::size_t i) { x[i] *= inverse_[i]; });
  }

  Elimination elimination_;
  BlockRegion block_region_;
  Preconditioner preconditioner_kind_;
  bool adaptive_;  // and has not gone over yet
  int max_iterations_;
  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  double matrix_memory_;  // bytes; 0: products are with the Jacobian
  double memory_limit_;   // bytes that a coarse space may take
  std::unique_ptr<linalg::ReducedSystem> system_;
  linalg::Pcg pcg_;
  linalg::Preconditioner preconditioner_;
  linalg::DiagonalBlocks blocks_;
  std::optional<linalg::CoarseSpace> coarse_;
  bool coarse_acts_ = false;
  std::vector<double> b_;
  std::vector<double> x_;
  std::vector<double> scaled_;
  const double* inverse_ = nullptr;  // D^-1 of the unknowns solved for; null: the identity
};

}  // namespace

// Blocks of the preconditioner and their factors, the vectors of the iteration, and what holds the
// eliminated blocks where nothing damps them.
double pcg_step_memory(const Options& options, Elimination elimination,
                       const linalg::LayoutSize& n) {
  const auto side = eliminated_side(elimination);
  const auto blocks_of = [&](linalg::Side kept) {
    return side == kept ? 0 : static_cast<double>(n.size(kept) * n.block_size(kept));
  };
  const bool has_blocks = *options.preconditioner != Preconditioner::identity;
  const double blocks = blocks_of(linalg::Side::hubs) + blocks_of(linalg::Side::leaves);
  const std::int64_t size = side ? n.size(opposite(*side)) : n.unknowns();
  const bool scaled =
      options.scaling.value_or(DiagonalMatrix::identity) != DiagonalMatrix::identity;
  const MethodTraits& method = traits(options.method);
  const bool held = side && method.bounded && !method.damped;
  // Modes of hubs as given. The rest of a coarse space depends on the sparsity.
  const double modes =
      has_coarse_space(options)
          ? static_cast<double>(n.size(linalg::Side::hubs) * linalg::coarse_modes(n.block.hub))
          : 0;
  return reduced_system_memory(n, side, false) + linalg::Pcg::memory(size) +
         8 * (modes + (has_blocks ? 2 * blocks : 0)) +
         8 * (scaled ? 3 : 2) * static_cast<double>(size) +
         (held ? BlockRegion::memory(n, *side) : 0);
}

std::unique_ptr<StepSolver> make_pcg_step(const Options& options, Elimination elimination,
                                          const linalg::BlockLayout& layout,
                                          linalg::ThreadPool& pool) {
  auto system = make_reduced_system(layout, eliminated_side(elimination), pool);
  if (options.linear == Linear::explicit_pcg) {
    return make_explicit_pcg_step(options, elimination, layout, pool, system->pattern());
  }
  return std::make_unique<PcgStep>(options, elimination, layout, pool, std::move(system), 0);
}

std::unique_ptr<StepSolver> make_explicit_pcg_step(const Options& options, Elimination elimination,
                                                   const linalg::BlockLayout& layout,
                                                   linalg::ThreadPool& pool,
                                                   linalg::SymmetricPattern pattern) {
  const double memory = linalg::ExplicitSystem::memory(pattern);
  linalg::require_memory(memory, options.memory_limit,
                         "a matrix of order " + std::to_string(pattern.order()));
  auto system = make_reduced_system(layout, eliminated_side(elimination), pool);
  auto formed =
      std::make_unique<linalg::ExplicitSystem>(std::move(system), std::move(pattern), pool);
  return std::make_unique<PcgStep>(options, elimination, layout, pool, std::move(formed), memory);
}

}  // namespace raybundle
