#include <raybundle/solver/init/incremental.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/models/error.h>
#include <raybundle/models/rotation.h>
#include <raybundle/solver/init/view_graph.h>
#include <raybundle/solver/phase_timer.h>
#include <raybundle/solver/solve.h>

#include <algorithm>
#include <optional>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using linalg::index;

class Reconstruction {
 public:
  Reconstruction(Problem& problem, const IncrementalOptions& options, const Progress& progress)
      : problem_(problem),
        options_(options),
        progress_(progress),
        pool_(options.threads > 0 ? options.threads : linalg::available_threads()),
        sightings_(problem, pool_) {
    report_.images.assign(index(sightings_.images()), 0);
    report_.points.assign(index(sightings_.points()), 0);
    report_.observations.assign(index(problem.observation_count()), 0);
    poses_.resize(index(sightings_.images()));
  }

  IncrementalReport run() {
    {
      const PhaseTimer timer(report_.seconds);
      place_seed();
      adjust(options_.bundle_iterations);
      while (add_batch()) adjust(options_.bundle_iterations);
      triangulate_all();
      adjust(50);
    }
    report_.placed_images = std::count(report_.images.begin(), report_.images.end(), 1);
    report_.placed_points = std::count(report_.points.begin(), report_.points.end(), 1);
    return std::move(report_);
  }

 private:
  // The pair with most inliers, less where there is little parallax.
  void place_seed() {
    ViewGraph graph;
    {
      const PhaseTimer timer(report_.pair_seconds);
      graph = view_graph(sightings_, image_pairs(sightings_, options_.pairs, pool_),
                         options_.relative_pose, options_.seed, pool_,
                         [&](std::int64_t done, std::int64_t all) { say("pairs", done, all); });
    }
    const ViewEdge* best = nullptr;
    double most = 0;
    for (const ViewEdge& edge : graph.edges) {
      if (edge.kind != PairKind::general) continue;
      const double worth =
          static_cast<double>(edge.inliers) * std::min(1.0, edge.parallax / options_.seed_parallax);
      if (worth > most) most = worth, best = &edge;
    }
    if (!best) {
      throw InputError("problem", 0, "no pair of images to begin with",
                       "two with enough points in common and parallax between them");
    }
    set_pose(best->i, {});
    set_pose(best->j, {best->pose.R, best->pose.t});
    triangulate_all();
  }

  void say(const char* stage, std::int64_t done, std::int64_t all) const {
    if (progress_) progress_(stage, done, all);
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

  Vector3d place_of(std::int32_t point) const {
    return Eigen::Map<const Vector3d>(problem_.points.data() + std::int64_t{3} * point);
  }

  SeenPoints seen_by(std::int32_t image) const {
    std::vector<std::int32_t> of_known;
    for (const std::int32_t s : sightings_.of_image(image)) {
      if (report_.points[index(sightings_.point(s))] != 0) of_known.push_back(s);
    }
    const auto count = static_cast<Eigen::Index>(of_known.size());
    SeenPoints seen = {Eigen::Matrix3Xd(3, count), Eigen::Matrix3Xd(3, count),
                       Eigen::VectorXd(count)};
    for (Eigen::Index k = 0; k < count; ++k) {
      const std::int32_t s = of_known[index(k)];
      seen.X.col(k) = place_of(sightings_.point(s));
      seen.rays.col(k) = sightings_.ray(s);
      seen.pixels[k] = sightings_.pixels(s);
    }
    return seen;
  }

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
        const SeenPoints seen = seen_by(batch[index(k)]);
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

  void adjust(int iterations) {
    const PhaseTimer timer(report_.bundle_seconds);
    Restriction part = placed_part(problem_, report_);
    ++report_.bundle_adjustments;
    say("images", static_cast<std::int64_t>(part.image.size()), sightings_.images());
    if (part.problem.observation_count() == 0) return;
    static_cast<void>(solve(part.problem, {.lens = Lens::fixed,
                                           .loss = Loss::cauchy,
                                           .loss_scale = 0.5 * options_.triangulation.threshold,
                                           .max_iterations = iterations,
                                           .threads = pool_.threads()}));
    part.write_back(problem_);
    for (const std::int32_t image : part.image) {
      const double* camera = problem_.cameras.data() + std::int64_t{Problem::camera_size} * image;
      poses_[index(image)] = {so3::exp(Vector3d(camera[0], camera[1], camera[2])),
                              Vector3d(camera[3], camera[4], camera[5])};
    }
  }

  Problem& problem_;
  const IncrementalOptions& options_;
  const Progress& progress_;
  linalg::ThreadPool pool_;
  Sightings sightings_;
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
