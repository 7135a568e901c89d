#include <raybundle/tools/rotations_report.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include <raybundle/tools/report.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;

Json stage_json(const init::AngleStatistics& angles) {
  return {{"mean", degrees(angles.mean)},
          {"median", degrees(angles.median)},
          {"upper_decile", degrees(angles.upper_decile)},
          {"largest", degrees(angles.largest)}};
}

std::int64_t known(const RotationsRecord& record) {
  return std::count(record.found.known.begin(), record.found.known.end(), 1);
}
std::int64_t pruned(const RotationsRecord& record) {
  return std::count(record.found.pruned.begin(), record.found.pruned.end(), 1);
}

// By the names of the file, off by so many degrees; null where their images are not known.
Json pruned_json(const RotationsRecord& record) {
  Json result = Json::array();
  for (std::size_t k = 0; k < record.edges.size(); ++k) {
    if (record.found.pruned[k] == 0) continue;
    const init::RelativeRotation& edge = record.edges[k];
    result.push_back({{"i", record.image[static_cast<std::size_t>(edge.i)]},
                      {"j", record.image[static_cast<std::size_t>(edge.j)]},
                      {"angle", degrees(record.found.angle[k])}});
  }
  return result;
}

}  // namespace

Json angles_json(const init::AveragedRotations& found) {
  return {{"tree", found.tree ? stage_json(*found.tree) : Json()},
          {"chordal", found.chordal ? stage_json(*found.chordal) : Json()},
          {"before", stage_json(found.before)},
          {"after", stage_json(found.after)}};
}

std::string angles_text(const init::AngleStatistics& angles) {
  return format("mean %.3g, median %.3g, nine of ten below %.3g, largest %.3g degrees",
                degrees(angles.mean), degrees(angles.median), degrees(angles.upper_decile),
                degrees(angles.largest));
}

std::string rotations_report(const RotationsRecord& record) {
  const init::AveragedRotations& found = record.found;
  Table table;
  table.add("pairs", record.source + ": " +
                         count_text(static_cast<std::int64_t>(record.edges.size()), "pair") +
                         " of " +
                         count_text(static_cast<std::int64_t>(record.image.size()), "image"));
  table.add("along a tree", angles_text(found.tree.value_or(init::AngleStatistics{})));
  table.add("chordal", angles_text(found.chordal.value_or(init::AngleStatistics{})));
  table.add("averaged", angles_text(found.before));
  table.add("", count_text(pruned(record), "pair") +
                    format(" off by more than %g degrees; without them", record.prune));
  table.add("", angles_text(found.after));
  table.add("known", count_text(known(record), "image"));
  table.add("threads", std::to_string(record.threads));
  table.add("time", format("%.3f s, %d iterations", record.seconds, found.iterations));
  if (!record.output.empty()) table.add("result", record.output);
  if (!record.log.empty()) table.add("log", record.log);
  return "raybundle " + std::string(version) + "\n" + table.text();
}

std::string rotations_json(const RotationsRecord& record) {
  const Json json = {{"schema", 1},
                     {"version", version},
                     {"build", build_description},
                     {"source", record.source},
                     {"pairs", record.edges.size()},
                     {"images", record.image.size()},
                     {"prune", record.prune},
                     {"threads", record.threads},
                     {"known", known(record)},
                     {"pruned", pruned(record)},
                     {"iterations", record.found.iterations},
                     {"seconds", record.seconds},
                     {"angles", angles_json(record.found)},
                     {"pruned_pairs", pruned_json(record)}};
  return json.dump(2) + "\n";
}

}  // namespace raybundle::tools
