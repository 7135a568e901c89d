// A community photo collection. The sights are fronts along a long wall, each drawing a crowd of
// cameras whose size falls with its rank as Zipf's law has it. Who looks at a sight is listed once,
// so that a point chooses among those cameras only and the work grows with the observations.
//
// World frame: x along the wall, y up, the cameras stand at z > 0 and look towards -z.

#include <raybundle/models/scenes/photos.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/track_lengths.h>

namespace raybundle::scenes {
namespace {

constexpr double image_width = 1600;
constexpr double image_height = 1200;
constexpr double sight_width = 20;  // metres, between one sight and the next
constexpr double sight_height = 25;
constexpr double eye_height = 2;
constexpr std::int64_t usual_crowd = 60;  // cameras of a sight
constexpr std::int64_t usual_track = 4;
constexpr double largest_weight = 10;  // of a hub, relative to the least of cameras
constexpr int patience = 8;

/// Who looks at a sight, with the sums of their weights so far, by which they are drawn.
struct Crowd {
  std::vector<std::int32_t> cameras;
  std::vector<double> sums;
};

struct Collection {
  std::vector<View> views;
  std::vector<Crowd> crowds;  // by sight
};

bool inside(const Pixel& u) {
  return u.depth > 1 && std::abs(u.x) <= 0.5 * image_width && std::abs(u.y) <= 0.5 * image_height;
}

/// The sight of each camera: popular ones have many, and each has some.
std::vector<std::int64_t> choose_sights(std::int64_t cameras, std::int64_t sights, Random& random) {
  std::vector<double> sums;
  double total = 0;
  for (std::int64_t k = 0; k < sights; ++k) {
    total += 1 / std::sqrt(static_cast<double>(k + 1));
    sums.push_back(total);
  }
  std::vector<std::int64_t> place(sums.size());  // along the wall, by rank
  for (std::size_t k = 0; k < place.size(); ++k) place[k] = static_cast<std::int64_t>(k);
  for (std::size_t k = place.size(); k > 1; --k) {
    std::swap(place[k - 1],
              place[static_cast<std::size_t>(random.below(static_cast<std::int64_t>(k)))]);
  }
  std::vector<std::int64_t> result;
  for (std::int64_t j = 0; j < cameras; ++j) {
    std::size_t rank = static_cast<std::size_t>(j);
    if (j >= 2 * sights) {
      const double at = random.uniform() * total;
      rank =
          static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), at) - sums.begin());
    }
    result.push_back(place[std::min(rank % place.size(), place.size() - 1)]);
  }
  std::sort(result.begin(), result.end());  // neighbours in the order overlap
  return result;
}

Camera draw_camera(std::int64_t sight, Random& random) {
  const double x = sight_width * static_cast<double>(sight);
  const double distance = std::min(12 / std::sqrt(1 - random.uniform()), 90.0);
  const double aside = 0.6 * distance * random.uniform(-1, 1);
  const Vec3 aim = {x + 3 * random.normal(), 0.4 * distance * random.uniform(), 0};
  Camera camera;
  camera.centre = {x + aside, eye_height + 0.3 * random.normal(), distance};
  const Vec3 back = difference(camera.centre, {aim.x, std::min(aim.y, 0.5 * sight_height), 0});
  camera.phi = rotation_vector(axes_about(scaled(1 / norm(back), back), 0.05 * random.normal()));
  camera.f = 1000 / std::sqrt(1 - 0.85 * random.uniform());  // 1000 to 2600: many wide, some long
  camera.k1 = random.uniform(-0.06, 0);  // within these bounds no lens folds its image over
  camera.k2 = random.uniform(0.002, 0.008);
  return camera;
}

Collection collect(std::int64_t cameras, std::int64_t sights, Random& random) {
  Collection result;
  result.crowds.resize(static_cast<std::size_t>(sights));
  std::int32_t j = 0;
  for (const std::int64_t own : choose_sights(cameras, sights, random)) {
    const View view(draw_camera(own, random));
    const double weight = std::min(1 / (1 - random.uniform()), largest_weight);
    const auto reach = static_cast<std::int64_t>(
        2 + view.camera().centre.z / sight_width);  // farther sights are not in the image
    for (std::int64_t k = std::max<std::int64_t>(0, own - reach);
         k <= std::min(sights - 1, own + reach); ++k) {
      const bool looks = k == own || inside(view.see({sight_width * static_cast<double>(k), 4, 0}));
      if (!looks) continue;
      Crowd& crowd = result.crowds[static_cast<std::size_t>(k)];
      crowd.cameras.push_back(j);
      crowd.sums.push_back((crowd.sums.empty() ? 0 : crowd.sums.back()) + weight);
    }
    result.views.push_back(view);
    ++j;
  }
  return result;
}

/// A point of the wall in some part of a camera's image: fronts stand out, towers rise.
Vec3 point_in(const View& view, Random& random) {
  const Camera& camera = view.camera();
  const double x = random.uniform(-0.5, 0.5) * image_width / camera.f;
  const double y = random.uniform(-0.5, 0.5) * image_height / camera.f;
  const double z = random.normal();
  const Vec3 ray = combined(view.axes(), {x, y, -1});
  const double length = ray.z < 0 ? (z - camera.centre.z) / ray.z : 1;
  return sum(camera.centre, scaled(length, ray));
}

bool on_wall(const Vec3& X, std::int64_t sights) {
  return X.y >= 0 && X.y <= sight_height && X.z < 5 && X.x > -0.5 * sight_width &&
         X.x < (static_cast<double>(sights) - 0.5) * sight_width;
}

/// Adds cameras of the crowd that see X, drawn by weight, until there are `wanted`; where these are
/// hard to find, the first that come.
void gather(const Vec3& X, const Collection& collection, std::size_t wanted, Random& random,
            Sightings& track) {
  const auto sight = static_cast<std::size_t>(std::llround(X.x / sight_width));
  const Crowd& crowd = collection.crowds[std::min(sight, collection.crowds.size() - 1)];
  const auto add = [&](std::int32_t j) {
    const auto same = [j](const auto& each) { return each.first == j; };
    if (std::any_of(track.begin(), track.end(), same)) return;
    const Pixel u = collection.views[static_cast<std::size_t>(j)].see(X);
    if (inside(u)) track.emplace_back(j, u);
  };
  if (crowd.cameras.empty()) return;
  for (std::size_t k = 0; k < 4 * wanted + 8 && track.size() < wanted; ++k) {
    const double at = random.uniform() * crowd.sums.back();
    const auto found = std::upper_bound(crowd.sums.begin(), crowd.sums.end() - 1, at);
    add(crowd.cameras[static_cast<std::size_t>(found - crowd.sums.begin())]);
  }
  const auto size = static_cast<std::int64_t>(crowd.cameras.size());
  const std::int64_t first = random.below(size);
  for (std::int64_t k = 0; k < size && track.size() < wanted; ++k) {
    add(crowd.cameras[static_cast<std::size_t>((first + k) % size)]);
  }
}

PhotosOptions completed(PhotosOptions options) {
  check_count("photos scene", options.cameras, 2, "cameras");
  check_count("photos scene", options.points, 1, "points");
  check_observations("photos scene", options.observations, options.cameras, options.points);
  if (options.sights < 0 || options.sights > options.cameras / 2) {
    throw InputError("photos scene", 0, std::to_string(options.sights) + " sights",
                     "0 to " + std::to_string(options.cameras / 2) + ", half the cameras");
  }
  if (options.sights == 0)
    options.sights = std::max<std::int64_t>(1, options.cameras / usual_crowd);
  if (options.observations == 0) {
    options.observations = std::min(usual_track, options.cameras) * options.points;
  }
  return options;
}

std::int64_t longest_track(const Collection& collection) {
  std::size_t most = 0;
  for (const Crowd& crowd : collection.crowds) most = std::max(most, crowd.cameras.size());
  return static_cast<std::int64_t>(most / 2);
}

}  // namespace

Scene photos_scene(const PhotosOptions& options) {
  const auto [seed, cameras, points, observations, sight_count] = completed(options);
  const std::int64_t sights = sight_count;  // a binding is not to be captured
  Random camera_random(seed, 1), random(seed, 2), plan_random(seed, 3);
  const Collection collection = collect(cameras, sights, camera_random);
  TrackPlan plan(points, observations, longest_track(collection), plan_random);

  Scene scene = {{}, image_width, image_height};
  for (const View& view : collection.views) append_camera(scene.truth, view.camera());
  for (std::int64_t i = 0; i < points; ++i) {
    const auto anchor = static_cast<std::int32_t>(i % cameras);
    const View& view = collection.views[static_cast<std::size_t>(anchor)];
    const std::int64_t wanted = plan.wanted(i);
    auto [X, track] = draw_until_seen("photos scene", wanted, patience, [&] {
      const Vec3 inside_view = point_in(view, random);
      const Pixel u = view.see(inside_view);
      SeenFeature seen = {inside_view, {}};
      if (!on_wall(inside_view, sights) || !inside(u)) return seen;
      seen.sightings = {{anchor, u}};
      gather(inside_view, collection, static_cast<std::size_t>(wanted), random, seen.sightings);
      return seen;
    });
    const auto available = static_cast<std::int64_t>(track.size());
    track.resize(static_cast<std::size_t>(plan.settle(i, available, plan_random)));
    append_track(scene.truth, X, std::move(track));
  }
  return scene;
}

}  // namespace raybundle::scenes
