#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <raybundle/solver/init/incremental.h>
#include <raybundle/solver/init/initialize.h>

/// What `raybundle init` tells of what it did.
namespace raybundle::tools {

struct InitRecord {
  std::string source;
  std::int64_t cameras = 0, points = 0, observations = 0;
  std::uint64_t seed = 0;
  init::RotationSource rotation_source = init::RotationSource::pairs;
  int threads = 0;
  double read_seconds = 0;
  std::string output, log;                       ///< where the result went; empty: nowhere
  std::optional<init::InitializeReport> global;  ///< one of the two
  std::optional<init::IncrementalReport> incremental;
};

/// How it ended, of whichever pipeline.
const init::Conclusion& conclusion(const InitRecord& record);

/// For people.
std::string init_report(const InitRecord& record);

/// In JSON:
///   schema 1, version, build
///   problem{source, cameras, points, observations}, pipeline global or incremental, seed, threads
///   ending, a word (solver/init/conclusion.h), and message, null where all went well
///   placed{cameras, points}, images[] a word for each camera of the input: placed, or why not
///     (solver/init/initialize.h; incremental: left out); those placed are the cameras of the
///     output, in the same order
/// of the incremental pipeline
///   bundle_adjustments, failed_adjustments, resections,
///   seconds{read, pairs, bundle_adjustments, total}
/// and of the global one
///   observations{repeated, impossible, disagreeing} (solver/init/initialize.h)
///   pairs{tried, edges, planar, rotation_only, pruned}
///   edges[] the pairs with a pose: {i, j, kind general, planar or rotation, common, inliers,
///     parallax and angle off the rotations in degrees, null where not known, pruned}
///   rotations{from, iterations, angles{}}, angles as in rotations_report.h
///   positions{features, rays, rays_behind, rounds, admm_steps, converged, termination, iterations,
///     initial_cost, final_cost, null where it did not come to the positions, and moved_points}
///   seconds{} by stage, read, total
std::string init_json(const InitRecord& record);

}  // namespace raybundle::tools
