#include <raybundle/tools/record.h>

#include <type_traits>

#include <nlohmann/json.hpp>

#include <raybundle/solver/option_table.h>
#include <raybundle/tools/memory.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

// Keys in the order they are written; numbers as the shortest text that reads back to the same
// double; what is not finite as null.
using Json = nlohmann::ordered_json;

constexpr int schema = 1;

template <class T>
Json value_json(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return name(value);
  } else {
    return value;
  }
}
template <class T>
Json value_json(const std::optional<T>& value) {
  return value ? value_json(*value) : Json();
}

Json options_json(const Options& options) {
  Json json = Json::object();
  visit_options(options, [&json](const auto& value, const OptionInfo& info) {
    json[info.name] = value_json(value);
  });
  return json;
}

Json problem_json(const SolveRecord& record) {
  Json json = {{"source", record.source},
               {"cameras", record.cameras},
               {"points", record.points},
               {"observations", record.observations}};
  if (record.seed) json["seed"] = *record.seed;
  return json;
}

Json diagnosis_json(const std::optional<Diagnosis>& diagnosis) {
  if (!diagnosis) return {};
  return {{"points",
           {{"smallest", diagnosis->points_smallest},
            {"largest", diagnosis->points_largest},
            {"worst_condition", diagnosis->points_worst_condition}}},
          {"reduced",
           {{"smallest", diagnosis->reduced_smallest}, {"largest", diagnosis->reduced_largest}}}};
}

Json iteration_json(const IterationRecord& record) {
  return {{"iteration", record.iteration},
          {"accepted", record.accepted},
          {"cost", record.cost},
          {"pixel_cost", record.pixel_cost},
          {"candidate_cost", record.candidate_cost},
          {"predicted_decrease", record.predicted_decrease},
          {"gradient_norm", record.gradient_norm},
          {"gradient_max", record.gradient_max},
          {"step_norm", record.step_norm},
          {"relative_step", record.relative_step},
          {"rho", record.rho},
          {"damping", record.damping},
          {"radius", record.radius},
          {"on_boundary", record.on_boundary},
          {"regularisation", record.regularisation},
          {"points_held", record.points_held},
          {"inner_iterations", record.inner_iterations},
          {"inner_capped", record.inner_capped},
          {"eliminated", name(record.eliminated)},
          {"condition_cameras", record.condition_cameras},
          {"condition_points", record.condition_points},
          {"diagnosis", diagnosis_json(record.diagnosis)},
          {"loss_scale", record.loss_scale},
          {"seconds", record.seconds}};
}

/// With a loss, the median residual and the share within its scale.
void add_robust(const char* when, const std::optional<RobustStatistics>& robust,
                std::int64_t observations, Json& json) {
  const std::string prefix = std::string(when) + "_";
  json[prefix + "median_residual"] = robust ? Json(robust->median) : Json();
  json[prefix + "within_loss_scale"] =
      robust && observations > 0
          ? Json(static_cast<double>(robust->within) / static_cast<double>(observations))
          : Json();
}

Json seconds_json(const SolveRecord& record) {
  const Timing& seconds = record.summary.seconds;
  return {{"total", seconds.total},
          {"setup", seconds.setup},
          {"residual", seconds.residual},
          {"jacobian", seconds.jacobian},
          {"linear", seconds.linear},
          {"diagnosis", seconds.diagnosis},
          {"io", record.read_seconds + record.write_seconds},
          {"read", record.read_seconds},
          {"write", record.write_seconds}};
}

Json choice_json(const LinearChoice& choice) {
  if (choice.candidates.empty()) return {};
  Json candidates = Json::array();
  for (const LinearCandidate& each : choice.candidates) {
    candidates.push_back({{"linear", name(each.linear)},
                          {"work", each.work_with(choice.expected)},
                          {"work_of_inner_iteration", each.inner_work},
                          {"memory_bytes", each.lower_bound ? Json() : Json(each.memory)},
                          {"lower_bound", each.lower_bound},
                          {"fits", each.fits}});
  }
  return {{"inner_iterations", choice.expected.count},
          {"two_level", choice.expected.two_level},
          {"candidates", std::move(candidates)}};
}

Json summary_json(const SolveRecord& record) {
  const Summary& summary = record.summary;
  const int iterations = static_cast<int>(summary.iterations.size()) - 1;  // 0 is the start
  Json json = {{"initial_cost", summary.initial_cost},
               {"final_cost", summary.final_cost},
               {"initial_pixel_cost", record.before.cost},
               {"pixel_cost", record.after.cost},
               {"initial_rmse", record.before.rmse},
               {"final_rmse", record.after.rmse},
               {"gradient_norm", summary.gradient_norm},
               {"termination", name(summary.termination)},
               {"message", summary.message},
               {"iterations", iterations},
               {"accepted", summary.accepted},
               {"rejected", iterations - summary.accepted},
               {"inner_iterations", summary.inner_iterations},
               {"linear_solves", summary.linear_solves},
               {"regularised", summary.regularised},
               {"linear_solver", summary.linear_solver},
               {"widened_at", summary.widened_at},
               {"linear_choice", choice_json(summary.linear_choice)},
               {"seconds", seconds_json(record)},
               {"peak_rss_bytes", peak_memory()},
               {"threads", summary.threads}};
  add_robust("initial", record.robust_before, record.observations, json);
  add_robust("final", record.robust_after, record.observations, json);
  json["warnings"] = record.warnings;
  return json;
}

}  // namespace

bool has_loss(const Options& options) { return options.loss && *options.loss != Loss::none; }

std::vector<std::string> start_warnings(const SolveRecord& record, const Options& effective) {
  std::vector<std::string> result;
  const bool rays_of_coordinates = effective.objective == ObjectiveKind::ray &&
                                   effective.points == PointModel::xyz &&
                                   record.before.behind_camera > 0;
  if (rays_of_coordinates) {
    result.push_back(count_text(record.before.behind_camera, "observation") +
                     " at the start of points behind their cameras, whose rays point the other "
                     "way: --points pmba can take them to be beyond infinity" +
                     (effective.point_start == PointStart::rays ? ""
                                                                : ", --point-start rays places "
                                                                  "them anew"));
  }
  if (effective.diagnose && effective.gauge == Gauge::free) {
    result.push_back(
        "--diagnose with --gauge free: seven eigenvalues of the reduced system are nothing but "
        "rounding, the smallest among them; see --gauge fixed");
  }
  return result;
}

std::vector<std::string> file_warnings(const SolveRecord& record, const Problem& problem,
                                       bool folder) {
  if (folder) return {without_points};
  std::vector<std::string> result;
  if (problem.aspect != 1) result.push_back(square_pixels);
  const Options& options = record.summary.options;
  const bool beyond = options.objective == ObjectiveKind::ray && is_anchored(options.points) &&
                      record.after.behind_camera > 0;
  if (beyond) {
    result.push_back(
        count_text(record.after.behind_camera, "observation") +
        " of points beyond infinity: in the coordinates of the file these are behind their "
        "cameras, which rays tell from in front; anchored points are read back where they were");
  }
  return result;
}

std::vector<std::string> result_warnings(const SolveRecord& record) {
  const Options& options = record.summary.options;
  if (!has_loss(options) || !levels_off(*options.loss) || !record.robust_after) return {};
  // Points with a wrong observation may end far off, so that some growth of the RMSE is no sign.
  const bool most_are_beyond = 2 * record.robust_after->within < record.observations;
  if (!most_are_beyond && !(record.after.rmse > 2 * record.before.rmse)) return {};
  return {std::string(most_are_beyond ? "more than half of the observations are beyond the scale "
                                        "of the loss, which takes them for outliers"
                                      : "the RMSE is more than twice that of the start: what the "
                                        "loss takes for outliers went far off") +
          "; start wider with --loss-start-scale" +
          (options.method == Method::irls ? "" : " (irls does by itself)")};
}

std::string log_json(const SolveRecord& record) {
  Json iterations = Json::array();
  for (const IterationRecord& each : record.summary.iterations) {
    iterations.push_back(iteration_json(each));
  }
  const Json json = {{"schema", schema},
                     {"version", version},
                     {"build", build_description},
                     {"options", options_json(record.summary.options)},
                     {"problem", problem_json(record)},
                     {"iterations", std::move(iterations)},
                     {"summary", summary_json(record)}};
  // A file name need not be UTF-8; JSON must.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace raybundle::tools
