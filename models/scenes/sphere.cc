// The synthetic data set of [Qu18, 5.1]: points on a ball, cameras close around it that look at it,
// each seeing the points of a spherical cap that fall into its image.
//
// The thesis draws points and cameras once and deletes what is seen too little. Here the cameras
// are drawn first and points until enough of them are kept, so that both counts come out as asked.

#include <raybundle/models/scenes/sphere.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <raybundle/models/scenes/camera.h>

namespace raybundle::scenes {
namespace {

constexpr double radius = 500;
constexpr double focal_length = 400;  // "recommended to be set to a smaller value than r"
constexpr double image_width = 800;
constexpr double image_height = 600;
constexpr double nearest = 1.4 * radius;  // camera centres from the ball's centre
constexpr double farthest = 1.8 * radius;
constexpr double largest_tilt = pi / 6;  // between the line to the ball's centre and the view
constexpr double least_cover = 0.5;      // of the image by the ball
constexpr int cells_x = 8, cells_y = 6;  // by which that cover is measured

/// Where cameras stand and what they see.
struct Layout {
  double region = 0;  // cameras stand within this angle of the +z axis
  double cap = 1;     // share of the ball's visible cap, by its angle, that is recognised
};

struct Spectator {
  View view;
  double least_cosine;  // between a visible point and the camera, seen from the ball's centre
};

struct Feature {
  Vec3 X;
  Sightings track;
};

Camera draw_camera(double region, Random& random) {
  const Vec3 outward = direction_in_cone(random, region);
  const Vec3 z = combined(axes_about(outward), direction_in_cone(random, largest_tilt));
  Camera camera;
  camera.phi = rotation_vector(axes_about(z, random.uniform(-pi, pi)));
  camera.centre = scaled(random.uniform(nearest, farthest), outward);
  camera.f = focal_length * (1 + 0.02 * random.normal());
  camera.k1 = 1e-2 * (1 + 0.2 * random.normal());
  camera.k2 = 1e-4 * (1 + 0.2 * random.normal());
  return camera;
}

/// The share of the image where the ball is, from the rays of the cells' centres.
double cover(const View& view) {
  int hits = 0;
  for (int i = 0; i < cells_x; ++i) {
    for (int j = 0; j < cells_y; ++j) {
      const double x = ((i + 0.5) / cells_x - 0.5) * image_width / view.camera().f;
      const double y = ((j + 0.5) / cells_y - 0.5) * image_height / view.camera().f;
      const Vec3 ray = combined(view.axes(), {x, y, -1});
      const double miss = norm(cross(view.camera().centre, ray)) / norm(ray);
      if (miss < radius) ++hits;
    }
  }
  return static_cast<double>(hits) / (cells_x * cells_y);
}

std::vector<Spectator> draw_spectators(std::int64_t count, const Layout& layout,
                                       std::uint64_t seed) {
  Random random(seed, 1);
  std::vector<Spectator> spectators;
  while (static_cast<std::int64_t>(spectators.size()) < count) {
    const View view(draw_camera(layout.region, random));
    if (cover(view) < least_cover) continue;
    const double distance = norm(view.camera().centre);
    const double horizon = arctangent(std::sqrt(distance * distance - radius * radius), radius);
    spectators.push_back({view, cosine(layout.cap * horizon) * distance * radius});
  }
  return spectators;
}

/// Each camera followed by the nearest that is left, so that neighbours overlap.
void sort_by_neighbours(std::vector<Spectator>& spectators) {
  for (std::size_t k = 1; k < spectators.size(); ++k) {
    const Vec3& here = spectators[k - 1].view.camera().centre;
    std::size_t best = k;
    double least = 0;
    for (std::size_t j = k; j < spectators.size(); ++j) {
      const Vec3 d = difference(spectators[j].view.camera().centre, here);
      if (j > k && dot(d, d) >= least) continue;
      best = j;
      least = dot(d, d);
    }
    std::swap(spectators[k], spectators[best]);
  }
}

Sightings track_of(const std::vector<Spectator>& spectators, const Vec3& X) {
  Sightings track;
  for (std::size_t j = 0; j < spectators.size(); ++j) {
    const auto& [view, least_cosine] = spectators[j];
    if (dot(view.camera().centre, X) < least_cosine) continue;
    const Pixel u = view.see(X);
    const bool inside =
        u.depth > 0 && std::abs(u.x) <= 0.5 * image_width && std::abs(u.y) <= 0.5 * image_height;
    if (inside) track.emplace_back(static_cast<std::int32_t>(j), u);
  }
  return track;
}

/// A feature that at least two cameras see.
Feature draw_feature(const std::vector<Spectator>& spectators, Random& random) {
  Feature feature;
  for (int attempt = 0; attempt < hopeless; ++attempt) {
    feature.X = scaled(radius, direction_in_cone(random, pi));
    feature.track = track_of(spectators, feature.X);
    if (feature.track.size() >= 2) return feature;
  }
  fail_to_see("sphere scene");
}

/// Mean number of cameras that see a point.
double mean_track(std::int64_t cameras, const Layout& layout, std::uint64_t seed) {
  const auto spectators = draw_spectators(cameras, layout, seed);
  const std::int64_t probes = std::clamp<std::int64_t>(200'000 / cameras, 200, 2000);
  Random random(seed, 2);
  double sum = 0;
  int kept = 0;
  for (std::int64_t k = 0; k < probes; ++k) {
    const std::size_t length =
        track_of(spectators, scaled(radius, direction_in_cone(random, pi))).size();
    if (length < 2) continue;
    sum += static_cast<double>(length);
    ++kept;
  }
  return kept > 0 ? sum / kept : 0;
}

/// `sparsity` from 0 to 1 widens the region to all directions, from 1 to 2 then narrows the caps.
Layout layout_of(double sparsity) {
  if (sparsity <= 1) return {std::max(0.02, sparsity * pi), 1};
  return {pi, 2 - sparsity};
}

/// The layout by which a point is seen by `track` cameras on average, by bisection.
Layout layout_for(double track, const SphereOptions& options) {
  double low = 0, high = 1.95;
  for (int k = 0; k < 14; ++k) {
    const double middle = 0.5 * (low + high);
    const bool dense = mean_track(options.cameras, layout_of(middle), options.seed) > track;
    (dense ? low : high) = middle;
  }
  return layout_of(0.5 * (low + high));
}

/// Exchanges features for others until there are as many observations as asked for, or nearly.
void steer(std::vector<Feature>& features, std::int64_t target,
           const std::vector<Spectator>& spectators, Random& random) {
  std::int64_t excess = -target;
  for (const Feature& feature : features) {
    excess += static_cast<std::int64_t>(feature.track.size());
  }
  const auto count = static_cast<std::int64_t>(features.size());
  for (std::int64_t k = 0; k < 2 * count + 1000 && excess != 0; ++k) {
    Feature other = draw_feature(spectators, random);
    Feature& feature = features[static_cast<std::size_t>(random.below(count))];
    const std::int64_t change = static_cast<std::int64_t>(other.track.size()) -
                                static_cast<std::int64_t>(feature.track.size());
    if (std::abs(excess + change) >= std::abs(excess)) continue;
    feature = std::move(other);
    excess += change;
  }
}

void check(const SphereOptions& options) {
  check_count("sphere scene", options.cameras, 2, "cameras");
  check_count("sphere scene", options.points, 1, "points");
  check_observations("sphere scene", options.observations, options.cameras, options.points);
  check_range("sphere scene", options.region, 0, pi, "region");
}

}  // namespace

Scene sphere_scene(const SphereOptions& options) {
  check(options);
  const double asked = static_cast<double>(options.observations);
  const Layout layout = options.observations == 0
                            ? Layout{options.region, 1}
                            : layout_for(asked / static_cast<double>(options.points), options);
  auto spectators = draw_spectators(options.cameras, layout, options.seed);
  sort_by_neighbours(spectators);

  Random random(options.seed, 3);
  std::vector<Feature> features;
  features.reserve(static_cast<std::size_t>(options.points));
  for (std::int64_t i = 0; i < options.points; ++i) {
    features.push_back(draw_feature(spectators, random));
  }
  if (options.observations != 0) steer(features, options.observations, spectators, random);

  Scene scene = {{}, image_width, image_height};
  for (const Spectator& spectator : spectators) {
    append_camera(scene.truth, spectator.view.camera());
  }
  for (const Feature& feature : features) append_track(scene.truth, feature.X, feature.track);
  return scene;
}

}  // namespace raybundle::scenes
