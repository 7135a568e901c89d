#include <raybundle/linalg/spectrum.h>
#include <raybundle/solver/step.h>

#include <algorithm>

namespace raybundle {
namespace {

// Eliminates the better conditioned side, anew for every step [Qu18, Alg. 10]: a badly conditioned
// block is inverted inaccurately, and the iteration on the other side has to live with it.
class AdaptiveStep final : public StepSolver {
 public:
  AdaptiveStep(const Options& options, const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
      : layout_(layout),
        pool_(pool),
        points_gone_(make_pcg_step(options, Elimination::points, layout, pool)),
        cameras_gone_(make_pcg_step(options, Elimination::cameras, layout, pool)) {}

  StepReport solve(const StepRequest& request, double* step) override {
    const double B = condition(linalg::Side::hubs, request);
    const double C = condition(linalg::Side::leaves, request);
    StepReport report;
    if (C < B) {
      report = points_gone_->solve(request, step);
    } else {
      report = solve_points(request, step);
    }
    report.condition_cameras = B;
    report.condition_points = C;
    return report;
  }

  Linear linear() const override { return Linear::implicit_pcg; }
  std::string description() const override {
    return points_gone_->description() + ", or of order " +
           std::to_string(layout_.size(linalg::Side::leaves));
  }

 private:
  double condition(linalg::Side side, const StepRequest& request) const {
    std::vector<double> H;
    request.at.normal->diagonal_blocks(*request.at.J, side, H, pool_);
    return linalg::block_spectrum(H.data(), layout_.block_size(side), layout_.block_count(side),
                                  request.damping + layout_.offset(side), pool_)
        .worst_condition;
  }

  // The radius is that of the cameras' step; points have a longer vector  [Qu18, Alg. 10, line 18].
  StepReport solve_points(const StepRequest& request, double* step) {
    const double ratio = static_cast<double>(layout_.size(linalg::Side::leaves)) /
                         static_cast<double>(layout_.size(linalg::Side::hubs));
    StepRequest rescaled = request;
    rescaled.radius *= ratio;
    StepReport report = cameras_gone_->solve(rescaled, step);
    report.length /= ratio;
    return report;
  }

  const linalg::BlockLayout& layout_;
  linalg::ThreadPool& pool_;
  std::unique_ptr<StepSolver> points_gone_;
  std::unique_ptr<StepSolver> cameras_gone_;
};

}  // namespace

// Both, and the blocks of one side whose conditions are looked at.
double adaptive_step_memory(const Options& options, const linalg::LayoutSize& n) {
  const auto blocks = [&](linalg::Side side) {
    return 8 * static_cast<double>(n.size(side) * n.block_size(side));
  };
  return pcg_step_memory(options, Elimination::points, n) +
         pcg_step_memory(options, Elimination::cameras, n) +
         std::max(blocks(linalg::Side::hubs), blocks(linalg::Side::leaves));
}

std::unique_ptr<StepSolver> make_adaptive_step(const Options& options,
                                               const linalg::BlockLayout& layout,
                                               linalg::ThreadPool& pool) {
  return std::make_unique<AdaptiveStep>(options, layout, pool);
}

}  // namespace raybundle
