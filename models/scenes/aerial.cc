// A survey flight over gentle hills. The field of view is made such that a point is seen by as many
// images as asked for; at a large height that is a narrow one, and rays are almost parallel.
//
// World frame: x across and y along the strips, z up.

#include <raybundle/models/scenes/aerial.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/track_lengths.h>

namespace raybundle::scenes {
namespace {

constexpr double image_width = 2000;  // pixels, across the strip
constexpr double image_height = 1500;
constexpr double strip_distance = 1.5;  // steps
constexpr double usual_views = 12;      // of a point
constexpr double relief = 0.02;         // of the hills, relative to the height
constexpr int patience = 30;

/// The grid of positions, and how far a camera sees.
struct Flight {
  std::int64_t cameras, per_strip;
  double height;
  double half_width, half_length;  // of an image on the ground, steps

  Vec3 position(std::int64_t j) const {
    const std::int64_t strip = j / per_strip, k = j % per_strip;
    const std::int64_t row = strip % 2 == 0 ? k : per_strip - 1 - k;
    return {strip_distance * static_cast<double>(strip), static_cast<double>(row), height};
  }
  std::int64_t camera_at(std::int64_t strip, std::int64_t row) const {
    return strip * per_strip + (strip % 2 == 0 ? row : per_strip - 1 - row);
  }
};

Flight plan_flight(const AerialOptions& options) {
  double views = usual_views;
  if (options.observations > 0) {  // not all who could see a point do
    const double mean =
        static_cast<double>(options.observations) / static_cast<double>(options.points);
    views = std::max(usual_views, 2 * mean + 4);
  }
  Flight flight = {};
  flight.cameras = options.cameras;
  flight.per_strip = static_cast<std::int64_t>(
      std::ceil(std::sqrt(strip_distance * static_cast<double>(options.cameras))));
  flight.height = options.height;
  // Of the area of a grid cell, an image covers `views` times as much.
  const double area = views * strip_distance;
  flight.half_length = 0.5 * std::sqrt(area * image_height / image_width);
  flight.half_width = flight.half_length * image_width / image_height;
  return flight;
}

std::vector<View> fly(const Flight& flight, Random& random) {
  std::vector<View> views;
  views.reserve(static_cast<std::size_t>(flight.cameras));
  const double f = 0.5 * image_width * flight.height / flight.half_width;
  const double shake = 0.05 * flight.half_length / flight.height;  // of the image's own angle
  for (std::int64_t j = 0; j < flight.cameras; ++j) {
    Camera camera;
    const bool back = j / flight.per_strip % 2 != 0;
    camera.phi = normal_vector(random, std::min(shake, 0.02));
    if (back) camera.phi.z += pi;
    camera.centre = sum(flight.position(j), normal_vector(random, 0.05));
    camera.f = f * (1 + 0.002 * random.normal());
    camera.k1 = -0.01 + 0.002 * random.normal();
    camera.k2 = 0.002 + 0.0005 * random.normal();
    views.emplace_back(camera);
  }
  return views;
}

double ground(double x, double y, double height) {
  return relief * height * (sine(0.31 * x) + cosine(0.5 * y));
}

/// All that see X, the nearest first.
Sightings track_of(const Vec3& X, const Flight& flight, const std::vector<View>& views) {
  const double reach_x = 1.5 * flight.half_width, reach_y = 1.5 * flight.half_length;
  const std::int64_t strips = (flight.cameras - 1) / flight.per_strip + 1;
  const auto low = [](double x) { return std::max<std::int64_t>(0, std::llround(x)); };
  std::vector<std::pair<double, std::pair<std::int32_t, Pixel>>> seen;
  const std::int64_t last_strip = std::min(strips - 1, low((X.x + reach_x) / strip_distance));
  const std::int64_t last_row = std::min(flight.per_strip - 1, low(X.y + reach_y));
  for (std::int64_t s = low((X.x - reach_x) / strip_distance); s <= last_strip; ++s) {
    for (std::int64_t row = low(X.y - reach_y); row <= last_row; ++row) {
      const std::int64_t j = flight.camera_at(s, row);
      if (j >= flight.cameras) continue;
      const View& view = views[static_cast<std::size_t>(j)];
      const Pixel u = view.see(X);
      const bool inside =
          u.depth > 0 && std::abs(u.x) <= 0.5 * image_width && std::abs(u.y) <= 0.5 * image_height;
      if (!inside) continue;
      const Vec3 d = difference(X, view.camera().centre);
      seen.push_back({d.x * d.x + d.y * d.y, {static_cast<std::int32_t>(j), u}});
    }
  }
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first, a.second.first) < std::pair(b.first, b.second.first);
  });
  Sightings track;
  for (const auto& each : seen) track.push_back(each.second);
  return track;
}

Vec3 point_below(const Camera& camera, const Flight& flight, Random& random) {
  Vec3 X;
  X.x = camera.centre.x + random.uniform(-1, 1) * flight.half_width;
  X.y = camera.centre.y + random.uniform(-1, 1) * flight.half_length;
  X.z = ground(X.x, X.y, flight.height) + 0.003 * flight.height * random.normal();
  return X;
}

void check(const AerialOptions& options) {
  check_count("aerial scene", options.cameras, 2, "cameras");
  check_count("aerial scene", options.points, 1, "points");
  check_observations("aerial scene", options.observations, options.cameras, options.points);
  check_range("aerial scene", options.height, 1, 1e6, "height");
}

}  // namespace

Scene aerial_scene(const AerialOptions& options) {
  check(options);
  const Flight flight = plan_flight(options);
  Random camera_random(options.seed, 1), random(options.seed, 2), plan_random(options.seed, 3);
  const std::vector<View> views = fly(flight, camera_random);
  const double most = 4 * flight.half_width * flight.half_length / strip_distance;
  TrackPlan plan(options.points, options.observations,
                 std::min(options.cameras, static_cast<std::int64_t>(most)), plan_random);

  Scene scene = {{}, image_width, image_height};
  for (const View& view : views) append_camera(scene.truth, view.camera());
  for (std::int64_t i = 0; i < options.points; ++i) {
    const Camera& anchor = views[static_cast<std::size_t>(i % options.cameras)].camera();
    const std::int64_t wanted = plan.exists() ? plan.wanted(i) : 0;
    auto [X, track] = draw_until_seen("aerial scene", wanted, patience, [&] {
      const Vec3 below = point_below(anchor, flight, random);
      return SeenFeature{below, track_of(below, flight, views)};
    });
    if (plan.exists()) {
      const auto available = static_cast<std::int64_t>(track.size());
      track.resize(static_cast<std::size_t>(plan.settle(i, available, plan_random)));
    }
    append_track(scene.truth, X, std::move(track));
  }
  return scene;
}

}  // namespace raybundle::scenes
