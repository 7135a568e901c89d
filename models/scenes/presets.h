#pragma once

#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/scene.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace raybundle::scenes {

enum class Kind { sphere, street, aerial, photos };
inline constexpr std::array all_kinds = {Kind::sphere, Kind::street, Kind::aerial, Kind::photos};

const char* name(Kind kind);

/// A scene with the counts of a known problem, and the noise and the start that go with it.
struct Preset {
  std::string name;
  Kind kind;
  std::int64_t cameras;
  std::int64_t points;
  std::int64_t observations;
  NoiseOptions noise;
  StartOptions start;
  double far_share = 0.005;  ///< street: see StreetOptions
};

/// sphere-10 to sphere-500: the four synthetic data sets of [Qu18, 5.3], with starts as far off as
/// those of Tables 5.1 to 5.4. The others: problems of Bundle Adjustment in the Large, with starts
/// whose cost is 50 to 250 times the final one, as it is there. village to fake-pile-135: the
/// counts of [Liu18, Table 4], from the air or with many far features.
const std::vector<Preset>& presets();

/// Throws InputError for a name that is none.
const Preset& preset(const std::string& name);

/// The same with all counts multiplied by `factor`, above 0 and at most 10, and points per camera
/// and observations per point kept as far as they can be. Throws InputError for other factors.
Preset resized(const Preset& preset, double factor);

Scene preset_scene(const Preset& preset, std::uint64_t seed = 1);

}  // namespace raybundle::scenes
