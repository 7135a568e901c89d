#include <raybundle/solver/init/incremental.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/view_graph.h>
#include <raybundle/solver/phase_timer.h>
#include <raybundle/solver/solve.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

// What was not placed is as before.
void restore(const std::vector<std::uint8_t>& placed, const std::vector<double>& before,
             std::vector<double>& now) {
  const std::size_t size = placed.empty() ? 0 : now.size() / placed.size();
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (placed[i] != 0) continue;
    std::copy_n(before.begin() + static_cast<std::ptrdiff_t>(i * size), size,
                now.begin() + static_cast<std::ptrdiff_t>(i * size));
  }
}

class Reconstruction {
 public:
  Reconstruction(Problem& problem, const IncrementalOptions& options, const Progress& progress)
      : problem_(problem),
        options_(options),
        progress_(progress),
        pool_(options.threads > 0 ? options.threads : linalg::available_threads()),
        sightings_(problem, pool_),
        cameras_before_(problem.cameras),
        points_before_(problem.points) {
    refuse_fixed(problem);
    report_.images.assign(index(sightings_.images()), 0);
    report_.points.assign(index(sightings_.points()), 0);
    report_.observations.assign(index(problem.observation_count()), 0);
    poses_.resize(index(sightings_.images()));
  }

  IncrementalReport run() {
    {
      const PhaseTimer timer(report_.seconds);
      static_cast<void>(place_seed() && add_all());
    }
    restore(report_.images, cameras_before_, problem_.cameras);
    restore(report_.points, points_before_, problem_.points);
    report_.placed_images = std::count(report_.images.begin(), report_.images.end(), 1);
    report_.placed_points = std::count(report_.points.begin(), report_.points.end(), 1);
    return std::move(report_);
  }

 private:
  // Each stage returns whether to go on, and if not has put into the report why.
  bool end(Ending ending, std::string message) {
    report_.conclusion = {ending, std::move(message)};
    return false;
  }
  bool interrupted_at(const char* stage) {
    return end(Ending::interrupted, std::string("interrupted at: ") + stage);
  }
  Control say(const char* stage, std::int64_t done, std::int64_t all) const {
    return progress_ ? progress_(stage, done, all) : Control::proceed;
  }

  // The pair with most inliers, less where there is little parallax, that makes enough points.
  bool place_seed() {
    ViewGraph graph;
    {
      const PhaseTimer timer(report_.pair_seconds);
      graph = view_graph(sightings_, image_pairs(sightings_, options_.pairs, pool_),
                         options_.relative_pose, options_.seed, pool_, progress_);
    }
    if (graph.stopped) return interrupted_at("pairs");
    for (const ViewEdge* edge : seeds(graph)) {
      set_pose(edge->i, {});
      set_pose(edge->j, {edge->pose.R, edge->pose.t});
      triangulate_all();
      const auto points = std::count(report_.points.begin(), report_.points.end(), 1);
      if (points >= options_.relative_pose.min_inliers) return true;
      report_.images[index(edge->i)] = report_.images[index(edge->j)] = 0;
    }
    triangulate_all();
    return end(Ending::no_pose, "no pair of images to begin with; expected two with at least " +
                                    std::to_string(options_.relative_pose.min_inliers) +
                                    " points in common and parallax between them");
  }

  // Best first.
  std::vector<const ViewEdge*> seeds(const ViewGraph& graph) const {
    std::vector<std::pair<double, const ViewEdge*>> by_worth;
    for (const ViewEdge& edge : graph.edges) {
      if (edge.pose.t.isZero(0)) continue;
      const double parallax = std::min(1.0, edge.parallax / options_.seed_parallax);
      by_worth.emplace_back(static_cast<double>(edge.inliers) * parallax, &edge);
    }
    std::stable_sort(by_worth.begin(), by_worth.end(),
                     [](const auto& x, const auto& y) { return x.first > y.first; });
    std::vector<const ViewEdge*> result;
    result.reserve(by_worth.size());
    for (const auto& each : by_worth) result.push_back(each.second);
    return result;
  }

  bool add_all() {
    constexpr int last_iterations = 50;
    do {
      if (!adjust(options_.bundle_iterations)) return false;
    } while (add_batch());
    triangulate_all();
    return adjust(last_iterations);
  }

  void set_pose(std::int32_t image, const CameraPose& pose) {
    report_.images[index(image)] = 1;
    poses_[index(image)] = pose;
    double* camera = problem_.cameras.data() + std::int64_t{Problem::camera_size} * image;
    Eigen::Map<Vector3d> rotation(camera), translation(camera + 3);
    rotation = so3::log(pose.R_cw);
    translation = pose.t_cw;
  }

  bool placed(std::int32_t image) const { return report_.images[index(image)] != 0; }

  // The images not tried in vain that see most known points, best first.
  std::vector<std::int32_t> next_batch() const {
    std::vector<std::pair<std::int64_t, std::int32_t>> by_count;
    for (std::int32_t i = 0; i < sightings_.images(); ++i) {
      if (placed(i)) continue;
      std::int64_t count = 0;
      for (const std::int32_t s : sightings_.of_image(i)) {
        count += report_.points[index(sightings_.point(s))] != 0 ? 1 : 0;
      }
      if (count >= options_.resection.min_inliers && count > failed_with_[index(i)]) {
        by_count.emplace_back(-count, i);
      }
    }
    std::sort(by_count.begin(), by_count.end());
    std::vector<std::int32_t> batch;
    for (const auto& [minus_count, image] : by_count) {
      const auto most = static_cast<double>(by_count.front().first);
      if (static_cast<double>(minus_count) <= options_.batch_share * most) batch.push_back(image);
    }
    return batch;
  }

  // False where no image can be added any more.
  bool add_batch() {
    failed_with_.resize(index(sightings_.images()), 0);
    while (true) {
      const std::vector<std::int32_t> batch = next_batch();
      if (batch.empty()) return false;
      std::vector<std::optional<Resection>> found(batch.size());
      std::vector<std::int64_t> tried_with(batch.size());
      pool_.run(static_cast<std::int64_t>(batch.size()), [&](std::int64_t k) {
        const SeenPoints seen = seen_points(sightings_, batch[index(k)], report_.points, problem_);
        tried_with[index(k)] = seen.size();
        Random random(options_.seed, static_cast<std::uint64_t>(batch[index(k)]));
        found[index(k)] = resection(seen, options_.resection, random);
      });
      bool added = false;
      for (std::size_t k = 0; k < batch.size(); ++k) {
        ++report_.resections;
        if (!found[k]) {
          failed_with_[index(batch[k])] = tried_with[k];
          continue;
        }
        set_pose(batch[k], found[k]->pose);
        added = true;
      }
      if (!added) continue;
      triangulate_all();
      return true;
    }
  }

  // Every point anew from all placed images that saw it.
  void triangulate_all() {
    linalg::parallel_for(pool_, sightings_.points(), 64,
                         [&](std::int64_t first, std::int64_t last) {
                           for (; first < last; ++first)
                             triangulate(static_cast<std::int32_t>(first));
                         });
  }

  void triangulate(std::int32_t point) {
    std::vector<WorldRay> rays;
    std::vector<std::int64_t> of_ray;
    const Sightings::Range track = sightings_.of_point(point);
    for (std::int64_t s = track.first; s < track.last; ++s) {
      report_.observations[index(sightings_.observation(s))] = 0;
      if (!placed(sightings_.image(s))) continue;
      const CameraPose& pose = poses_[index(sightings_.image(s))];
      rays.push_back(
          {pose.centre(), pose.R_cw.transpose() * sightings_.ray(s), sightings_.pixels(s)});
      of_ray.push_back(s);
    }
    report_.points[index(point)] = 0;
    if (rays.size() < 2) return;
    const auto found = triangulated(rays, options_.triangulation);
    if (!found) return;
    report_.points[index(point)] = 1;
    Eigen::Map<Vector3d> place(problem_.points.data() + std::int64_t{3} * point);
    place = found->X;
    for (std::size_t k = 0; k < rays.size(); ++k) {
      report_.observations[index(sightings_.observation(of_ray[k]))] = found->used[k];
    }
  }

  bool adjust(int iterations) {
    const PhaseTimer timer(report_.bundle_seconds);
    Restriction part = placed_part(problem_, report_);
    if (part.point.empty()) {
      return end(Ending::not_computable, "no point left that two images agree on");
    }
    const auto images = static_cast<std::int64_t>(part.image.size());
    const Options options = {.lens = Lens::fixed,
                             .loss = Loss::cauchy,
                             .loss_scale = 0.5 * options_.triangulation.threshold,
                             .max_iterations = iterations,
                             .threads = pool_.threads()};
    bool stopped = false;
    const Summary summary = solve(part.problem, options, [&](const IterationRecord&) {
      stopped = say("images", images, sightings_.images()) == Control::stop;
      return stopped ? Control::stop : Control::proceed;
    });
    ++report_.bundle_adjustments;
    report_.failed_adjustments += summary.usable() ? 0 : 1;
    part.write_back(problem_);
    for (const std::int32_t image : part.image) {
      const double* camera = problem_.cameras.data() + std::int64_t{Problem::camera_size} * image;
      poses_[index(image)] = {so3::exp(Vector3d(camera[0], camera[1], camera[2])),
                              Vector3d(camera[3], camera[4], camera[5])};
    }
    if (stopped) return interrupted_at("images");
    if (summary.usable()) return true;
    return end(Ending::not_computable, "bundle adjustment: " + summary.message);
  }

  Problem& problem_;
  const IncrementalOptions& options_;
  const Progress& progress_;
  linalg::ThreadPool pool_;
  Sightings sightings_;
  std::vector<double> cameras_before_, points_before_;
  std::vector<CameraPose> poses_;
  std::vector<std::int64_t> failed_with_;  // of an image: known points that were not enough
  IncrementalReport report_;
};

}  // namespace

IncrementalReport reconstruct_incrementally(Problem& problem, const IncrementalOptions& options,
                                            const Progress& progress) {
  return Reconstruction(problem, options, progress).run();
}

Restriction placed_part(const Problem& problem, const IncrementalReport& report) {
  return restricted(problem, {report.images, report.points, report.observations});
}

}  // namespace raybundle::init
