#include <raybundle/tools/init_report.h>

#include <algorithm>
#include <numbers>

#include <nlohmann/json.hpp>

#include <raybundle/tools/report.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;
using init::Placement;

double degrees(double radians) { return radians * 180 / std::numbers::pi; }

Json angles_json(const init::AngleStatistics& angles) {
  return {{"mean", degrees(angles.mean)},
          {"median", degrees(angles.median)},
          {"upper_decile", degrees(angles.upper_decile)},
          {"largest", degrees(angles.largest)}};
}

std::string angles_text(const init::AngleStatistics& angles) {
  return format("median %.3g, nine of ten below %.3g, largest %.3g degrees", degrees(angles.median),
                degrees(angles.upper_decile), degrees(angles.largest));
}

std::string reason(Placement placement) {
  switch (placement) {
    case Placement::placed:
      return "placed";
    case Placement::unlinked:
      return "no pair with enough points in common that fit one pose";
    case Placement::apart:
      return "not connected with the largest group";
    case Placement::disagreeing:
      return "all their pairs disagree with the rotations of the rest";
    case Placement::unmeasured:
      return "no parallax to any of the rest";
  }
  return "?";
}

void add_left_out(const InitRecord& record, Table& table) {
  const auto& images = record.global->images;
  for (const Placement each :
       {Placement::unlinked, Placement::apart, Placement::disagreeing, Placement::unmeasured}) {
    const auto count = std::count(images.begin(), images.end(), each);
    if (count > 0) table.add("left out", count_text(count, "camera") + ": " + reason(each));
  }
}

void add_stages(const init::InitializeTimes& s, Table& table) {
  table.add("time", format("%13.3f s", s.total));
  for (const auto& [stage, seconds] : {std::pair("rays", s.sightings),
                                       {"pairs", s.pairs},
                                       {"rotations", s.rotations},
                                       {"translations", s.translations},
                                       {"features", s.features},
                                       {"positions, linear", s.linear},
                                       {"positions", s.positions}}) {
    table.add(std::string("  ") + stage,
              format("%13.3f s  %5.1f %%", seconds, 100 * seconds / s.total));
  }
}

void add_placed(const InitRecord& record, std::int64_t images, std::int64_t points, Table& table) {
  table.add("problem", record.source + ": " + count_text(record.cameras, "camera") + ", " +
                           count_text(record.points, "point") + ", " +
                           count_text(record.observations, "observation"));
  table.add("placed", count_text(images, "camera") + " (" + percent_text(images, record.cameras) +
                          "), " + count_text(points, "point") + " (" +
                          percent_text(points, record.points) + ")");
}

void add_global(const InitRecord& record, Table& table) {
  const init::InitializeReport& r = *record.global;
  add_placed(record, r.placed_images, r.placed_points, table);
  add_left_out(record, table);
  table.add("pairs", format("%lld tried, %lld with a pose (%lld planar, %lld of rotation alone)",
                            static_cast<long long>(r.pairs), static_cast<long long>(r.edges),
                            static_cast<long long>(r.planar_edges),
                            static_cast<long long>(r.rotation_edges)));
  table.add("rotations", "disagree by: " + angles_text(r.rotations.before));
  table.add("", format("%lld pairs left out; then %s", static_cast<long long>(r.pruned),
                       angles_text(r.rotations.after).c_str()));
  table.add("positions",
            format("from %lld features in %lld rays, %lld behind at first",
                   static_cast<long long>(r.features), static_cast<long long>(r.linear.rows),
                   static_cast<long long>(r.linear.rows_behind)));
  table.add("", format("cost of rays %.6e -> %.6e in %zu iterations", r.positions.initial_cost,
                       r.positions.final_cost, r.positions.iterations.size() - 1));
  table.add("threads", std::to_string(record.threads));
  add_stages(r.seconds, table);
}

void add_incremental(const InitRecord& record, Table& table) {
  const init::IncrementalReport& r = *record.incremental;
  add_placed(record, r.placed_images, r.placed_points, table);
  table.add("adjusted", std::to_string(r.bundle_adjustments) + " times, after " +
                            count_text(r.resections, "resection"));
  table.add("threads", std::to_string(record.threads));
  table.add("time", format("%13.3f s", r.seconds));
  table.add("  pairs", format("%13.3f s", r.pair_seconds));
  table.add("  adjustment", format("%13.3f s", r.bundle_seconds));
}

Json global_json(const InitRecord& record) {
  const init::InitializeReport& r = *record.global;
  const init::InitializeTimes& s = r.seconds;
  Json images = Json::array();
  for (const Placement each : r.images) images.push_back(name(each));
  return {{"unused_observations", r.unused_observations},
          {"placed", {{"cameras", r.placed_images}, {"points", r.placed_points}}},
          {"images", images},
          {"pairs",
           {{"tried", r.pairs},
            {"edges", r.edges},
            {"planar", r.planar_edges},
            {"rotation_only", r.rotation_edges},
            {"pruned", r.pruned}}},
          {"rotations",
           {{"tree", angles_json(r.rotations.tree)},
            {"chordal", angles_json(r.rotations.chordal)},
            {"before", angles_json(r.rotations.before)},
            {"after", angles_json(r.rotations.after)},
            {"iterations", r.rotations.iterations}}},
          {"positions",
           {{"features", r.features},
            {"rows", r.linear.rows},
            {"rows_behind", r.linear.rows_behind},
            {"admm_steps", r.linear.admm_steps},
            {"iterations", r.positions.iterations.size() - 1},
            {"initial_cost", r.positions.initial_cost},
            {"final_cost", r.positions.final_cost}}},
          {"seconds",
           {{"read", record.read_seconds},
            {"rays", s.sightings},
            {"pairs", s.pairs},
            {"rotations", s.rotations},
            {"translations", s.translations},
            {"features", s.features},
            {"linear_positions", s.linear},
            {"positions", s.positions},
            {"total", s.total}}}};
}

Json incremental_json(const InitRecord& record) {
  const init::IncrementalReport& r = *record.incremental;
  Json images = Json::array();
  for (const std::uint8_t each : r.images) images.push_back(each != 0 ? "placed" : "left out");
  return {{"placed", {{"cameras", r.placed_images}, {"points", r.placed_points}}},
          {"images", images},
          {"bundle_adjustments", r.bundle_adjustments},
          {"resections", r.resections},
          {"seconds",
           {{"read", record.read_seconds},
            {"pairs", r.pair_seconds},
            {"bundle_adjustments", r.bundle_seconds},
            {"total", r.seconds}}}};
}

}  // namespace

std::string init_report(const InitRecord& record) {
  Table table;
  if (record.global) {
    add_global(record, table);
  } else {
    add_incremental(record, table);
  }
  if (!record.output.empty()) table.add("result", record.output);
  if (!record.log.empty()) table.add("log", record.log);
  return "raybundle " + std::string(version) + "\n" + table.text();
}

std::string init_json(const InitRecord& record) {
  Json json = {{"schema", 1},
               {"version", version},
               {"build", build_description},
               {"problem",
                {{"source", record.source},
                 {"cameras", record.cameras},
                 {"points", record.points},
                 {"observations", record.observations}}},
               {"pipeline", record.global ? "global" : "incremental"},
               {"seed", record.seed},
               {"threads", record.threads}};
  json.update(record.global ? global_json(record) : incremental_json(record));
  return json.dump(2) + "\n";
}

}  // namespace raybundle::tools
