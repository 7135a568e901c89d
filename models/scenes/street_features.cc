#include <raybundle/models/scenes/street_features.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace raybundle::scenes {
namespace {

constexpr double street_half_width = 6;
constexpr double nearest_depth = 2;
constexpr double longest_front_depth = 60;
constexpr double longest_far_depth = 800;
constexpr std::int64_t longest_front_track = 20;  // longer ones are planned for far features
constexpr std::int64_t straight_length = 4;       // steps in which the way hardly bends
constexpr double revisit_share = 0.2;

bool sees(const Camera& camera, const Feature& feature) {
  const double reach =
      feature.kind == StreetFeature::far ? 2 * longest_far_depth : longest_front_depth;
  const Pixel u = see(camera, feature.X);
  return u.depth >= nearest_depth && u.depth <= reach &&
         std::abs(u.x) <= 0.5 * street_image_width && std::abs(u.y) <= 0.5 * street_image_height;
}

/// Not all who could see a feature find it.
std::int64_t planned_limit(std::int64_t planned) { return 2 * planned + 2; }

/// Pareto: P(tail > x) = 1 / x^2.
double heavy_tail(Random& random) { return 1 / std::sqrt(1 - random.uniform()); }

/// A track grows at these: forward and backward from a camera, on each visit of the place.
struct Front {
  std::int64_t next;
  int step;
};

std::vector<Front> fronts_at(std::int64_t anchor, std::int64_t count, std::int64_t lap,
                             Random& random) {
  std::vector<Front> fronts = {{anchor + 1, 1}, {anchor - 1, -1}};
  if (lap == 0) return fronts;
  for (std::int64_t j = anchor % lap; j < count; j += lap) {
    if (j == anchor) continue;
    fronts.push_back({j, 1});
    fronts.push_back({j - 1, -1});
  }
  // Some features are rather found again on another visit than in the next image.
  if (random.uniform() < revisit_share) std::reverse(fronts.begin(), fronts.end());
  return fronts;
}

}  // namespace

Pixel see(const Camera& camera, const Vec3& X) {
  return project(camera, rotate(camera.phi, difference(X, camera.centre)));
}

Feature feature_ahead(const Camera& camera, double far_share, std::int64_t planned,
                      Random& random) {
  Feature feature;
  Vec3 X_c;
  const double tail = heavy_tail(random);
  if (random.uniform() < far_share || planned > longest_front_track) {
    const double width = planned > longest_front_track
                             ? 0.6 * longest_front_track / static_cast<double>(planned)
                             : 0.6;
    X_c.z = -random.uniform(0.25, 1) * longest_far_depth;
    X_c.x = random.uniform(-width, width) * X_c.z;
    X_c.y = random.uniform(-0.05, 0.3) * -X_c.z;
    feature.kind = StreetFeature::far;
    feature.limit = 2 + static_cast<std::int64_t>(6 * tail);
  } else {
    const double side = random.uniform() < 0.5 ? -1 : 1;
    const double relief = 0.2 * random.normal();  // window sills, doors
    X_c.z = -random.uniform(8, 35);
    X_c.x = side * (street_half_width + relief);
    X_c.y = random.uniform(-1.5, 8);
    feature.limit = 1 + static_cast<std::int64_t>(3 * tail);
  }
  if (planned > 0) feature.limit = planned_limit(planned);
  const Vec3 away = {-camera.phi.x, -camera.phi.y, -camera.phi.z};
  feature.X = sum(camera.centre, rotate(away, X_c));
  return feature;
}

Feature collinear_feature(const std::vector<Camera>& cameras, std::int64_t anchor,
                          std::int64_t planned, Random& random) {
  const auto last = static_cast<std::int64_t>(cameras.size()) - 1;
  const std::int64_t from = std::min(anchor, std::max<std::int64_t>(0, last - straight_length));
  const std::int64_t to = std::min(last, from + straight_length);
  const Vec3& start = cameras[static_cast<std::size_t>(from)].centre;
  const Vec3 way = difference(cameras[static_cast<std::size_t>(to)].centre, start);
  Feature feature;
  feature.kind = StreetFeature::collinear;
  const double distance = random.uniform(2, 8) * static_cast<double>(straight_length);
  feature.X = sum(start, scaled(distance / norm(way), way));
  feature.limit =
      planned > 0 ? planned_limit(planned) : 1 + static_cast<std::int64_t>(3 * heavy_tail(random));
  return feature;
}

Track track_from(std::int64_t anchor, const std::vector<Camera>& cameras, const Feature& feature,
                 std::int64_t lap, Random& random) {
  const auto count = static_cast<std::int64_t>(cameras.size());
  const auto seen_by = [&](std::int64_t j) {
    return j >= 0 && j < count && sees(cameras[static_cast<std::size_t>(j)], feature);
  };
  std::vector<Front> fronts = fronts_at(anchor, count, lap, random);
  Track seen;
  if (!seen_by(anchor)) return seen;
  seen.push_back(anchor);
  while (!fronts.empty()) {
    for (auto front = fronts.begin(); front != fronts.end();) {
      if (static_cast<std::int64_t>(seen.size()) >= feature.limit) return seen;
      if (seen_by(front->next)) {
        seen.push_back(front->next);
        front->next += front->step;
        ++front;
      } else {
        front = fronts.erase(front);
      }
    }
  }
  return seen;
}

double widen(Track& track, const std::vector<Camera>& cameras, const Vec3& X) {
  const auto ray = [&](std::int64_t j) {
    const Vec3 d = difference(X, cameras[static_cast<std::size_t>(j)].centre);
    return scaled(1 / norm(d), d);
  };
  const Vec3 first = ray(track[0]);
  double most = -1;
  for (std::size_t k = 1; k < track.size(); ++k) {
    const double angle = norm(cross(first, ray(track[k])));
    if (angle <= most) continue;
    most = angle;
    std::swap(track[1], track[k]);
  }
  return most;
}

}  // namespace raybundle::scenes
