#pragma once

#include <raybundle/models/problem.h>
#include <raybundle/models/scenes/geometry.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

/// What the kinds of scenes share: a camera, what it sees, and how a Problem is filled.
namespace raybundle::scenes {

struct Camera {
  Vec3 phi;     ///< rotation vector of R_cw
  Vec3 centre;  ///< in the world
  double f = 0, k1 = 0, k2 = 0;
};

struct Pixel {
  double x = 0, y = 0, depth = 0;
};

/// Of a point in the camera's frame, by the lens of BAL:
/// p = -X_c.xy / X_c.z, u = f (1 + k1 |p|^2 + k2 |p|^4) p.
Pixel project(const Camera& camera, const Vec3& X_c);

/// A camera with its rotation as a matrix, for many points.
class View {
 public:
  explicit View(const Camera& camera) : camera_(camera), R_cw_(rotation_matrix(camera.phi)) {}
  const Camera& camera() const { return camera_; }
  const Mat3& axes() const { return R_cw_; }  ///< of the camera, in the world
  Pixel see(const Vec3& X) const {
    return project(camera_, product(R_cw_, difference(X, camera_.centre)));
  }

 private:
  Camera camera_;
  Mat3 R_cw_;
};

void append_camera(Problem& problem, const Camera& camera);
void append_point(Problem& problem, const Vec3& X);
void append_observation(Problem& problem, std::int64_t camera, std::int64_t point, double x,
                        double y);
/// Of the problem's last point, exactly.
void append_observation(Problem& problem, std::int64_t camera, const Pixel& u);

/// Who sees a point, and where.
using Sightings = std::vector<std::pair<std::int32_t, Pixel>>;
/// A point and its sightings, by camera.
void append_track(Problem& problem, const Vec3& X, Sightings sightings);

/// Camera `index` of a problem again, and a point.
Camera camera_of(const Problem& problem, std::int64_t index);
Vec3 point_of(const Problem& problem, std::int64_t index);

/// Each throws InputError naming `source` and `what` when the value is not in range.
void check_count(const std::string& source, std::int64_t value, std::int64_t least,
                 const std::string& what);
void check_range(const std::string& source, double value, double least, double most,
                 const std::string& what);
/// For a camera that shares no point with others, after as many attempts to find one.
inline constexpr int hopeless = 100000;
[[noreturn]] void fail_to_see(const std::string& source);
/// Observations asked for: 0, or from two per point to one per camera and point.
void check_observations(const std::string& source, std::int64_t observations, std::int64_t cameras,
                        std::int64_t points);

/// A feature and who sees it.
struct SeenFeature {
  Vec3 X;
  Sightings sightings;
};

/// The first of draw()'s features that `wanted` cameras see, at least two; after `patience` draws
/// the one that most see. Throws InputError naming `scene` when nothing is ever seen twice.
template <class Draw>
SeenFeature draw_until_seen(const std::string& scene, std::int64_t wanted, int patience,
                            Draw&& draw) {
  SeenFeature best;
  const auto enough = static_cast<std::size_t>(std::max<std::int64_t>(2, wanted));
  for (int attempt = 0; best.sightings.size() < enough; ++attempt) {
    if (attempt >= patience && best.sightings.size() >= 2) break;
    if (attempt >= hopeless) fail_to_see(scene);
    SeenFeature other = draw();
    if (other.sightings.size() < std::max<std::size_t>(2, best.sightings.size() + 1)) continue;
    best = std::move(other);
  }
  return best;
}

}  // namespace raybundle::scenes
