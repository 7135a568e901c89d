// raybundle increments: the search for finite-difference increments, and what it finds.

#include <cstddef>
#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/increments.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

std::string trials_table(const IncrementSearch& search) {
  std::string text = format("%-8s", "step");
  for (int k = 0; k < parameter_kinds; ++k) {
    text += format("%13s", name(static_cast<ParameterKind>(k)));
  }
  text += "\n";
  for (std::size_t row = 0; row < search.trials[0].size(); ++row) {
    text += format("%-8.0e", search.trials[0][row].step);
    for (const auto& trials : search.trials) text += format("%13.1e", trials[row].error);
    text += "\n";
  }
  return text;
}

ExitCode run(const std::string& input) {
  const Problem problem = read_input(input);
  linalg::ThreadPool pool(linalg::available_threads());
  const IncrementSearch search = search_increments(problem, pool);
  const Increments& found = search.found;
  std::string text = input + "\nrelative error of forward differences\n" + trials_table(search);
  text += format("\nsmallest steps with an error of at most %.1e:\n", search.attainable);
  text += format(
      "--inc-rotation %g --inc-translation %g --inc-focal %g --inc-k1 %g --inc-k2 %g "
      "--inc-point %g\n",
      found.rotation, found.translation, found.focal, found.k1, found.k2, found.point);
  print(text);
  return ExitCode::usable;
}

}  // namespace

Command add_increments(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "increments", "Search the finite-difference increments behind --scaling inc");
  auto input = std::make_shared<std::string>();
  parser->add_option("INPUT", *input, input_help)->type_name("")->required();
  return {parser, [input] { return run(*input); }};
}

}  // namespace raybundle::tools
