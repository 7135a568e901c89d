// raybundle generate: writes a synthetic scene as a problem to solve, with its truth beside it.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>
#include <raybundle/tools/scene_recipe.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  SceneRequest scene;
  std::string output;
  std::string truth;
};

/// ("scene.txt", "truth") -> "scene.truth.txt"; nothing beside standard output.
std::string beside(const std::string& output, const std::string& what) {
  if (output == "-") return "";
  const std::filesystem::path path = output;
  std::filesystem::path name = path.stem();
  name += "." + what;
  name += path.extension();
  return (path.parent_path() / name).string();
}

/// Where all goes; empty: nowhere.
struct Outputs {
  std::string problem, truth, outliers;
};

Outputs outputs_of(const Arguments& arguments) {
  Outputs outputs = {arguments.output, arguments.truth, ""};
  if (outputs.truth.empty()) outputs.truth = beside(arguments.output, "truth");
  if (arguments.scene.outliers.value_or(0) > 0)
    outputs.outliers = beside(arguments.output, "outliers");
  return outputs;
}

void check_outputs(const Outputs& outputs) {
  if (!outputs.truth.empty() && same_file(outputs.problem, outputs.truth)) {
    throw OptionError("--output and --truth are the same: " + outputs.problem);
  }
  if (!outputs.outliers.empty() && same_file(outputs.outliers, outputs.truth)) {
    throw OptionError("--truth is where the list of outliers goes: " + outputs.outliers);
  }
  check_result("--output", outputs.problem, "");
  check_result("--truth", outputs.truth, "");
  check_result("the list of outliers", outputs.outliers, "");
}

/// Their indices, from 0 in the order of the file, one per line.
void write_outliers(const std::string& output, const std::vector<std::int64_t>& outliers) {
  std::string text;
  for (const std::int64_t index : outliers) text += std::to_string(index) + "\n";
  io::write_file_atomically(output, text);
}

/// What is legal but deserves attention, and counts that the geometry could not give.
void warn(const Arguments& arguments, const StructureStatistics& structure) {
  std::vector<std::string> sentences = warnings(structure);
  const std::int64_t asked = arguments.scene.observations.value_or(0);
  if (asked != 0 && asked != structure.observations) {
    sentences.push_back(std::to_string(structure.observations) + " observations instead of " +
                        std::to_string(asked) + ": the geometry does not give as many");
  }
  for (const std::string& each : sentences) std::fputs(("warning: " + each + "\n").c_str(), stderr);
}

std::string report(const std::string& title, const StructureStatistics& s, const Problem& start,
                   const scenes::NoisyProblem& noisy, const Outputs& outputs) {
  const ReprojectionStatistics before = reprojection_statistics(start);
  const ReprojectionStatistics there = reprojection_statistics(noisy.problem);
  const auto count = [](std::int64_t value) { return std::to_string(value); };
  Table table;
  table.add("cameras", count(s.cameras));
  table.add("points", count(s.points));
  table.add("observations", count(s.observations));
  table.add("outliers", count(static_cast<std::int64_t>(noisy.outliers.size())));
  table.add("track length", format("mean %.2f, longest %s observations of a point",
                                   s.mean_track_length, count(s.longest_track).c_str()));
  table.add("per camera",
            format("fewest %s, most %s observations", count(s.fewest_observations).c_str(),
                   count(s.most_observations).c_str()));
  table.add("connectivity", s.components == 1 ? "one connected set of cameras"
                                              : count(s.components) + " sets of cameras");
  table.add("cost", format("%.6e at the start, %.6e at the truth", before.cost, there.cost));
  table.add("RMSE", format("%.6g px at the start, %.6g px at the truth", before.rmse, there.rmse));
  if (!outputs.truth.empty()) table.add("truth", outputs.truth);
  if (!outputs.outliers.empty()) table.add("list of outliers", outputs.outliers);
  return title + "\n" + table.text();
}

ExitCode run(const Arguments& arguments) {
  const Outputs outputs = outputs_of(arguments);
  check_outputs(outputs);
  Problem start;
  scenes::NoisyProblem noisy;
  try {
    SceneRecipe recipe = recipe_of(arguments.scene);
    noisy = scenes::add_noise(recipe.scene, recipe.noise);
    recipe.scene = {};  // the largest presets take a GB
    start = scenes::perturb(noisy.problem, recipe.start);
  } catch (const InputError& error) {  // whatever a scene is made from is an option here
    throw OptionError(error.what());
  }
  io::write_bal(start, std::filesystem::path(output_path(outputs.problem)));
  if (!outputs.truth.empty()) {
    io::write_bal(noisy.problem, std::filesystem::path(output_path(outputs.truth)));
  }
  if (!outputs.outliers.empty()) write_outliers(outputs.outliers, noisy.outliers);

  const StructureStatistics structure = structure_statistics(start);
  warn(arguments, structure);
  const std::string title = arguments.scene.what + ", seed " +
                            std::to_string(arguments.scene.seed) + ": " + arguments.output;
  const std::string text = report(title, structure, start, noisy, outputs);
  if (outputs.problem == "-" || outputs.truth == "-") {
    std::fputs(text.c_str(), stderr);
  } else {
    print(text);
  }
  return ExitCode::usable;
}

std::string what_help() {
  return "A kind (" + kind_names() + ")\nor a preset (" + preset_names() + ")";
}

/// "sphere 10, street 30, ...": the default of a count, by kind.
template <class Count>
std::string by_kind(const Count& count) {
  return " [sphere " + std::to_string(count(scenes::SphereOptions{})) + ", street " +
         std::to_string(count(scenes::StreetOptions{})) + ", aerial " +
         std::to_string(count(scenes::AerialOptions{})) + ", photos " +
         std::to_string(count(scenes::PhotosOptions{})) + "]";
}

void add_scene_options(CLI::App& parser, Arguments& arguments) {
  const auto add_seed = [&parser](const char* option, const char* help, auto& seed) {
    parser
        .add_option_function<std::string>(
            std::string("--") + option,
            [option, &seed](const std::string& text) { seed = parse_seed(option, text); }, help)
        ->type_name("N");
  };
  add_seed("seed", "Seed of scene, noise and start [1]", arguments.scene.seed);
  add_seed("noise-seed",
           "Seed of noise and start, for the same scene with others [that of the scene]",
           arguments.scene.noise_seed);
  parser
      .add_option("--cameras", arguments.scene.cameras,
                  "Number of cameras, at least 2" + by_kind([](auto o) { return o.cameras; }))
      ->type_name("N");
  parser
      .add_option("--points", arguments.scene.points,
                  "Number of points, at least 1" + by_kind([](auto o) { return o.points; }))
      ->type_name("N");
  parser
      .add_option("--observations", arguments.scene.observations,
                  "Number of observations; 0: what the geometry gives [0]")
      ->type_name("N");
  parser
      .add_option(
          "--region", arguments.scene.region,
          "sphere: cameras stand within this angle of one direction, radians,\n0 to pi [0.6]")
      ->type_name("X");
  parser
      .add_option("--far", arguments.scene.far_share,
                  "street: share of the features, 0 to 1, that are far ahead [0.1]")
      ->type_name("X");
  parser
      .add_option("--collinear", arguments.scene.collinear_share,
                  "street: share of the points, 0 to 1, on the line along which the cameras that\n"
                  "see them move [0]")
      ->type_name("X");
  parser
      .add_option(
          "--lap", arguments.scene.lap,
          "street: steps round the block until the way repeats, a multiple of 4\nfrom 160; 0: no "
          "loop [0]")
      ->type_name("N");
  parser
      .add_option("--height", arguments.scene.height,
                  "aerial: of the flight, in distances between images; the higher, the less "
                  "parallax;\n1 to 1e+06 [20]")
      ->type_name("X");
  parser
      .add_option("--sights", arguments.scene.sights,
                  "photos: number of sights; 0: one per 60 cameras [0]")
      ->type_name("N");
  parser
      .add_option("--scale", arguments.scene.scale,
                  "Presets: multiply the counts by this, 1e-06 to 10 [1]")
      ->type_name("X");
}

void add_noise_options(CLI::App& parser, Arguments& arguments) {
  parser.add_flag("--true-lenses", arguments.scene.true_lenses,
                  "Lenses start as they are, for solves that keep them [off: without distortion]");
  const auto add = [&parser](const char* name, std::optional<double>& value, const char* help) {
    parser.add_option(name, value, help)->type_name("X");
  };
  add("--pixel-noise", arguments.scene.pixel_noise,
      "Standard deviation of the observations, pixels, from 0 [1]");
  add("--outliers", arguments.scene.outliers,
      "Share of the observations, 0 to 1, that are wrong; which, says a file\n"
      "named as OUT with .outliers before its ending [0]");
  add("--start-rotation", arguments.scene.start_rotation,
      "Deviation of the starting rotation vectors, radians, from 0 [0.002, presets: their own]");
  add("--start-position", arguments.scene.start_position,
      "... of the camera centres, relative to the depth of what they see [0.004, presets: their "
      "own]");
  add("--start-focal", arguments.scene.start_focal,
      "... of the focal lengths, relative, 0 to 0.25 [0.01, presets: their own]");
  add("--start-point", arguments.scene.start_point,
      "... of the points, relative to their depth in the nearest camera [0.004, presets: their "
      "own]");
}

}  // namespace

Command add_generate(CLI::App& program) {
  CLI::App* parser =
      program.add_subcommand("generate", "Make a synthetic scene, with its truth beside it");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("SCENE", arguments->scene.what, what_help())->type_name("")->required();
  parser
      ->add_option("-o,--output", arguments->output,
                   "Write the problem to solve here, as BAL; - is standard output")
      ->type_name("OUT")
      ->check(has_name, "")
      ->required();
  parser
      ->add_option("--truth", arguments->truth,
                   "Write the true cameras and points here, with the same observations "
                   "[OUT with .truth before its ending; none beside standard output]")
      ->type_name("TRUTH")
      ->check(has_name, "");
  add_scene_options(*parser, *arguments);
  add_noise_options(*parser, *arguments);
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
