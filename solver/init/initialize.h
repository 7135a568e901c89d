#pragma once

#include <raybundle/solver/init/conclusion.h>
#include <raybundle/solver/init/image_pairs.h>
#include <raybundle/solver/init/positions_linear.h>
#include <raybundle/solver/init/positions_nonlinear.h>
#include <raybundle/solver/init/relative_pose.h>
#include <raybundle/solver/init/resection.h>
#include <raybundle/solver/init/restriction.h>
#include <raybundle/solver/init/rotation_averaging.h>
#include <raybundle/solver/init/view_graph.h>

#include <cstdint>
#include <vector>

namespace raybundle::init {

/// Where rotations come from: relative ones of pairs, averaged, or the problem's cameras, whose
/// rotations then stay.
enum class RotationSource { pairs, problem };
const char* name(RotationSource value);

struct InitializeOptions {
  PairOptions pairs = {};
  RelativePoseOptions relative_pose = {};
  RotationSource rotation_source = RotationSource::pairs;
  RotationOptions rotations = {};
  LinearPositionOptions linear = {};
  PositionOptions positions = {};
  ResectionOptions resection = {};
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: all cores
};

/// What became of an image.
enum class Placement {
  placed,
  resected,     ///< placed in the end, by what it sees of points that others told
  unlinked,     ///< too few points in common with any other, or no pose that fits them
  apart,        ///< not in the largest component of what is linked
  disagreeing,  ///< every edge to the rest disagrees with the rotations of the rest
  unmeasured,   ///< rays do not tell its position: no parallax to the rest, or too few that have
};
const char* name(Placement value);

/// The stages, in order, with seconds.
struct InitializeTimes {
  double sightings = 0, pairs = 0, rotations = 0, translations = 0, features = 0, linear = 0,
         positions = 0, total = 0;
};

struct InitializeReport {
  Conclusion conclusion;
  std::vector<Placement> images;           ///< of each image
  std::vector<std::uint8_t> points;        ///< 1: placed
  std::vector<std::uint8_t> observations;  ///< 1: used
  std::int64_t placed_images = 0, placed_points = 0;
  std::int64_t repeated_observations = 0;     ///< not used: of a point that the image has already
  std::int64_t impossible_observations = 0;   ///< not used: their lens cannot have made them
  std::int64_t disagreeing_observations = 0;  ///< without a say in the positions: they agree with
                                              ///< no other image on a point that others agree on
  std::int64_t pairs = 0;                     ///< of images, tried
  std::int64_t edges = 0, rotation_edges = 0, planar_edges = 0;  ///< pairs with a relative pose
  std::vector<ViewEdge> edges_found;  ///< as measured; rotations.angle and .pruned are of these
  std::int64_t pruned = 0;            ///< edges that disagreed
  std::int64_t features = 0;
  std::int64_t moved_points = 0;  ///< in the end, to where their sightings agree better
  AveragedRotations rotations;
  LinearPositions linear;
  Summary positions;
  std::int64_t resected_images = 0;  ///< of those placed
  InitializeTimes seconds;
};

/// Poses and points of a problem from its observations and lenses alone [Liu18, 3]: epipolar
/// geometries of image pairs, rotations by averaging, features without depth, positions by linear
/// and then by non-linear least squares. What could not be placed stays as it was, and the report
/// says why. One image has the identity for its rotation, unless they are given, and one stands at
/// 0; the scale is such that a step between neighbours is about 1. Does not throw for a hard
/// problem: its conclusion says how it ended, and the report has what was found until then. Throws
/// InputError when the problem is inconsistent or a pose or point is fixed, MemoryRefusal, and
/// std::system_error when a thread is refused.
InitializeReport initialize(Problem& problem, const InitializeOptions& options = {},
                            const Progress& progress = {});

/// What was placed as a problem of its own, of the observations those that are used.
Restriction placed_part(const Problem& problem, const InitializeReport& report);

}  // namespace raybundle::init
