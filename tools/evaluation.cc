#include <raybundle/tools/evaluation.h>

#include <array>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/text_writer.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr int schema = 1;

Json loss_json(const RobustLoss& loss) {
  if (loss.kind == Loss::none) return {};
  return {{"kind", name(loss.kind)}, {"scope", name(loss.scope)}, {"scale", loss.scale}};
}

Json truth_json(const Evaluation& evaluation) {
  if (!evaluation.truth) return {};
  const TruthErrors& truth = *evaluation.truth;
  const auto of_points = [&](double value) { return truth.points > 0 ? Json(value) : Json(); };
  return {{"source", evaluation.truth_source},
          {"cameras", truth.cameras},
          {"points", truth.points},
          {"camera_rmse", truth.camera_rmse},
          {"point_rmse", of_points(truth.point_rmse)},
          {"point_median", of_points(truth.point_median)},
          {"rotation_mean_degrees", truth.rotation_mean},
          {"camera_scale", truth.camera_alignment.scale},
          {"point_scale", of_points(truth.point_alignment.scale)},
          {"point_rmse_by_cameras", of_points(truth.point_rmse_by_cameras)},
          {"point_median_own", of_points(truth.point_median_own)}};
}

std::string count_text(std::int64_t part, std::int64_t whole, const char* what) {
  return format("%lld of %lld %s", static_cast<long long>(part), static_cast<long long>(whole),
                what);
}

/// Which figures belong to which alignment, and whether the points' own can be trusted.
void add_point_errors(const TruthErrors& truth, std::int64_t points, Table& table) {
  const double by_cameras = truth.camera_alignment.scale;
  const double by_points = truth.point_alignment.scale;
  table.add("  RMSE of points", format("%.9g", truth.point_rmse_by_cameras));
  table.add("  median of points", format("%.9g", truth.point_median));
  table.add("", count_text(truth.points, points, "points"));
  table.heading("aligned by the points themselves:");
  table.add("  scale", format("%.6g", by_points));
  table.add("  RMSE of points", format("%.9g", truth.point_rmse));
  table.add("  median of points", format("%.9g", truth.point_median_own));
  const bool alike = by_points <= 2 * by_cameras && by_cameras <= 2 * by_points;
  if (truth.cameras > 1 && !alike) {  // a single centre has no scale
    table.add("  warning", "the scales differ: a few far points dominate this alignment;");
    table.add("", "see the median that is aligned by the camera centres");
  }
}

void add_truth(const Evaluation& evaluation, Table& table) {
  const TruthErrors& truth = *evaluation.truth;
  table.heading("against " + evaluation.truth_source + ", aligned by the camera centres:");
  table.add("  scale", format("%.6g", truth.camera_alignment.scale));
  table.add("  RMSE of camera centres", format("%.9g", truth.camera_rmse));
  table.add("", count_text(truth.cameras, evaluation.cameras, "cameras"));
  if (truth.points > 0) add_point_errors(truth, evaluation.points, table);
  table.heading("turned as fits best:");
  table.add("  mean rotation error", format("%.9g degrees", truth.rotation_mean));
}

void write_csv(const std::string& output, std::string header,
               const std::vector<ResidualSummary>& summaries, const std::vector<double>& places,
               const std::vector<double>* errors) {
  io::AtomicFile file(output_path(output));
  header += ",observations,rmse,largest,x,y,z";
  file.write(header + (errors == nullptr ? "\n" : ",error\n"));
  io::TextWriter writer([&file](std::string_view text) { file.write(text); });
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    writer.number(i, ',');
    writer.number(summaries[i].observations, ',');
    writer.number(summaries[i].rmse, ',');
    writer.number(summaries[i].largest, ',');
    writer.number(places[3 * i], ',');
    writer.number(places[3 * i + 1], ',');
    writer.number(places[3 * i + 2], errors == nullptr ? '\n' : ',');
    if (errors != nullptr) writer.number((*errors)[i], '\n');
  }
  writer.flush();
  file.commit();
}

}  // namespace

std::string evaluation_report(const Evaluation& evaluation) {
  Table table;
  table.add("cost", format("%.6e", evaluation.cost));
  table.add("cost, all digits", exact_text(evaluation.cost));
  if (evaluation.loss.kind != Loss::none) {
    table.add("loss", format("%s of each %s, scale %g px", name(evaluation.loss.kind),
                             name(evaluation.loss.scope), evaluation.loss.scale));
    table.add("cost without loss", format("%.6e", evaluation.pixels.cost));
  }
  table.add("RMSE", format("%.9g px", evaluation.pixels.rmse));
  table.add("largest residual", format("%.9g px", evaluation.pixels.largest));
  table.add("behind cameras",
            count_text(evaluation.pixels.behind_camera, evaluation.observations, "observations"));
  if (evaluation.truth) add_truth(evaluation, table);
  return evaluation.source + "\n" + table.text();
}

std::string evaluation_json(const Evaluation& evaluation) {
  const Json json = {{"schema", schema},
                     {"version", version},
                     {"build", build_description},
                     {"problem",
                      {{"source", evaluation.source},
                       {"cameras", evaluation.cameras},
                       {"points", evaluation.points},
                       {"observations", evaluation.observations}}},
                     {"cost", evaluation.cost},
                     {"pixel_cost", evaluation.pixels.cost},
                     {"rmse", evaluation.pixels.rmse},
                     {"largest", evaluation.pixels.largest},
                     {"behind_cameras", evaluation.pixels.behind_camera},
                     {"loss", loss_json(evaluation.loss)},
                     {"truth", truth_json(evaluation)}};
  // A file name need not be UTF-8; JSON must.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

void write_cameras_csv(const std::string& output, const Problem& problem,
                       const ReprojectionBreakdown& breakdown,
                       const std::optional<TruthErrors>& truth) {
  write_csv(output, "camera", breakdown.cameras, camera_centres(problem),
            truth ? &truth->camera_errors : nullptr);
}

void write_points_csv(const std::string& output, const Problem& problem,
                      const ReprojectionBreakdown& breakdown,
                      const std::optional<TruthErrors>& truth) {
  write_csv(output, "point", breakdown.points, problem.points,
            truth && truth->points > 0 ? &truth->point_errors : nullptr);
}

}  // namespace raybundle::tools
