// raybundle eval: how well the cameras and points of a problem explain its observations.

#include <memory>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

ExitCode run(const std::string& input) {
  const Problem problem = read_input(input);
  const ReprojectionStatistics statistics = reprojection_statistics(problem);
  // Of the solver's own function, so that the file a solve wrote has the cost that its log says.
  linalg::ThreadPool pool(linalg::available_threads());
  Objective objective(problem, PoseUpdate::local, Lens::free, pool);
  const double cost = objective.cost(Objective::state_of(problem));

  Table table;
  table.add("cost", format("%.6e", cost));
  table.add("cost, all digits", exact_text(cost));
  table.add("RMSE", format("%.9g px", statistics.rmse));
  table.add("largest residual", format("%.9g px", statistics.largest));
  table.add("behind cameras",
            format("%lld of %lld observations", static_cast<long long>(statistics.behind_camera),
                   static_cast<long long>(problem.observation_count())));
  print(input + "\n" + table.text());
  return ExitCode::usable;
}

}  // namespace

const char* const input_help =
    "A BAL file, plain or compressed (gzip, bzip2, xz, zstd);\n- is standard input";

Command add_eval(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "eval", "Cost, RMSE, largest residual and points behind cameras of a problem");
  auto input = std::make_shared<std::string>();
  parser->add_option("INPUT", *input, input_help)->type_name("")->required();
  return {parser, [input] { return run(*input); }};
}

}  // namespace raybundle::tools
