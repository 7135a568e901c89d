#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <raybundle/models/alignment.h>
#include <raybundle/models/problem.h>
#include <raybundle/models/robust_loss.h>
#include <raybundle/models/statistics.h>

/// What `raybundle eval` finds out, for people and for programs.
namespace raybundle::tools {

struct Evaluation {
  std::string source;  ///< the INPUT
  std::int64_t cameras = 0;
  std::int64_t points = 0;
  std::int64_t observations = 0;
  RobustLoss loss;
  double cost = 0;  ///< with the loss
  ReprojectionStatistics pixels;
  std::string truth_source;
  std::optional<TruthErrors> truth;
};

/// A table.
std::string evaluation_report(const Evaluation& evaluation);

/// JSON, numbers with all digits, what is not finite null:
///   schema 1, version, build
///   problem{source, cameras, points, observations}
///   cost (with the loss), pixel_cost (without), rmse, largest, behind_cameras
///   loss{kind, scope, scale}, null where there is none
///   truth{source, cameras, points (that were compared), camera_rmse, point_rmse,
///     point_median, rotation_mean_degrees, camera_scale, point_scale (of the alignments),
///     point_rmse_by_cameras, point_median_own}, null where there is none. Of the points, the RMSE
///     belongs to their own alignment and the median to the cameras', unless the key says
///     otherwise; all five are null for a truth of cameras alone
std::string evaluation_json(const Evaluation& evaluation);

/// One line per camera: camera, observations, rmse, largest, x, y, z (the centre) and, with a
/// truth, error after the alignment of the cameras (nan for cameras nobody observes). Throws
/// std::system_error.
void write_cameras_csv(const std::string& output, const Problem& problem,
                       const ReprojectionBreakdown& breakdown,
                       const std::optional<TruthErrors>& truth);

/// The same per point; no error for a truth of cameras alone.
void write_points_csv(const std::string& output, const Problem& problem,
                      const ReprojectionBreakdown& breakdown,
                      const std::optional<TruthErrors>& truth);

}  // namespace raybundle::tools
