#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <raybundle/solver/init/rotation_averaging.h>

/// What `raybundle rotations` tells of what it did.
namespace raybundle::tools {

struct RotationsRecord {
  std::string source;
  std::vector<std::int32_t> image;            ///< what the file calls them
  std::vector<init::RelativeRotation> edges;  ///< of the pairs, by places in that list
  double prune = 0;                           ///< degrees
  int threads = 0;
  double seconds = 0;  ///< of averaging
  init::AveragedRotations found;
  std::string output, log;  ///< where the result went; empty: nowhere
};

/// For people.
std::string rotations_report(const RotationsRecord& record);

/// In JSON:
///   schema 1, version, build, source, pairs, images, prune (degrees), threads
///   known, of the images; pruned, of the pairs; iterations, seconds
///   angles{tree, chordal, before, after}{mean, median, upper_decile, largest} in degrees: how far
///     pairs are from rotations at the two starts, and before and after those beyond prune are left
///     out
///   pruned_pairs[]{i, j, angle} of those, angle null where their images are not known any more
std::string rotations_json(const RotationsRecord& record);

/// The angles of a log, in degrees; all four stages.
nlohmann::ordered_json angles_json(const init::AveragedRotations& found);
std::string angles_text(const init::AngleStatistics& angles);

}  // namespace raybundle::tools
