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
  int threads = 0;
  double read_seconds = 0;
  std::string output, log;                       ///< where the result went; empty: nowhere
  std::optional<init::InitializeReport> global;  ///< one of the two
  std::optional<init::IncrementalReport> incremental;
};

/// For people.
std::string init_report(const InitRecord& record);

/// In JSON:
///   schema 1, version, build
///   problem{source, cameras, points, observations}, pipeline global or incremental, seed, threads
///   placed{cameras, points}, images[] a word for each camera of the input: placed, or why not
///     (solver/init/initialize.h; incremental: left out); those placed are the cameras of the
///     output, in the same order
/// of the incremental pipeline
///   bundle_adjustments, resections, seconds{read, pairs, bundle_adjustments, total}
/// and of the global one
///   unused_observations, which their lens cannot have made
///   pairs{tried, edges, planar, rotation_only, pruned}
///   rotations{tree, chordal, before, after}{mean, median, upper_decile, largest} in degrees, and
///     iterations
///   positions{features, rows, rows_behind, admm_steps, iterations, initial_cost, final_cost}
///   seconds{} by stage, read, total
std::string init_json(const InitRecord& record);

}  // namespace raybundle::tools
