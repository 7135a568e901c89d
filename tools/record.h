#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <raybundle/models/statistics.h>
#include <raybundle/solver/summary.h>

namespace raybundle::tools {

/// Everything the log and the report of one solve are made from.
struct SolveRecord {
  std::string source;                 ///< the INPUT, or "street" for the generated scene
  std::optional<std::uint64_t> seed;  ///< of the generated scene
  std::int64_t cameras = 0;
  std::int64_t points = 0;
  std::int64_t observations = 0;
  ReprojectionStatistics before;
  ReprojectionStatistics after;
  std::optional<RobustStatistics> robust_before, robust_after;  ///< at the final scale of a loss
  std::vector<std::string> warnings;                            ///< about the result
  double read_seconds = 0;
  double write_seconds = 0;  ///< of the solution; the log itself is not counted
  std::string output;        ///< where the solution went; empty: nowhere
  std::string log;
  Summary summary;
};

/// The log, in JSON:
///   schema 1, version, build
///   options{} all of the option table, by their names on the command line, as they took effect
///   problem{source, cameras, points, observations, seed (generated scenes only)}
///   iterations[] the members of IterationRecord; iteration 0 is the start
///   summary{} the members of Summary without the above, RMSE in pixels, with a loss (else null)
///     {initial, final}_median_residual in pixels and {initial, final}_within_loss_scale, a share
///     of the observations; warnings[], sentences about the result; peak_rss_bytes, and
///     seconds{total, setup, residual, jacobian, linear} of the solve, and of files
///     {io = read + write}, which is not part of the total
/// Whatever is not a finite number (a NaN, no time limit), and a choice that does not apply, is
/// null.
std::string log_json(const SolveRecord& record);

/// Whether the solve had a loss.
bool has_loss(const Options& options);

/// What is known before the solve to spoil it, or what it is to show; of record.before.
std::vector<std::string> start_warnings(const SolveRecord& record, const Options& effective);

/// What the file of a solution does not tell of it: points of a folder, pixels that are not square,
/// points beyond infinity.
std::vector<std::string> file_warnings(const SolveRecord& record, const Problem& problem,
                                       bool folder);

/// What a solve that ended well may still have got wrong: a loss that levels off and held the start
/// for outliers.
std::vector<std::string> result_warnings(const SolveRecord& record);

}  // namespace raybundle::tools
