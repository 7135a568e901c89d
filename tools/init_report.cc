#include <raybundle/tools/init_report.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include <raybundle/tools/report.h>
#include <raybundle/tools/rotations_report.h>
#include <raybundle/version.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;
using init::Placement;

std::string reason(Placement placement) {
  switch (placement) {
    case Placement::placed:
      return "placed";
    case Placement::resected:
      return "placed by what they see of the points of the others";
    case Placement::unlinked:
      return "no pair with enough points in common that fit one pose";
    case Placement::apart:
      return "not connected with the largest group";
    case Placement::disagreeing:
      return "all their pairs disagree with the rotations of the rest";
    case Placement::unmeasured:
      return "rays do not tell their position";
  }
  return "?";
}

void add_left_out(const InitRecord& record, Table& table) {
  const auto& images = record.global->images;
  const std::int64_t resected = record.global->resected_images;
  if (resected > 0) {
    table.add("of these", count_text(resected, "camera") + ": " + reason(Placement::resected));
  }
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

void add_rotations(const InitRecord& record, Table& table) {
  const init::InitializeReport& r = *record.global;
  if (r.rotations.R_cw.empty()) return;
  const bool given = record.rotation_source == init::RotationSource::problem;
  table.add("rotations", std::string(given ? "of the problem" : "averaged") +
                             "; pairs disagree by " + angles_text(r.rotations.before));
  table.add("", format("%lld pairs left out; then %s", static_cast<long long>(r.pruned),
                       angles_text(r.rotations.after).c_str()));
}

void add_positions(const init::InitializeReport& r, Table& table) {
  if (r.positions.iterations.empty()) return;
  table.add("positions",
            format("from %lld features in %lld rays, %lld behind at first%s",
                   static_cast<long long>(r.features), static_cast<long long>(r.linear.rays),
                   static_cast<long long>(r.linear.rays_behind),
                   r.linear.converged ? "" : "; some may still be, the steps were used up"));
  table.add("", format("cost of rays %.6e -> %.6e in %zu iterations", r.positions.initial_cost,
                       r.positions.final_cost, r.positions.iterations.size() - 1));
  if (r.disagreeing_observations > 0) {
    table.add("", count_text(r.disagreeing_observations, "observation") +
                      " without a say: they disagree with the rest of their points");
  }
  if (r.moved_points > 0) {
    table.add("", count_text(r.moved_points, "point") +
                      " moved in the end to where more of their observations agree");
  }
}

void add_unused(const init::InitializeReport& r, Table& table) {
  if (r.repeated_observations > 0) {
    table.add("not used", count_text(r.repeated_observations, "observation") +
                              " of a point that the image has already");
  }
  if (r.impossible_observations > 0) {
    table.add("not used", count_text(r.impossible_observations, "observation") +
                              " that their lens cannot have made");
  }
}

void add_global(const InitRecord& record, Table& table) {
  const init::InitializeReport& r = *record.global;
  add_placed(record, r.placed_images, r.placed_points, table);
  add_left_out(record, table);
  add_unused(r, table);
  table.add("pairs", format("%lld tried, %lld with a pose (%lld planar, %lld of rotation alone)",
                            static_cast<long long>(r.pairs), static_cast<long long>(r.edges),
                            static_cast<long long>(r.planar_edges),
                            static_cast<long long>(r.rotation_edges)));
  add_rotations(record, table);
  add_positions(r, table);
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

Json edges_json(const init::InitializeReport& r) {
  Json edges = Json::array();
  for (std::size_t k = 0; k < r.edges_found.size(); ++k) {
    const init::ViewEdge& edge = r.edges_found[k];
    const bool judged = !r.rotations.angle.empty();
    edges.push_back({{"i", edge.i},
                     {"j", edge.j},
                     {"kind", name(edge.kind)},
                     {"common", edge.common},
                     {"inliers", edge.inliers},
                     {"parallax", degrees(edge.parallax)},
                     {"angle", judged ? Json(degrees(r.rotations.angle[k])) : Json()},
                     {"pruned", judged && r.rotations.pruned[k] != 0}});
  }
  return edges;
}

Json positions_json(const init::InitializeReport& r) {
  const bool solved = !r.positions.iterations.empty();
  return {{"features", r.features},
          {"rays", r.linear.rays},
          {"rays_behind", r.linear.rays_behind},
          {"rounds", r.linear.rounds},
          {"admm_steps", r.linear.admm_steps},
          {"converged", r.linear.converged},
          {"termination", solved ? Json(name(r.positions.termination)) : Json()},
          {"iterations", solved ? Json(r.positions.iterations.size() - 1) : Json()},
          {"initial_cost", solved ? Json(r.positions.initial_cost) : Json()},
          {"final_cost", solved ? Json(r.positions.final_cost) : Json()},
          {"moved_points", r.moved_points}};
}

Json global_json(const InitRecord& record) {
  const init::InitializeReport& r = *record.global;
  const init::InitializeTimes& s = r.seconds;
  Json images = Json::array();
  for (const Placement each : r.images) images.push_back(name(each));
  return {{"observations",
           {{"repeated", r.repeated_observations},
            {"impossible", r.impossible_observations},
            {"disagreeing", r.disagreeing_observations}}},
          {"placed", {{"cameras", r.placed_images}, {"points", r.placed_points}}},
          {"images", images},
          {"pairs",
           {{"tried", r.pairs},
            {"edges", r.edges},
            {"planar", r.planar_edges},
            {"rotation_only", r.rotation_edges},
            {"pruned", r.pruned}}},
          {"edges", edges_json(r)},
          {"rotations",
           {{"from", name(record.rotation_source)},
            {"iterations", r.rotations.iterations},
            {"angles", angles_json(r.rotations)}}},
          {"positions", positions_json(r)},
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
          {"failed_adjustments", r.failed_adjustments},
          {"resections", r.resections},
          {"seconds",
           {{"read", record.read_seconds},
            {"pairs", r.pair_seconds},
            {"bundle_adjustments", r.bundle_seconds},
            {"total", r.seconds}}}};
}

}  // namespace

const init::Conclusion& conclusion(const InitRecord& record) {
  return record.global ? record.global->conclusion : record.incremental->conclusion;
}

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
  Json json = {
      {"schema", 1},
      {"version", version},
      {"build", build_description},
      {"problem",
       {{"source", record.source},
        {"cameras", record.cameras},
        {"points", record.points},
        {"observations", record.observations}}},
      {"pipeline", record.global ? "global" : "incremental"},
      {"seed", record.seed},
      {"threads", record.threads},
      {"ending", name(conclusion(record).ending)},
      {"message", conclusion(record).message.empty() ? Json() : Json(conclusion(record).message)}};
  json.update(record.global ? global_json(record) : incremental_json(record));
  return json.dump(2) + "\n";
}

}  // namespace raybundle::tools
