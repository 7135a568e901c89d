// raybundle increments: the search for finite-difference increments, and what it finds.

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/increments.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;
  PointModel points = PointModel::xyz;
};

std::vector<ParameterKind> kinds_of(PointModel points) {
  std::vector<ParameterKind> kinds;
  for (int k = 0; k < parameter_kinds; ++k) {
    const auto kind = static_cast<ParameterKind>(k);
    if (has_kind(points, kind)) kinds.push_back(kind);
  }
  return kinds;
}

std::string trials_table(const IncrementSearch& search, const std::vector<ParameterKind>& kinds) {
  std::string text = format("%-8s", "step");
  for (const ParameterKind kind : kinds) text += format("%13s", name(kind));
  text += "\n";
  for (std::size_t row = 0; row < search.trials[0].size(); ++row) {
    text += format("%-8.0e", search.trials[0][row].step);
    for (const ParameterKind kind : kinds) {
      text += format("%13.1e", search.trials[static_cast<std::size_t>(kind)][row].error);
    }
    text += "\n";
  }
  return text;
}

ExitCode run(const Arguments& arguments) {
  const Problem problem = read_input(arguments.input);
  linalg::ThreadPool pool(linalg::available_threads());
  const IncrementSearch search = search_increments(problem, arguments.points, pool);
  const std::vector<ParameterKind> kinds = kinds_of(arguments.points);
  std::string text =
      arguments.input + "\nrelative error of forward differences\n" + trials_table(search, kinds);
  text += format("\nsmallest steps with an error of at most %.1e:\n", search.attainable);
  for (const ParameterKind kind : kinds) {
    text += format("%s--inc-%s %g", kind == kinds.front() ? "" : " ", name(kind),
                   increment(search.found, kind));
  }
  print(text + "\n");
  return ExitCode::usable;
}

}  // namespace

Command add_increments(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "increments", "Search the finite-difference increments behind --scaling inc");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("INPUT", arguments->input, input_help)->type_name("")->required();
  parser
      ->add_option_function<std::string>(
          "--points",
          [arguments](const std::string& text) {
            arguments->points = parse_enum<PointModel>("points", text);
          },
          "How points are described [xyz]")
      ->type_name("xyz|idp|pba|pmba");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
