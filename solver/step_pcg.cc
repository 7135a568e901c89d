#include <raybundle/linalg/pcg.h>
#include <raybundle/linalg/preconditioner.h>
#include <raybundle/linalg/vector.h>
#include <raybundle/solver/step.h>

#include <algorithm>
#include <cmath>

namespace raybundle {
namespace {

using linalg::index;

constexpr double least_forcing = 1e-12;

// The inexact step of [Qu18, Alg. 7]: conjugate gradients on the (reduced) system, whose matrix is
// never formed.
class PcgStep final : public StepSolver {
 public:
  PcgStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : options_(options),
        pool_(pool),
        system_(make_reduced_system(layout, eliminated_side(*options.elimination), pool)),
        pcg_(system_->size(), pool),
        b_(index(system_->size())),
        x_(index(system_->size())) {}

  StepReport solve(const linalg::Linearization& at, const double* damping, double* step) override {
    system_->prepare(at, damping);
    system_->gradient(b_.data());
    for (double& b : b_) b = -b;
    build_preconditioner();
    inverse_scaling(*options_.scaling, *at.normal, inverse_);
    scale(b_.data());

    // Stop at |r| <= min(t, |b|) |b|  [Qu18, Alg. 1, line 2], above what rounding allows.
    const double norm = std::sqrt(linalg::dot(b_.data(), b_.data(), system_->size(), pool_));
    const double tolerance = std::max(std::min(*options_.forcing, norm), least_forcing) * norm;
    const auto result = pcg_.solve([this](const double* x, double* y) { apply(x, y); },
                                   [this](const double* r, double* z) { precondition(r, z); },
                                   b_.data(), tolerance, *options_.max_inner_iterations, x_.data());
    scale(x_.data());
    system_->expand(x_.data(), step);
    // A breakdown after some progress still gives a step; one at the start gives none.
    const bool solved = result.end != linalg::Pcg::End::breakdown || result.iterations > 0;
    return {.solved = solved, .inner_iterations = result.iterations};
  }

  Linear linear() const override { return Linear::implicit_pcg; }
  std::string description() const override {
    return "conjugate gradients on the implicit system of order " +
           std::to_string(system_->size()) + ", preconditioner " + name(*options_.preconditioner);
  }

 private:
  void build_preconditioner() {
    using Form = linalg::Preconditioner::Form;
    using Blocks = linalg::ReducedSystem::Blocks;
    const Preconditioner kind = *options_.preconditioner;
    if (kind == Preconditioner::identity) return preconditioner_.build(Form::identity, blocks_);
    const bool reduced = kind == Preconditioner::diag_s || kind == Preconditioner::block_diag_s;
    const bool diagonal = kind == Preconditioner::diag_b || kind == Preconditioner::diag_s;
    system_->diagonal_blocks(reduced ? Blocks::reduced : Blocks::undiminished, blocks_);
    preconditioner_.build(diagonal ? Form::diagonal : Form::blocks, blocks_);
  }

  // In the scaled unknowns D x the matrix is D^-1 A D^-1  [Qu18, Alg. 7, line 3].
  void apply(const double* x, double* y) {
    if (inverse_.empty()) return system_->apply(x, y);
    scaled_.assign(x, x + system_->size());
    scale(scaled_.data());
    system_->apply(scaled_.data(), y);
    scale(y);
  }

  // The preconditioner is that of A, carried over to the scaled unknowns.
  void precondition(const double* r, double* z) {
    if (inverse_.empty()) return preconditioner_.apply(r, z, system_->size(), pool_);
    if (*options_.preconditioner == Preconditioner::identity) {
      std::copy_n(r, system_->size(), z);
      return;
    }
    scaled_.assign(r, r + system_->size());
    unscale(scaled_.data());
    preconditioner_.apply(scaled_.data(), z, system_->size(), pool_);
    unscale(z);
  }

  void scale(double* x) const {
    if (inverse_.empty()) return;
    const double* s = inverse_.data() + system_->offset();
    for (std::int64_t i = 0; i < system_->size(); ++i) x[i] *= s[i];
  }
  void unscale(double* x) const {
    const double* s = inverse_.data() + system_->offset();
    for (std::int64_t i = 0; i < system_->size(); ++i) x[i] /= s[i];
  }

  Options options_;
  linalg::ThreadPool& pool_;
  std::unique_ptr<linalg::ReducedSystem> system_;
  linalg::Pcg pcg_;
  linalg::Preconditioner preconditioner_;
  linalg::DiagonalBlocks blocks_;
  std::vector<double> b_;
  std::vector<double> x_;
  std::vector<double> inverse_;
  std::vector<double> scaled_;
};

}  // namespace

std::unique_ptr<StepSolver> make_pcg_step(const Options& options, const linalg::BlockLayout& layout,
                                          linalg::ThreadPool& pool) {
  return std::make_unique<PcgStep>(options, layout, pool);
}

}  // namespace raybundle
