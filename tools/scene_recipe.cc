#include <raybundle/tools/scene_recipe.h>

#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/presets.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/solver/option_table.h>

namespace raybundle::tools {
namespace {

std::optional<scenes::Kind> kind_of(const std::string& word) {
  for (const scenes::Kind kind : scenes::all_kinds) {
    if (word == scenes::name(kind)) return kind;
  }
  return std::nullopt;
}

template <class Value>
void take(const std::optional<Value>& given, Value& value) {
  if (given) value = *given;
}

template <class Value>
void refuse(const std::string& option, const std::optional<Value>& given, const std::string& why) {
  if (given) throw OptionError(option + " has no effect: " + why);
}

template <class KindOptions>
void take_counts(const SceneRequest& request, KindOptions& options) {
  options.seed = request.seed;
  take(request.cameras, options.cameras);
  take(request.points, options.points);
  take(request.observations, options.observations);
}

/// Options of one kind of scene only. `given`: none for a preset.
void check_kind_options(const SceneRequest& request, std::optional<scenes::Kind> given) {
  using scenes::Kind;
  const auto only_for = [&](Kind kind, const char* option, const auto& value) {
    if (given == kind) return;
    refuse(option, value,
           given ? std::string("it is for the kind ") + scenes::name(kind)
                 : request.what + " is a preset, which fixes all of the scene but its size");
  };
  only_for(Kind::sphere, "--region", request.region);
  only_for(Kind::street, "--far", request.far_share);
  only_for(Kind::street, "--collinear", request.collinear_share);
  only_for(Kind::street, "--lap", request.lap);
  only_for(Kind::aerial, "--height", request.height);
  only_for(Kind::photos, "--sights", request.sights);
}

scenes::Scene scene_of(const SceneRequest& request, scenes::Kind kind) {
  check_kind_options(request, kind);
  refuse("--scale", request.scale, "only presets have a size of their own");
  switch (kind) {
    case scenes::Kind::sphere: {
      if (request.observations.value_or(0) != 0) {
        refuse("--region", request.region, "--observations decides what it is");
      }
      scenes::SphereOptions options;
      take_counts(request, options);
      take(request.region, options.region);
      return scenes::sphere_scene(options);
    }
    case scenes::Kind::street: {
      scenes::StreetOptions options;
      take_counts(request, options);
      take(request.far_share, options.far_share);
      take(request.collinear_share, options.collinear_share);
      take(request.lap, options.lap);
      return scenes::street_scene(options);
    }
    case scenes::Kind::aerial: {
      scenes::AerialOptions options;
      take_counts(request, options);
      take(request.height, options.height);
      return scenes::aerial_scene(options);
    }
    case scenes::Kind::photos:
      break;
  }
  scenes::PhotosOptions options;
  take_counts(request, options);
  take(request.sights, options.sights);
  return scenes::photos_scene(options);
}

void check_preset(const std::string& what) {
  for (const scenes::Preset& each : scenes::presets()) {
    if (each.name == what) return;
  }
  throw OptionError("'" + what + "' is neither a kind (" + kind_names() + ") nor a preset (" +
                    preset_names() + ")");
}

SceneRecipe preset_recipe(const SceneRequest& request) {
  check_preset(request.what);
  const std::string why = request.what + " has counts of its own; --scale changes them";
  refuse("--cameras", request.cameras, why);
  refuse("--points", request.points, why);
  refuse("--observations", request.observations, why);
  check_kind_options(request, std::nullopt);
  const scenes::Preset preset =
      scenes::resized(scenes::preset(request.what), request.scale.value_or(1));
  return {scenes::preset_scene(preset, request.seed), preset.noise, preset.start};
}

}  // namespace

std::string kind_names() {
  std::string names;
  for (const scenes::Kind kind : scenes::all_kinds) {
    names += (names.empty() ? "" : ", ") + std::string(scenes::name(kind));
  }
  return names;
}

std::string preset_names() {
  std::string names;
  for (const scenes::Preset& each : scenes::presets()) {
    names += (names.empty() ? "" : ", ") + each.name;
  }
  return names;
}

SceneRecipe recipe_of(const SceneRequest& request) {
  const auto kind = kind_of(request.what);
  SceneRecipe recipe =
      kind ? SceneRecipe{scene_of(request, *kind), {}, {}} : preset_recipe(request);
  recipe.noise.seed = recipe.start.seed = request.noise_seed.value_or(request.seed);
  take(request.pixel_noise, recipe.noise.pixel_noise);
  take(request.outliers, recipe.noise.outlier_share);
  take(request.start_rotation, recipe.start.rotation);
  take(request.start_position, recipe.start.position);
  if (request.true_lenses) {
    refuse("--start-focal", request.start_focal, "--true-lenses keeps the focal lengths");
    recipe.start.focal = 0;
    recipe.start.distortion = true;
  }
  take(request.start_focal, recipe.start.focal);
  take(request.start_point, recipe.start.point);
  return recipe;
}

}  // namespace raybundle::tools
