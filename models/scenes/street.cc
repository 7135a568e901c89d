// A street for a forward-looking camera: two rows of house fronts along a winding path and, for
// shares of the points, features far ahead or on the line of motion. Lengths are in steps between
// cameras.

#include <raybundle/models/scenes/street.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/street_drive.h>
#include <raybundle/models/scenes/street_features.h>
#include <raybundle/models/scenes/track_lengths.h>

namespace raybundle::scenes {
namespace {

constexpr std::int64_t longest_planned_track = 150;  // bends end them
constexpr int patience = 40;
constexpr double least_parallax = 0.026;  // radians, between rays to a house front

/// The scene, and of each point the camera it was drawn for.
class Street {
 public:
  explicit Street(const StreetOptions& options)
      : options_(options),
        plan_random_(options.seed, 3),
        kind_random_(options.seed, 4),
        plan_(options.points, options.observations,
              std::min(options.cameras, longest_planned_track), plan_random_) {}

  /// Draws features ahead of a camera until at least two cameras see one (about every second does),
  /// or as many as planned; after many attempts it is the feature seen by the most.
  void draw(std::int64_t point, const std::vector<Camera>& cameras, Random& random) {
    const std::int64_t anchor = anchor_of(point);
    const Camera& camera = cameras[static_cast<std::size_t>(anchor)];
    const std::int64_t planned = plan_.exists() ? plan_.wanted(point) : 0;
    const auto enough = static_cast<std::size_t>(std::max<std::int64_t>(2, planned));
    const bool collinear = kind_random_.uniform() < options_.collinear_share;
    track_.clear();
    for (int attempt = 0; track_.size() < enough; ++attempt) {
      if (attempt >= patience && track_.size() >= 2) break;
      if (attempt >= hopeless) fail_to_see("street scene");
      const Feature feature = collinear
                                  ? collinear_feature(cameras, anchor, planned, random)
                                  : feature_ahead(camera, options_.far_share, planned, random);
      Track found = track_from(anchor, cameras, feature, options_.lap, random);
      if (found.size() < std::max<std::size_t>(2, track_.size() + 1)) continue;
      // Plans copy real problems, whose makers had left out most points of little parallax.
      if (plan_.exists() && widen(found, cameras, feature.X) < least_parallax &&
          feature.kind == StreetFeature::front && attempt < patience) {
        continue;
      }
      X_ = feature.X;
      track_ = std::move(found);
    }
    if (plan_.exists()) {
      const auto available = static_cast<std::int64_t>(track_.size());
      thin(static_cast<std::size_t>(plan_.settle(point, available, plan_random_)));
    }
    std::sort(track_.begin(), track_.end());
  }

  std::int64_t anchor_of(std::int64_t point) const { return point % options_.cameras; }
  const Vec3& X() const { return X_; }               ///< of the point drawn last
  const Track& observers() const { return track_; }  ///< ascending

 private:
  /// Keeps the anchor, the camera with the most parallax to it, and others at random.
  void thin(std::size_t length) {
    for (std::size_t k = 2; k < length; ++k) {
      const auto rest = static_cast<std::int64_t>(track_.size() - k);
      std::swap(track_[k], track_[k + static_cast<std::size_t>(plan_random_.below(rest))]);
    }
    track_.resize(length);
  }

  StreetOptions options_;
  Random plan_random_;
  Random kind_random_;
  TrackPlan plan_;
  Vec3 X_;
  Track track_;
};

void check(const StreetOptions& options) {
  check_count("street scene", options.cameras, 2, "cameras");
  check_count("street scene", options.points, 1, "points");
  check_observations("street scene", options.observations, options.cameras, options.points);
  check_range("street scene", options.far_share, 0, 1, "far share");
  check_range("street scene", options.collinear_share, 0, 1, "collinear share");
  const bool good = options.lap == 0 || (options.lap >= shortest_lap && options.lap % 4 == 0);
  if (good) return;
  throw InputError("street scene", 0, "a lap of " + std::to_string(options.lap) + " steps",
                   "0 or a multiple of 4 of at least " + std::to_string(shortest_lap));
}

/// Errors of deviation 1, drawn in between so that street() has the numbers it always had.
struct Errors {
  std::vector<Vec3> rotations, centres, points;
  std::vector<double> pixels;
};

struct Drawn {
  Scene scene;
  std::vector<Camera> cameras;
  Errors errors;
};

Drawn draw(const StreetOptions& options) {
  check(options);
  Random camera_random(options.seed, 1), feature_random(options.seed, 2);
  Drawn drawn = {{{}, street_image_width, street_image_height}, drive(options, camera_random), {}};
  Problem& truth = drawn.scene.truth;
  Errors& errors = drawn.errors;
  for (const Camera& camera : drawn.cameras) {
    append_camera(truth, camera);
    errors.rotations.push_back(normal_vector(camera_random, 1));
    errors.centres.push_back(normal_vector(camera_random, 1));
  }
  Street street(options);
  for (std::int64_t i = 0; i < options.points; ++i) {
    street.draw(i, drawn.cameras, feature_random);
    append_point(truth, street.X());
    errors.points.push_back(normal_vector(feature_random, 1));
    for (const std::int64_t j : street.observers()) {
      append_observation(truth, j, see(drawn.cameras[static_cast<std::size_t>(j)], street.X()));
      errors.pixels.push_back(feature_random.normal());
      errors.pixels.push_back(feature_random.normal());
    }
  }
  return drawn;
}

}  // namespace

Scene street_scene(const StreetOptions& options) { return draw(options).scene; }

Problem street(const StreetOptions& options) {
  constexpr double rotation_error = 0.005, centre_error = 0.1, point_error = 0.01;
  constexpr double pixel_error = 0.5;
  const Drawn drawn = draw(options);
  const Errors& errors = drawn.errors;
  Problem start = drawn.scene.truth;
  start.cameras.clear();
  start.points.clear();
  for (std::size_t j = 0; j < drawn.cameras.size(); ++j) {
    Camera camera = {{}, {}, nominal_focal_length, 0, 0};
    camera.phi = sum(drawn.cameras[j].phi, scaled(rotation_error, errors.rotations[j]));
    camera.centre = sum(drawn.cameras[j].centre, scaled(centre_error, errors.centres[j]));
    append_camera(start, camera);
  }
  for (std::size_t i = 0; i < errors.points.size(); ++i) {
    const Vec3 X = point_of(drawn.scene.truth, static_cast<std::int64_t>(i));
    const double deviation = point_error * see(drawn.cameras[i % drawn.cameras.size()], X).depth;
    append_point(start, sum(X, scaled(deviation, errors.points[i])));
  }
  for (std::size_t k = 0; k < errors.pixels.size(); ++k) {
    start.observations[k] += pixel_error * errors.pixels[k];
  }
  return start;
}

}  // namespace raybundle::scenes
