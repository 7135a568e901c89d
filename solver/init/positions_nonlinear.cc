#include <raybundle/solver/init/positions_nonlinear.h>

#include <utility>
#include <vector>

namespace raybundle::init {

Summary register_positions(Problem& problem, const PositionOptions& options,
                           const Observer& observer) {
  constexpr std::uint16_t rotation = 0b111;
  std::vector<std::uint16_t> fixed = std::exchange(
      problem.fixed_camera_parameters,
      std::vector<std::uint16_t>(static_cast<std::size_t>(problem.camera_count()), rotation));
  const Options solving = {.method = Method::lm_cholesky,
                           .points = PointModel::pmba,
                           .point_start = PointStart::rays,
                           .point_steps = PointSteps::none,
                           .objective = ObjectiveKind::ray,
                           .loss = options.loss,
                           .loss_scale = options.loss == Loss::none
                                             ? std::nullopt
                                             : std::optional<double>(options.loss_scale),
                           .max_iterations = options.max_iterations,
                           .function_tolerance = options.function_tolerance,
                           .threads = options.threads};
  try {
    Summary summary = solve(problem, solving, observer);
    problem.fixed_camera_parameters = std::move(fixed);
    return summary;
  } catch (...) {
    problem.fixed_camera_parameters = std::move(fixed);
    throw;
  }
}

}  // namespace raybundle::init
