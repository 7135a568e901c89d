#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/problem.h>

#include <cstdint>
#include <string>
#include <vector>

namespace raybundle {

/// How well a problem's cameras and points explain its observations (plain pixels, no loss).
struct ReprojectionStatistics {
  double cost = 0;                 ///< 1/2 sum |u - observed|^2, pixels^2
  double rmse = 0;                 ///< sqrt(sum |u - observed|^2 / observations), pixels
  double largest = 0;              ///< largest |u - observed|, pixels
  std::int64_t behind_camera = 0;  ///< observations whose point lies behind the camera (z >= 0)
};

/// Of a valid problem. Cost and RMSE are not finite when a point lies in the plane of a camera that
/// observes it.
ReprojectionStatistics reprojection_statistics(const Problem& problem);
/// The same bits, by a number of threads.
ReprojectionStatistics reprojection_statistics(const Problem& problem, linalg::ThreadPool& pool);

/// The residuals of one camera, or of one point.
struct ResidualSummary {
  std::int64_t observations = 0;
  double rmse = 0;     ///< as above, pixels; 0 without observations
  double largest = 0;  ///< largest |u - observed|, pixels
};

/// Who has which residuals. Not finite where reprojection_statistics() is not.
struct ReprojectionBreakdown {
  std::vector<ResidualSummary> cameras;  ///< per camera
  std::vector<ResidualSummary> points;   ///< per point
};

/// Of a valid problem, in one pass over the observations.
ReprojectionBreakdown reprojection_breakdown(const Problem& problem);

/// The value that half of them are not above, the upper one of two; 0 of nothing.
double upper_median(std::vector<double> values);

/// The upper median of |u - observed| of each camera, pixels; what cannot be projected counts as
/// infinite. 0 of no observations.
std::vector<double> median_residuals(const Problem& problem);

/// What a few observations far off do not change.
struct RobustStatistics {
  double median = 0;        ///< upper median of |u - observed|, pixels; infinite as above
  std::int64_t within = 0;  ///< observations with |u - observed| up to the scale
};

/// Of a valid problem; `scale` in pixels.
RobustStatistics robust_statistics(const Problem& problem, double scale);

/// Points that their observers can hardly place, as points and cameras are now. Of those that two
/// or more cameras observe:
struct ParallaxStatistics {
  /// The rays from the camera centres to the point differ by less than 1 degree.
  std::int64_t low = 0;
  /// The observers move along their view of it: all their rays to the point are within 1 degree of
  /// the line through the two observers that are farthest from one another, either way along it.
  /// Where on that line the point is remains hardly determined, as near as it may be [Liu18, 1].
  /// Not counted where all observers stand at one place.
  std::int64_t collinear = 0;
};

/// Of a valid problem. Exact up to 32 observations of a point; beyond that the largest angle and
/// distance are searched from one to the farthest from it, and may be missed by a little.
ParallaxStatistics parallax_statistics(const Problem& problem);

/// The shape of a problem: degrees, connectivity and how well the points are determined.
/// The first_... members are indices, -1 where there is none.
struct StructureStatistics {
  std::int64_t cameras = 0;
  std::int64_t points = 0;
  std::int64_t observations = 0;
  std::int64_t unobserved_cameras = 0;
  std::int64_t unobserved_points = 0;
  std::int64_t points_seen_once = 0;        ///< points that exactly one camera observes
  std::int64_t duplicate_observations = 0;  ///< a camera observing the same point again
  std::int64_t components = 0;              ///< connected sets of observed cameras
  std::int64_t largest_component = 0;       ///< cameras in the largest of them
  std::int64_t camera_pairs = 0;            ///< pairs of cameras that share a point
  std::int64_t low_parallax_points = 0;     ///< ParallaxStatistics::low
  std::int64_t collinear_points = 0;        ///< ParallaxStatistics::collinear
  double mean_track_length = 0;             ///< observations per observed point
  std::int64_t longest_track = 0;           ///< observations
  std::int64_t fewest_observations = 0;     ///< of an observed camera
  std::int64_t most_observations = 0;       ///< of a camera

  std::int64_t first_unobserved_camera = -1;
  std::int64_t first_unobserved_point = -1;
  std::int64_t first_point_seen_once = -1;
  std::int64_t first_duplicate_camera = -1;  ///< of the first point observed twice by a camera ...
  std::int64_t first_duplicate_point = -1;   ///< ... and that point
};

/// Of a valid problem. Memory grows with observations + cameras + points; time too, but for
/// camera_pairs: for each observation at most as many operations as its track is long or as there
/// are cameras / 64, whichever is less.
StructureStatistics structure_statistics(const Problem& problem);

/// The same without camera_pairs and parallax, which take longer than all else.
StructureStatistics degree_statistics(const Problem& problem);

/// Sentences about what is legal but deserves attention (cameras or points nobody observes, ...).
std::vector<std::string> warnings(const StructureStatistics& structure);

}  // namespace raybundle
