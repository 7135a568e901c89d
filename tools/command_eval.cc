// raybundle eval: how well the cameras and points of a problem explain its observations, and how
// far they are from the truth where that is known.

#include <array>
#include <charconv>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/objective.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/evaluation.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;
  std::string truth;
  std::string log;
  std::string cameras_csv;
  std::string points_csv;
  Loss loss = Loss::none;
  std::optional<LossScope> scope;
  std::optional<double> scale;

  /// The files to be written, by option; empty names: not asked for.
  struct Output {
    const char* option;
    const std::string& name;
  };
  std::array<Output, 3> outputs() const {
    return {{{"--log", log}, {"--cameras-csv", cameras_csv}, {"--points-csv", points_csv}}};
  }
};

double parse_scale(const std::string& text) {
  double scale = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, scale);
  if (error == std::errc() && last == end && scale >= 1e-100 && scale <= 1e100) return scale;
  throw OptionError("--loss-scale: '" + text + "' is not a number from 1e-100 to 1e100");
}

/// Whatever can be refused before the input is read. True when a file goes to standard output.
bool check(const Arguments& arguments) {
  if (arguments.loss == Loss::none && (arguments.scope || arguments.scale)) {
    throw OptionError(std::string(arguments.scale ? "--loss-scale" : "--loss-scope") +
                      " has no effect: there is no --loss");
  }
  if (arguments.input == "-" && arguments.truth == "-") {
    throw OptionError("INPUT and --truth are both standard input");
  }
  const auto outputs = arguments.outputs();
  bool standard = false;
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    check_result(outputs[i].option, outputs[i].name, arguments.input);
    check_result(outputs[i].option, outputs[i].name, arguments.truth);
    standard = standard || outputs[i].name == "-";
    for (std::size_t k = 0; k < i; ++k) {
      if (outputs[i].name.empty() || outputs[k].name.empty()) continue;
      if (!same_file(outputs[i].name, outputs[k].name)) continue;
      throw OptionError(std::string(outputs[k].option) + " and " + outputs[i].option +
                        " are the same: " + outputs[i].name);
    }
  }
  return standard;
}

Evaluation evaluate(const Arguments& arguments, const Problem& problem) {
  Evaluation result;
  result.source = arguments.input;
  result.cameras = problem.camera_count();
  result.points = problem.point_count();
  result.observations = problem.observation_count();
  result.loss = {arguments.loss, arguments.scope.value_or(LossScope::observation),
                 arguments.scale.value_or(default_scale(arguments.loss))};
  result.pixels = reprojection_statistics(problem);
  // Of the solver's own function, so that the file a solve wrote has the cost that its log says.
  linalg::ThreadPool pool(linalg::available_threads());
  Objective objective(problem, {}, pool, result.loss);
  result.cost = objective.cost(objective.state_of(problem));
  if (!arguments.truth.empty()) {
    result.truth_source = arguments.truth;
    result.truth = naming("truth", arguments.truth,
                          [&] { return compare_with_truth(problem, read_truth(arguments.truth)); });
  }
  return result;
}

void write_breakdown(const Arguments& arguments, const Problem& problem,
                     const std::optional<TruthErrors>& truth) {
  if (arguments.cameras_csv.empty() && arguments.points_csv.empty()) return;
  const ReprojectionBreakdown breakdown = reprojection_breakdown(problem);
  if (!arguments.cameras_csv.empty()) {
    write_cameras_csv(arguments.cameras_csv, problem, breakdown, truth);
  }
  if (!arguments.points_csv.empty()) {
    write_points_csv(arguments.points_csv, problem, breakdown, truth);
  }
}

ExitCode run(const Arguments& arguments) {
  const bool standard_output_taken = check(arguments);
  const Problem problem = read_input(arguments.input);
  const Evaluation evaluation = evaluate(arguments, problem);
  write_breakdown(arguments, problem, evaluation.truth);
  if (!arguments.log.empty()) {
    io::write_file_atomically(output_path(arguments.log), evaluation_json(evaluation));
  }
  print_report(evaluation_report(evaluation), standard_output_taken);
  return ExitCode::usable;
}

void add_files(CLI::App& parser, Arguments& arguments) {
  const auto add = [&parser](const char* option, std::string& name, const char* help,
                             const char* kind) {
    parser.add_option(option, name, help)->type_name(kind)->check(has_name, "");
  };
  add("--truth", arguments.truth,
      "The same cameras and points where they really are, as BAL:\n"
      "errors of centres and points after alignment by similarities;\n"
      "or cameras alone: a file in ParallaxBA's columns, or a folder [none]",
      "TRUTH");
  add("--cameras-csv", arguments.cameras_csv,
      "Write residuals, centre and error of each camera here;\n- is standard output [none]",
      "FILE");
  add("--points-csv", arguments.points_csv, "The same of each point [none]", "FILE");
  add("--log", arguments.log, "Write the results here, in JSON; - is standard output [none]",
      "LOG.json");
}

}  // namespace

const char* const input_help =
    "A BAL file, plain or compressed (gzip, bzip2, xz, zstd), or a\n"
    "folder in ParallaxBA's format; - is standard input";

Command add_eval(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "eval", "Cost, RMSE, largest residual and points behind cameras of a problem; errors");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("INPUT", arguments->input, input_help)->type_name("")->required();
  add_files(*parser, *arguments);
  const auto text_option = [&](const char* option, const char* help, const auto& assign) {
    return parser->add_option_function<std::string>(option, assign, help);
  };
  text_option("--loss", "Robust loss of the cost [none]", [arguments](const std::string& text) {
    arguments->loss = parse_enum<Loss>("loss", text);
  })->type_name("none|huber|soft-l1|cauchy|geman-mcclure|tukey|truncated");
  text_option("--loss-scope", "What the loss is of [observation]",
              [arguments](const std::string& text) {
                arguments->scope = parse_enum<LossScope>("loss-scope", text);
              })
      ->type_name("observation|component");
  text_option("--loss-scale",
              "Scale of the loss, pixels\n[3 for geman-mcclure and truncated, 6 for tukey, else 1]",
              [arguments](const std::string& text) { arguments->scale = parse_scale(text); })
      ->type_name("X");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
