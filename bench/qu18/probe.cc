// Measurements and plots for tools/reproduce. Results go to standard output, as JSON.
#include <raybundle/bench/qu18/probe.h>

#include <cstdio>
#include <exception>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/tools/bench_stamp.h>
#include <raybundle/tools/input.h>

namespace raybundle::bench {
namespace {

struct Arguments {
  std::string command;
  std::string input;
  std::string folder = ".";
  std::int64_t frames = 10;
  std::uint64_t seed = 1;
  int systems = 50;
  int threads = 2;
};

Json measure(const Arguments& arguments) {
  linalg::ThreadPool pool(arguments.threads);
  const Problem problem = tools::read_input(arguments.input);
  if (arguments.command == "residuals") return residuals(problem, pool);
  if (arguments.command == "geometry") return geometry(problem);
  const Problem part = sub_dataset(problem, arguments.frames, arguments.seed);
  if (arguments.command == "matrix-forms") return matrix_forms(part, pool);
  if (arguments.command == "linear-solvers") return linear_solvers(part, arguments.systems, pool);
  return taylor(part, arguments.seed, pool);
}

int run(const Arguments& arguments) {
  if (arguments.command == "draw") {
    const Json specification = Json::parse(tools::file_text(arguments.input));
    const std::string complaint = draw(specification, arguments.folder);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "%s\n", complaint.c_str());
    return 1;
  }
  std::printf("%s\n", measure(arguments).dump().c_str());
  return 0;
}

}  // namespace
}  // namespace raybundle::bench

int main(int argc, char** argv) {
  CLI::App program("Measurements and plots for tools/reproduce");
  program.require_subcommand(1);
  raybundle::bench::Arguments arguments;
  const auto add = [&](const char* name, const char* help) {
    CLI::App* command = program.add_subcommand(name, help);
    command->add_option("INPUT", arguments.input, "A BAL file; draw: JSON")->required();
    command->callback([&arguments, name] { arguments.command = name; });
    return command;
  };
  add("draw", "Plots")->add_option("-o,--output", arguments.folder, "Folder of the plots [.]");
  add("residuals", "Observed and projected positions, and the gradient");
  add("geometry", "Camera centres and points");
  for (CLI::App* command : {add("matrix-forms", "Four forms of J and H"),
                            add("linear-solvers", "CG, Cholesky and LU on reduced systems"),
                            add("taylor", "Remainder of the linearisation")}) {
    command->add_option("--frames", arguments.frames, "Frames of the sub-dataset [10]");
    command->add_option("--seed", arguments.seed, "Seed of the choice of frames [1]");
    command->add_option("--systems", arguments.systems, "linear-solvers: how many [50]");
    command->add_option("--threads", arguments.threads, "Worker threads [2]");
  }
  CLI11_PARSE(program, argc, argv);
  try {
    return raybundle::bench::run(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
