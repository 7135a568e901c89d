#include <raybundle/solver/init/initialize.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/alignment.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/init/edge_translations.h>
#include <raybundle/solver/init/features.h>
#include <raybundle/solver/init/point_agreement.h>
#include <raybundle/solver/init/sightings.h>
#include <raybundle/solver/phase_timer.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

std::vector<std::uint8_t> placed_images(const InitializeReport& report) {
  std::vector<std::uint8_t> result;
  result.reserve(report.images.size());
  for (const Placement each : report.images) {
    result.push_back(each == Placement::placed || each == Placement::resected ? 1 : 0);
  }
  return result;
}

// One call of initialize(): its stages, in order. Each returns whether to go on, and if not has put
// into the report why.
class Initialization {
 public:
  Initialization(Problem& problem, const InitializeOptions& options, const Progress& progress)
      : problem_(problem),
        options_(options),
        progress_(progress),
        pool_(options.threads > 0 ? options.threads : linalg::available_threads()) {}

  InitializeReport run() {
    {
      const PhaseTimer timer(report_.seconds.total);
      static_cast<void>(see() && find_relative_poses() && average() && measure_translations() &&
                        find_features() && place_images() && register_placed());
      resect_rest();
    }
    report_.edges_found = std::move(graph_.edges);
    return std::move(report_);
  }

 private:
  bool end(Ending ending, std::string message) {
    report_.conclusion = {ending, std::move(message)};
    return false;
  }
  Control say(const char* stage, std::int64_t done = 0, std::int64_t all = 0) const {
    return progress_ ? progress_(stage, done, all) : Control::proceed;
  }
  bool begin(const char* stage) { return say(stage) == Control::proceed || interrupted_at(stage); }
  bool interrupted_at(const char* stage) {
    return end(Ending::interrupted, std::string("interrupted at: ") + stage);
  }

  bool see() {
    const PhaseTimer timer(report_.seconds.sightings);
    refuse_fixed(problem_);
    sightings_.emplace(problem_, pool_);
    report_.images.assign(index(problem_.camera_count()), Placement::unlinked);
    report_.points.assign(index(problem_.point_count()), 0);
    report_.observations.assign(index(problem_.observation_count()), 0);
    for (std::int64_t s = 0; s < sightings_->size(); ++s) {
      report_.observations[index(sightings_->observation(s))] = 1;
    }
    report_.repeated_observations = sightings_->repeated();
    report_.impossible_observations = sightings_->impossible();
    return begin("rays");
  }

  bool find_relative_poses() {
    const PhaseTimer timer(report_.seconds.pairs);
    const auto pairs = image_pairs(*sightings_, options_.pairs, pool_);
    report_.pairs = static_cast<std::int64_t>(pairs.size());
    graph_ =
        view_graph(*sightings_, pairs, options_.relative_pose, options_.seed, pool_, progress_);
    report_.edges = static_cast<std::int64_t>(graph_.edges.size());
    for (const ViewEdge& edge : graph_.edges) {
      report_.rotation_edges += edge.kind == PairKind::rotation ? 1 : 0;
      report_.planar_edges += edge.kind == PairKind::planar ? 1 : 0;
    }
    if (graph_.stopped) return interrupted_at("pairs");
    if (!graph_.edges.empty()) return true;
    if (pairs.empty()) {
      return end(Ending::no_pose, "no two images have " +
                                      std::to_string(options_.pairs.min_common) +
                                      " points in common; expected at least two that do");
    }
    return end(Ending::no_pose, "no two images with a relative pose; expected at least " +
                                    std::to_string(options_.relative_pose.min_inliers) +
                                    " points in common that fit one");
  }

  bool average() {
    const PhaseTimer timer(report_.seconds.rotations);
    if (!begin("rotations")) return false;
    std::vector<RelativeRotation> edges;
    edges.reserve(graph_.edges.size());
    for (const ViewEdge& edge : graph_.edges) {
      const auto weight = static_cast<double>(edge.inliers);
      edges.push_back({edge.i, edge.j, edge.pose.R, weight, edge.R_other});
    }
    report_.rotations = options_.rotation_source == RotationSource::problem
                            ? given_rotations(camera_rotations(problem_), edges, options_.rotations)
                            : average_rotations(graph_.images, edges, options_.rotations, pool_);
    const std::vector<std::uint8_t>& pruned = report_.rotations.pruned;
    report_.pruned = std::count(pruned.begin(), pruned.end(), 1);
    classify_images();
    if (report_.pruned < report_.edges) return true;
    std::ostringstream message;
    message << "every pair disagrees with the rotations; expected some within "
            << options_.rotations.prune << " degrees";
    return end(Ending::disagreement, message.str());
  }

  bool measure_translations() {
    const PhaseTimer timer(report_.seconds.translations);
    if (!begin("translations")) return false;
    measured_ =
        with_rotations(*sightings_, graph_, report_.rotations, options_.relative_pose, pool_);
    return true;
  }

  bool find_features() {
    const PhaseTimer timer(report_.seconds.features);
    if (!begin("features")) return false;
    features_ = features(*sightings_, measured_, report_.rotations.R_cw, report_.rotations.known,
                         options_.relative_pose.threshold, pool_);
    report_.features = static_cast<std::int64_t>(features_.all.size());
    return true;
  }

  bool place_images() {
    const PhaseTimer timer(report_.seconds.linear);
    if (!begin("positions, linear")) return false;
    const AveragedRotations& rotations = report_.rotations;
    report_.linear = linear_positions(*sightings_, features_.all, rotations.R_cw, rotations.known,
                                      rotations.root, options_.linear, pool_);
    classify_images();
    report_.placed_images =
        std::count(report_.images.begin(), report_.images.end(), Placement::placed);
    if (report_.linear.rays > 0 && report_.linear.rounds == 0) {
      return end(Ending::not_computable, "the linear system of positions has no solution");
    }
    if (report_.placed_images < 2) {
      return end(Ending::no_parallax,
                 "no two images with parallax between them; expected points "
                 "that two images see along different directions");
    }
    write_poses();
    return true;
  }

  // By the stages so far.
  void classify_images() {
    std::vector<WeightedEdge> links;
    std::vector<std::uint8_t> linked(index(graph_.images), 0);
    for (const ViewEdge& edge : graph_.edges) {
      links.push_back({edge.i, edge.j, 1});
      linked[index(edge.i)] = linked[index(edge.j)] = 1;
    }
    const Components parts = components(graph_.images, links);
    const std::vector<std::uint8_t>& positioned = report_.linear.known;
    for (std::int32_t i = 0; i < graph_.images; ++i) {
      const std::size_t at = index(i);
      report_.images[at] = linked[at] == 0                             ? Placement::unlinked
                           : !parts.in_largest(i)                      ? Placement::apart
                           : report_.rotations.known[at] == 0          ? Placement::disagreeing
                           : positioned.empty() || positioned[at] == 0 ? Placement::unmeasured
                                                                       : Placement::placed;
    }
  }

  void write_poses() {
    const double scale = unit_scale();
    for (std::int64_t i = 0; i < sightings_->images(); ++i) {
      if (report_.images[index(i)] != Placement::placed) continue;
      const Matrix3d& R = report_.rotations.R_cw[index(i)];
      write_pose(i, {R, -(R * report_.linear.P[index(i)]) * scale});
    }
  }

  void write_pose(std::int64_t image, const CameraPose& pose) {
    double* camera = problem_.cameras.data() + Problem::camera_size * image;
    Eigen::Map<Vector3d> rotation(camera), translation(camera + 3);
    rotation = so3::log(pose.R_cw);
    translation = pose.t_cw;
  }

  // So that the median distance between images of an edge with a translation is 1.
  double unit_scale() const {
    std::vector<double> distances;
    for (const ViewEdge& edge : measured_.edges) {
      if (report_.linear.known[index(edge.i)] == 0 || report_.linear.known[index(edge.j)] == 0)
        continue;
      if (edge.pose.t.isZero(0)) continue;
      distances.push_back(
          (report_.linear.P[index(edge.i)] - report_.linear.P[index(edge.j)]).norm());
    }
    const double median = upper_median(std::move(distances));
    return median > 0 ? 1 / median : 1;
  }

  // All points that a placed image saw; those of one sighting alone are put as far as most.
  bool register_placed() {
    const PhaseTimer timer(report_.seconds.positions);
    std::fill(report_.points.begin(), report_.points.end(), 1);
    Restriction part = part_in_agreement();
    std::fill(report_.points.begin(), report_.points.end(), 0);
    for (const std::int32_t point : part.point) report_.points[index(point)] = 1;
    report_.placed_points = static_cast<std::int64_t>(part.point.size());
    PositionOptions options = options_.positions;
    options.threads = pool_.threads();
    bool stopped = false;
    report_.positions = register_positions(part.problem, options, [&](const IterationRecord& each) {
      stopped = say("positions", each.iteration, options.max_iterations) == Control::stop;
      return stopped ? Control::stop : Control::proceed;
    });
    part.write_back(problem_);
    move_points();
    if (stopped) return interrupted_at("positions");
    if (report_.positions.usable()) return true;
    return end(Ending::not_computable, "positions: " + report_.positions.message);
  }

  void move_points() {
    report_.moved_points += move_to_agreement(*sightings_, placed_images(report_), report_.points,
                                              options_.relative_pose.threshold, problem_, pool_);
  }

  // Images that could not be placed with the others: a few points that these agree on will do.
  void resect_rest() {
    if (report_.placed_images == 0) return;
    const PhaseTimer timer(report_.seconds.positions);
    const std::vector<std::uint8_t> told = points_of_two();
    std::vector<std::optional<Resection>> found(report_.images.size());
    pool_.run(sightings_->images(), [&](std::int64_t i) {
      if (report_.images[index(i)] == Placement::placed) return;
      Random random(options_.seed, static_cast<std::uint64_t>(i));
      const SeenPoints seen =
          seen_points(*sightings_, static_cast<std::int32_t>(i), told, problem_);
      const auto one = resection(seen, options_.resection, random);
      const auto agreeing = one ? static_cast<std::int64_t>(one->inliers.size()) : 0;
      if (2 * agreeing > seen.size()) found[index(i)] = one;
    });
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i]) continue;
      write_pose(static_cast<std::int64_t>(i), found[i]->pose);
      report_.images[i] = Placement::resected;
      ++report_.resected_images, ++report_.placed_images;
    }
    if (report_.resected_images > 0) move_points();  // those that one other image alone saw
  }

  // Points that two placed images see.
  std::vector<std::uint8_t> points_of_two() const {
    const std::vector<std::uint8_t> placed = placed_images(report_);
    std::vector<std::uint8_t> result(report_.points.size(), 0);
    for (std::int64_t p = 0; p < sightings_->points(); ++p) {
      const Sightings::Range track = sightings_->of_point(p);
      int seen = 0;
      for (std::int64_t s = track.first; s < track.last; ++s) {
        seen += placed[index(sightings_->image(s))];
      }
      result[index(p)] = seen >= 2 ? 1 : 0;
    }
    return result;
  }

  // What is placed but for observations that disagree, where a point keeps two or more.
  Restriction part_in_agreement() {
    std::vector<std::uint8_t> used = report_.observations;
    for (std::int64_t p = 0; p < sightings_->points(); ++p) {
      const Sightings::Range track = sightings_->of_point(p);
      const auto first = features_.disagreeing.begin();
      const auto wrong = std::count(first + track.first, first + track.last, 1);
      if (track.size() - wrong < 2) continue;
      report_.disagreeing_observations += wrong;
      for (std::int64_t s = track.first; s < track.last; ++s) {
        if (features_.disagreeing[index(s)] != 0) used[index(sightings_->observation(s))] = 0;
      }
    }
    return restricted(problem_, {placed_images(report_), report_.points, used});
  }

  Problem& problem_;
  const InitializeOptions& options_;
  const Progress& progress_;
  linalg::ThreadPool pool_;
  std::optional<Sightings> sightings_;
  ViewGraph graph_, measured_;
  Features features_;
  InitializeReport report_;
};

}  // namespace

const char* name(RotationSource value) {
  switch (value) {
    case RotationSource::pairs:
      return "pairs";
    case RotationSource::problem:
      return "problem";
  }
  return "?";
}

const char* name(Placement value) {
  switch (value) {
    case Placement::placed:
      return "placed";
    case Placement::resected:
      return "resected";
    case Placement::unlinked:
      return "unlinked";
    case Placement::apart:
      return "apart";
    case Placement::disagreeing:
      return "disagreeing";
    case Placement::unmeasured:
      return "unmeasured";
  }
  return "?";
}

InitializeReport initialize(Problem& problem, const InitializeOptions& options,
                            const Progress& progress) {
  return Initialization(problem, options, progress).run();
}

Restriction placed_part(const Problem& problem, const InitializeReport& report) {
  const std::vector<std::uint8_t> images = placed_images(report);
  return restricted(problem, {images, report.points, report.observations});
}

}  // namespace raybundle::init
