// raybundle rotations: averages the relative rotations of image pairs.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/epipolar_geometries.h>
#include <raybundle/solver/init/rotation_averaging.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;
  std::string output;
  double prune = 6;  // degrees
  int threads = 0;
};

constexpr double degree = std::numbers::pi / 180;

void check(const Arguments& arguments) {
  if (!(arguments.prune > 0)) throw OptionError("--prune: must be above 0 degrees");
  if (arguments.threads < 0) throw OptionError("--threads: must be 0 or more");
  if (names_folder(arguments.output)) {
    throw OptionError("--output: " + arguments.output + " is a folder");
  }
  check_result("--output", arguments.output, arguments.input);
}

/// Images by numbers of their own, as they come up in the file.
struct Pairs {
  std::vector<std::int32_t> image;
  std::vector<init::RelativeRotation> edges;
};

Pairs read_pairs(const std::string& input) {
  const auto geometries = io::read_epipolar_geometries(input);
  if (geometries.empty()) throw InputError(input, 0, "no pair", "lines \"i j R t\"");
  std::map<std::int32_t, std::int32_t> number;
  for (const auto& pair : geometries) number[pair.i] = number[pair.j] = 0;
  Pairs result;
  result.image.reserve(number.size());
  result.edges.reserve(geometries.size());
  for (auto& [image, own] : number) {
    own = static_cast<std::int32_t>(result.image.size());
    result.image.push_back(image);
  }
  for (const auto& pair : geometries) {  // R_i = R_ij R_j
    result.edges.push_back({number[pair.j], number[pair.i], pair.R_ij, 1});
  }
  return result;
}

std::string angles_text(const init::AngleStatistics& angles) {
  return format("mean %.3g, median %.3g, nine of ten below %.3g, largest %.3g degrees",
                angles.mean / degree, angles.median / degree, angles.upper_decile / degree,
                angles.largest / degree);
}

/// A line "image R" for each that is known, R row by row.
std::string rotations_text(const Pairs& pairs, const init::AveragedRotations& found) {
  std::string text;
  for (std::size_t i = 0; i < pairs.image.size(); ++i) {
    if (found.known[i] == 0) continue;
    text += std::to_string(pairs.image[i]);
    for (int k = 0; k < 9; ++k) text += " " + exact_text(found.R_cw[i](k / 3, k % 3));
    text += "\n";
  }
  return text;
}

ExitCode run(const Arguments& arguments) {
  check(arguments);
  const Pairs pairs = read_pairs(arguments.input);
  linalg::ThreadPool pool(arguments.threads > 0 ? arguments.threads : linalg::available_threads());
  const auto start = std::chrono::steady_clock::now();
  const auto found =
      init::average_rotations(static_cast<std::int64_t>(pairs.image.size()), pairs.edges,
                              {.prune = arguments.prune * degree}, pool);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const auto known = std::count(found.known.begin(), found.known.end(), 1);
  const auto pruned = std::count(found.pruned.begin(), found.pruned.end(), 1);
  Table table;
  table.add("pairs", arguments.input + ": " +
                         count_text(static_cast<std::int64_t>(pairs.edges.size()), "pair") +
                         " of " +
                         count_text(static_cast<std::int64_t>(pairs.image.size()), "image"));
  table.add("along a tree", angles_text(found.tree));
  table.add("chordal", angles_text(found.chordal));
  table.add("averaged", angles_text(found.before));
  table.add("", count_text(pruned, "pair") +
                    format(" off by more than %g degrees; without them", arguments.prune));
  table.add("", angles_text(found.after));
  table.add("known", count_text(known, "image"));
  table.add("time", format("%.3f s, %d iterations", seconds, found.iterations));
  if (!arguments.output.empty()) {
    io::write_file_atomically(output_path(arguments.output), rotations_text(pairs, found));
    table.add("result", arguments.output == "-" ? "standard output" : arguments.output);
  }
  const std::string report = table.text();
  if (arguments.output == "-") {
    std::fputs(report.c_str(), stderr);
  } else {
    print(report);
  }
  return ExitCode::usable;
}

}  // namespace

Command add_rotations(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "rotations", "Average the relative rotations of image pairs, as 1DSfM's data sets have them");
  auto arguments = std::make_shared<Arguments>();
  parser
      ->add_option("INPUT", arguments->input,
                   "EGs.txt: lines \"i j R t\", R = R_i R_j^T row by row")
      ->type_name("")
      ->required();
  parser
      ->add_option("-o,--output", arguments->output,
                   "Write rotations from world to camera here, a line \"i R\" for each\n"
                   "image; one of them has the identity; - is standard output")
      ->type_name("OUT")
      ->check(has_name, "");
  parser
      ->add_option("--prune", arguments->prune,
                   "Leave out pairs that disagree by more degrees than this [6]")
      ->type_name("X");
  parser->add_option("--threads", arguments->threads, "0: all cores [0]")->type_name("N");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
