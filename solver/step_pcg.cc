#include <raybundle/linalg/explicit_system.h>
#include <raybundle/linalg/pcg.h>
#include <raybundle/linalg/preconditioner.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/solver/block_region.h>
#include <raybundle/solver/step.h>

#include <algorithm>
#include <cmath>
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
          linalg::ThreadPool& pool, std::unique_ptr<linalg::ReducedSystem> system, Linear linear)
      : elimination_(elimination),
        block_region_(layout, eliminated_side(elimination)),
        preconditioner_kind_(*options.preconditioner),
        max_iterations_(*options.max_inner_iterations),
        pool_(pool),
        linear_(linear),
        system_(std::move(system)),
        pcg_(system_->size(), pool),
        b_(index(system_->size())),
        x_(index(system_->size())) {}

  StepReport solve(const StepRequest& request, double* step) override {
    system_->prepare(request.at, block_region_.hold(request));
    inverse_ = request.inverse_scaling;
    if (inverse_ != nullptr) {
      inverse_ += system_->offset();
      scaled_.resize(x_.size());
    }
    build_preconditioner();
    for (double& b : b_) b = -b;
    scale(b_.data());
    const auto result = pcg_.solve(
        [this](const double* x, double* y) { apply(x, y); },
        [this](const double* r, double* z) { preconditioner_.apply(r, z, system_->size(), pool_); },
        b_.data(), stop(request), x_.data());
    StepReport report;
    report.eliminated = elimination_;
    report.inner_iterations = result.iterations;
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

  Linear linear() const override { return linear_; }
  std::string description() const override {
    return std::string("conjugate gradients on the ") +
           (linear_ == Linear::explicit_pcg ? "explicit" : "implicit") + " system of order " +
           std::to_string(system_->size()) + ", preconditioner " + name(preconditioner_kind_);
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

  // The preconditioner of the scaled matrix: that of A, with its blocks scaled. The right side, b_,
  // comes with the diagonal of A.
  void build_preconditioner() {
    using Form = linalg::Preconditioner::Form;
    const Preconditioner kind = preconditioner_kind_;
    if (kind == Preconditioner::diag_s || kind == Preconditioner::block_diag_s) {
      system_->reduced_diagonal(blocks_, b_.data());
    } else {
      system_->gradient(b_.data());
      if (kind == Preconditioner::identity) return preconditioner_.build(Form::identity, blocks_);
      system_->diagonal_blocks(blocks_);
    }
    if (inverse_ != nullptr) scale_blocks();
    const bool diagonal = kind == Preconditioner::diag_b || kind == Preconditioner::diag_s;
    preconditioner_.build(diagonal ? Form::diagonal : Form::blocks, blocks_);
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
  int max_iterations_;
  linalg::ThreadPool& pool_;
  Linear linear_;
  std::unique_ptr<linalg::ReducedSystem> system_;
  linalg::Pcg pcg_;
  linalg::Preconditioner preconditioner_;
  linalg::DiagonalBlocks blocks_;
  std::vector<double> b_;
  std::vector<double> x_;
  std::vector<double> scaled_;
  const double* inverse_ = nullptr;  // D^-1 of the unknowns solved for; null: the identity
};

}  // namespace

std::unique_ptr<StepSolver> make_pcg_step(const Options& options, Elimination elimination,
                                          const linalg::BlockLayout& layout,
                                          linalg::ThreadPool& pool) {
  auto system = make_reduced_system(layout, eliminated_side(elimination), pool);
  if (options.linear == Linear::explicit_pcg) {
    return make_explicit_pcg_step(options, elimination, layout, pool, system->pattern());
  }
  return std::make_unique<PcgStep>(options, elimination, layout, pool, std::move(system),
                                   Linear::implicit_pcg);
}

std::unique_ptr<StepSolver> make_explicit_pcg_step(const Options& options, Elimination elimination,
                                                   const linalg::BlockLayout& layout,
                                                   linalg::ThreadPool& pool,
                                                   linalg::SymmetricPattern pattern) {
  auto system = make_reduced_system(layout, eliminated_side(elimination), pool);
  auto formed =
      std::make_unique<linalg::ExplicitSystem>(std::move(system), std::move(pattern), pool);
  return std::make_unique<PcgStep>(options, elimination, layout, pool, std::move(formed),
                                   Linear::explicit_pcg);
}

}  // namespace raybundle
