#pragma once

#include <cstdint>
#include <string>

#include <raybundle/solver/init/initialize.h>

/// What `raybundle init` tells of what it did.
namespace raybundle::tools {

struct InitRecord {
  std::string source;
  std::int64_t cameras = 0, points = 0, observations = 0;
  std::uint64_t seed = 0;
  int threads = 0;
  double read_seconds = 0;
  std::string output, log;  ///< where the result went; empty: nowhere
  init::InitializeReport report;
};

/// For people.
std::string init_report(const InitRecord& record);

/// In JSON:
///   schema 1, version, build
///   problem{source, cameras, points, observations, unused_observations}, seed, threads
///   placed{cameras, points}, images[] a word for each camera of the input: placed, unlinked,
///     apart, disagreeing or unmeasured (solver/init/initialize.h); those placed are the cameras of
///     the output, in the same order
///   pairs{tried, edges, planar, rotation_only, pruned}
///   rotations{tree, chordal, before, after}{mean, median, upper_decile, largest} in degrees, and
///     iterations
///   positions{features, rows, rows_behind, admm_steps, iterations, initial_cost, final_cost}
///   seconds{} by stage, read, total
std::string init_json(const InitRecord& record);

}  // namespace raybundle::tools
