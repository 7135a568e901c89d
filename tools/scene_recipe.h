#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/scene.h>

namespace raybundle::tools {

/// The scene that a command line asks for; the defaults depend on what it is.
struct SceneRequest {
  std::string what;  ///< a kind or a preset
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> noise_seed;
  std::optional<std::int64_t> cameras, points, observations;
  std::optional<double> region, far_share, collinear_share, height;  ///< of one kind each
  std::optional<std::int64_t> lap, sights;
  std::optional<double> scale;  ///< of presets only
  std::optional<double> pixel_noise, outliers;
  std::optional<double> start_rotation, start_position, start_focal, start_point;
  bool true_lenses = false;
};

/// What makes a problem to solve.
struct SceneRecipe {
  scenes::Scene scene;
  scenes::NoiseOptions noise;
  scenes::StartOptions start;
};

/// Throws OptionError for what is unknown or has no effect, InputError for impossible values.
SceneRecipe recipe_of(const SceneRequest& request);

/// "sphere, street, ...", and the presets alike.
std::string kind_names();
std::string preset_names();

}  // namespace raybundle::tools
