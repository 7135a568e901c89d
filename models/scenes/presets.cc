#include <raybundle/models/scenes/presets.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>

namespace raybundle::scenes {
namespace {

/// The usual start with all deviations multiplied.
StartOptions worse(double factor) {
  StartOptions start;
  start.rotation *= factor;
  start.position *= factor;
  start.focal *= factor;
  start.point *= factor;
  return start;
}

std::vector<Preset> all_presets() {
  // These give RMSE of 40 to 49 for centres and 10 to 13 for points, amid the thesis' tables.
  const StartOptions far = {.rotation = 0.05, .position = 0.07, .focal = 0.02, .point = 0.02};
  return {
      {"sphere-10", Kind::sphere, 10, 289, 1'834, {}, far},
      {"sphere-50", Kind::sphere, 50, 1'000, 28'991, {}, far},
      {"sphere-100", Kind::sphere, 100, 4'000, 228'658, {}, far},
      {"sphere-500", Kind::sphere, 500, 5'000, 1'477'513, {}, far},
      {"ladybug-1723", Kind::street, 1'723, 156'502, 678'718, {}, worse(1.4)},
      {"trafalgar-257", Kind::photos, 257, 65'132, 225'911, {}, worse(1.15)},
      {"dubrovnik-356", Kind::photos, 356, 226'730, 1'255'268, {}, worse(1.4)},
      {"venice-1778", Kind::photos, 1'778, 993'923, 5'001'946, {}, worse(1.2)},
      {"final-871", Kind::photos, 871, 527'480, 2'785'977, {}, worse(1.2)},
      {"final-4585", Kind::photos, 4'585, 1'324'582, 9'125'125, {}, worse(1.2)},
      {"village", Kind::aerial, 90, 305'719, 779'268, {}, worse(0.16)},
      {"college", Kind::aerial, 468, 1'236'502, 3'107'524, {}, worse(0.16)},
      {"victoria-cottage", Kind::street, 400, 153'632, 890'057, {}, worse(1.3), 0.3},
      {"usyd-mainquad", Kind::street, 424, 227'615, 1'607'082, {}, worse(1.3), 0.3},
      {"fake-pile-135", Kind::street, 135, 12'741, 53'878, {}, worse(1.3), 0.3},
  };
}

std::int64_t rounded(double value) { return std::llround(value); }

}  // namespace

const char* name(Kind kind) {
  constexpr std::array names = {"sphere", "street", "aerial", "photos"};
  return names[static_cast<std::size_t>(kind)];
}

const std::vector<Preset>& presets() {
  static const std::vector<Preset> all = all_presets();
  return all;
}

const Preset& preset(const std::string& name) {
  std::string names;
  for (const Preset& each : presets()) {
    if (each.name == name) return each;
    names += (names.empty() ? "" : ", ") + each.name;
  }
  throw InputError("preset", 0, "'" + name + "'", "one of " + names);
}

Preset resized(const Preset& preset, double factor) {
  check_range("preset", factor, 1e-6, 10, "scale");
  Preset result = preset;
  result.cameras = std::max<std::int64_t>(2, rounded(factor * static_cast<double>(preset.cameras)));
  result.points = std::max<std::int64_t>(1, rounded(factor * static_cast<double>(preset.points)));
  double track = static_cast<double>(preset.observations) / static_cast<double>(preset.points);
  // A point of the ball is seen by a share of the cameras, whatever their number.
  const double cameras = static_cast<double>(result.cameras);
  if (preset.kind == Kind::sphere) track *= cameras / static_cast<double>(preset.cameras);
  track = std::clamp(track, 2.0, cameras);
  if (factor != 1) result.observations = rounded(track * static_cast<double>(result.points));
  return result;
}

Scene preset_scene(const Preset& preset, std::uint64_t seed) {
  switch (preset.kind) {
    case Kind::sphere:
      return sphere_scene({.seed = seed,
                           .cameras = preset.cameras,
                           .points = preset.points,
                           .observations = preset.observations});
    case Kind::street: {
      constexpr std::int64_t laps = 3, shortest_lap = 160;
      const std::int64_t lap = preset.cameras / laps / 4 * 4;
      return street_scene({.seed = seed,
                           .cameras = preset.cameras,
                           .points = preset.points,
                           .observations = preset.observations,
                           .far_share = preset.far_share,
                           .lap = lap < shortest_lap ? 0 : lap});
    }
    case Kind::aerial:
      return aerial_scene({.seed = seed,
                           .cameras = preset.cameras,
                           .points = preset.points,
                           .observations = preset.observations});
    case Kind::photos:
      break;
  }
  return photos_scene({.seed = seed,
                       .cameras = preset.cameras,
                       .points = preset.points,
                       .observations = preset.observations});
}

}  // namespace raybundle::scenes
