#include <raybundle/models/scenes/presets.h>

#include <algorithm>
#include <array>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/sphere.h>

namespace raybundle::scenes {
namespace {

std::vector<Preset> all_presets() {
  // Deviations that give RMSE of 42 and 9 for camera centres and points, amid the thesis' tables.
  const StartOptions far = {.rotation = 0.05, .position = 0.07, .focal = 0.02, .point = 0.02};
  return {
      {"sphere-10", Kind::sphere, 10, 289, 1'834, {}, far},
      {"sphere-50", Kind::sphere, 50, 1'000, 28'991, {}, far},
      {"sphere-100", Kind::sphere, 100, 4'000, 228'658, {}, far},
      {"sphere-500", Kind::sphere, 500, 5'000, 1'477'513, {}, far},
  };
}

std::int64_t rounded(double value) { return static_cast<std::int64_t>(value + 0.5); }

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
  return sphere_scene({seed, preset.cameras, preset.points, preset.observations});
}

}  // namespace raybundle::scenes
