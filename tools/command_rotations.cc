// raybundle rotations: averages the relative rotations of image pairs.

#include <cstdint>
#include <map>
#include <memory>
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
#include <raybundle/solver/phase_timer.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>
#include <raybundle/tools/rotations_report.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::string log;
  double prune = 6;  // degrees
  int threads = 0;
};

void check(const Arguments& arguments) {
  if (!(arguments.prune > 0)) throw OptionError("--prune: must be above 0 degrees");
  if (arguments.threads < 0) throw OptionError("--threads: must be 0 or more");
  if (names_folder(arguments.output)) {
    throw OptionError("--output: " + arguments.output + " is a folder");
  }
  check_apart(arguments.output, arguments.log);
  check_result("--output", arguments.output, arguments.input);
  check_result("--log", arguments.log, arguments.input);
}

/// Images get numbers of their own, in ascending order of the file's.
void read_pairs(const std::string& input, RotationsRecord& record) {
  const auto geometries = io::read_epipolar_geometries(input);
  if (geometries.empty()) throw InputError(input, 0, "no pair", "lines \"i j R t\"");
  std::map<std::int32_t, std::int32_t> number;
  for (const auto& pair : geometries) number[pair.i] = number[pair.j] = 0;
  record.image.reserve(number.size());
  record.edges.reserve(geometries.size());
  for (auto& [image, own] : number) {
    own = static_cast<std::int32_t>(record.image.size());
    record.image.push_back(image);
  }
  for (const auto& pair : geometries) {  // R_i = R_ij R_j
    record.edges.push_back({number[pair.j], number[pair.i], pair.R_ij, 1});
  }
}

/// A line "image R" for each that is known, R row by row.
std::string rotations_text(const RotationsRecord& record) {
  std::string text;
  for (std::size_t i = 0; i < record.image.size(); ++i) {
    if (record.found.known[i] == 0) continue;
    text += std::to_string(record.image[i]);
    const Eigen::Matrix3d& R = record.found.R_cw[i];
    for (int k = 0; k < 9; ++k) text += " " + exact_text(R(k / 3, k % 3));
    text += "\n";
  }
  return text;
}

ExitCode run(const Arguments& arguments) {
  check(arguments);
  RotationsRecord record;
  record.source = arguments.input;
  record.prune = arguments.prune;
  read_pairs(arguments.input, record);
  record.threads = arguments.threads > 0 ? arguments.threads : linalg::available_threads();
  linalg::ThreadPool pool(record.threads);
  {
    const PhaseTimer timer(record.seconds);
    record.found = init::average_rotations(static_cast<std::int64_t>(record.image.size()),
                                           record.edges, {.prune = record.prune}, pool);
  }
  if (!arguments.output.empty()) {
    io::write_file_atomically(output_path(arguments.output), rotations_text(record));
    record.output = shown_name(arguments.output);
  }
  if (!arguments.log.empty()) {
    record.log = shown_name(arguments.log);
    io::write_file_atomically(output_path(arguments.log), rotations_json(record));
  }
  print_report(rotations_report(record), arguments.output == "-" || arguments.log == "-");
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
  parser->add_option("--log", arguments->log, "Write what was done here, as JSON")
      ->type_name("LOG")
      ->check(has_name, "");
  parser
      ->add_option("--prune", arguments->prune,
                   "Leave out pairs that disagree by more degrees than this [6]")
      ->type_name("X");
  parser->add_option("--threads", arguments->threads, "0: all cores [0]")->type_name("N");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
