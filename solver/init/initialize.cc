#include <raybundle/solver/init/initialize.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/edge_translations.h>
#include <raybundle/solver/init/features.h>
#include <raybundle/solver/init/sightings.h>
#include <raybundle/solver/phase_timer.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

// One call of initialize(): its stages, in order.
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
      see();
      find_relative_poses();
      average();
      measure_translations();
      find_features();
      place_images();
      register_placed();
    }
    return std::move(report_);
  }

 private:
  void say(const char* stage, std::int64_t done = 0, std::int64_t all = 0) const {
    if (progress_) progress_(stage, done, all);
  }

  void see() {
    const PhaseTimer timer(report_.seconds.sightings);
    say("rays");
    sightings_.emplace(problem_, pool_);
    report_.observations.assign(index(problem_.observation_count()), 0);
    for (std::int64_t s = 0; s < sightings_->size(); ++s) {
      report_.observations[index(sightings_->observation(s))] = 1;
    }
    report_.unused_observations = problem_.observation_count() - sightings_->size();
  }

  void find_relative_poses() {
    const PhaseTimer timer(report_.seconds.pairs);
    const auto pairs = image_pairs(*sightings_, options_.pairs, pool_);
    report_.pairs = static_cast<std::int64_t>(pairs.size());
    graph_ = view_graph(*sightings_, pairs, options_.relative_pose, options_.seed, pool_,
                        [&](std::int64_t done, std::int64_t all) { say("pairs", done, all); });
    report_.edges = static_cast<std::int64_t>(graph_.edges.size());
    for (const ViewEdge& edge : graph_.edges) {
      report_.rotation_edges += edge.kind == PairKind::rotation ? 1 : 0;
      report_.planar_edges += edge.kind == PairKind::planar ? 1 : 0;
    }
    if (graph_.edges.empty()) {
      throw InputError("problem", 0, "no two images with a relative pose",
                       "at least " + std::to_string(options_.relative_pose.min_inliers) +
                           " points in common that fit one");
    }
  }

  void average() {
    const PhaseTimer timer(report_.seconds.rotations);
    say("rotations");
    std::vector<RelativeRotation> edges;
    edges.reserve(graph_.edges.size());
    for (const ViewEdge& edge : graph_.edges) {
      edges.push_back({edge.i, edge.j, edge.pose.R, static_cast<double>(edge.inliers)});
    }
    report_.rotations = average_rotations(graph_.images, edges, options_.rotations, pool_);
    for (const std::uint8_t pruned : report_.rotations.pruned) report_.pruned += pruned;
  }

  void measure_translations() {
    const PhaseTimer timer(report_.seconds.translations);
    say("translations");
    measured_ =
        with_rotations(*sightings_, graph_, report_.rotations, options_.relative_pose, pool_);
  }

  void find_features() {
    const PhaseTimer timer(report_.seconds.features);
    say("features");
    features_ = features(*sightings_, measured_, report_.rotations.R_cw, report_.rotations.known,
                         options_.relative_pose.threshold, pool_);
    report_.features = static_cast<std::int64_t>(features_.size());
  }

  void place_images() {
    const PhaseTimer timer(report_.seconds.linear);
    say("positions, linear");
    const AveragedRotations& rotations = report_.rotations;
    report_.linear = linear_positions(*sightings_, features_, rotations.R_cw, rotations.known,
                                      rotations.root, options_.linear, pool_);
    classify_images();
    report_.placed_images =
        std::count(report_.images.begin(), report_.images.end(), Placement::placed);
    if (report_.placed_images < 2) {
      throw InputError("problem", 0, "no two images with parallax between them",
                       "points that two images see along different directions");
    }
    const double scale = unit_scale();
    for (std::int64_t i = 0; i < sightings_->images(); ++i) {
      if (report_.images[index(i)] != Placement::placed) continue;
      double* camera = problem_.cameras.data() + Problem::camera_size * i;
      const Matrix3d& R = rotations.R_cw[index(i)];
      Eigen::Map<Vector3d> rotation(camera), translation(camera + 3);
      rotation = so3::log(R);
      translation = -(R * report_.linear.P[index(i)]) * scale;
    }
  }

  void classify_images() {
    std::vector<WeightedEdge> links;
    std::vector<std::uint8_t> linked(index(graph_.images), 0);
    for (const ViewEdge& edge : graph_.edges) {
      links.push_back({edge.i, edge.j, 1});
      linked[index(edge.i)] = linked[index(edge.j)] = 1;
    }
    const Components parts = components(graph_.images, links);
    for (std::int32_t i = 0; i < graph_.images; ++i) {
      report_.images.push_back(linked[index(i)] == 0                    ? Placement::unlinked
                               : !parts.in_largest(i)                   ? Placement::apart
                               : report_.rotations.known[index(i)] == 0 ? Placement::disagreeing
                               : report_.linear.known[index(i)] == 0    ? Placement::unmeasured
                                                                        : Placement::placed);
    }
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
    if (distances.empty()) return 1;
    const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle > 0 ? 1 / *middle : 1;
  }

  // All points that a placed image saw; those of one sighting alone are put as far as most.
  void register_placed() {
    const PhaseTimer timer(report_.seconds.positions);
    say("positions");
    report_.points.assign(index(problem_.point_count()), 1);
    Restriction part = placed_part(problem_, report_);
    report_.points.assign(index(problem_.point_count()), 0);
    for (const std::int32_t point : part.point) report_.points[index(point)] = 1;
    report_.placed_points = static_cast<std::int64_t>(part.point.size());
    PositionOptions options = options_.positions;
    options.threads = pool_.threads();
    report_.positions = register_positions(part.problem, options, [&](const IterationRecord& each) {
      say("positions", each.iteration, options.max_iterations);
      return Control::proceed;
    });
    part.write_back(problem_);
  }

  Problem& problem_;
  const InitializeOptions& options_;
  const Progress& progress_;
  linalg::ThreadPool pool_;
  std::optional<Sightings> sightings_;
  ViewGraph graph_, measured_;
  std::vector<Feature> features_;
  InitializeReport report_;
};

}  // namespace

const char* name(Placement value) {
  switch (value) {
    case Placement::placed:
      return "placed";
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
  std::vector<std::uint8_t> images;
  images.reserve(report.images.size());
  for (const Placement each : report.images) images.push_back(each == Placement::placed ? 1 : 0);
  return restricted(problem, {images, report.points, report.observations});
}

}  // namespace raybundle::init
