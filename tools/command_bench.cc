// raybundle bench: solvers compared on problems, each run in a process of its own.

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/bench_call.h>
#include <raybundle/tools/bench_report.h>
#include <raybundle/tools/bench_runner.h>
#include <raybundle/tools/bench_stamp.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/interrupt.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

namespace fs = std::filesystem;

// Far below what matters, so that every method goes on until it has nothing more to give.
constexpr const char* default_common =
    "--max-iterations 500 --function-tolerance 1e-16 --gradient-tolerance 1e-16 "
    "--parameter-tolerance 1e-16";

constexpr const char* plan_name = "plan.json";

struct Arguments {
  BenchCall call;
  std::string folder;
  bool only_report = false;
};

void say(const std::string& line) { std::fputs((line + "\n").c_str(), stderr); }

/// The Ceres driver of the same build.
std::string built_ceres() {
  const fs::path beside =
      fs::read_symlink("/proc/self/exe").parent_path() / ".." / "bench" / "bench_ceres";
  return fs::exists(beside) ? fs::canonical(beside).string() : "";
}

BenchArguments default_arguments(const BenchCall& call) {
  BenchArguments arguments;
  arguments.common = default_common;
  arguments.threads = static_cast<int>(linalg::available_threads());
  if (!call.ceres) arguments.ceres = built_ceres();
  return arguments;
}

/// What is to be done: what an earlier call left, or defaults, with what is given instead.
BenchPlan plan_of(const Arguments& arguments) {
  if (arguments.only_report) check_report_call(arguments.call);
  const fs::path kept = fs::path(arguments.folder) / plan_name;
  if (names_problems(arguments.call)) {
    return make_plan(changed_by(arguments.call, default_arguments(arguments.call)),
                     arguments.folder);
  }
  if (!fs::exists(kept)) {
    throw OptionError("no PROBLEM and no --scene, and no earlier bench in " + arguments.folder);
  }
  const BenchArguments earlier = bench_arguments(file_text(kept), kept.string());
  return make_plan(changed_by(arguments.call, earlier), arguments.folder);
}

void save(const BenchPlan& plan) {
  io::write_file_atomically(plan.folder / plan_name, to_json(plan.arguments));
}

ExitCode run(const Arguments& arguments) {
  const BenchPlan plan = plan_of(arguments);
  RunCounts counts;
  if (arguments.only_report) {
    if (!arguments.call.best.empty()) save(plan);
  } else {
    const InterruptGuard interrupt(false);
    counts = run_plan(plan, interrupt, [&plan] { save(plan); });
    if (!counts.accepted) {
      say("interrupted before the first run; " + arguments.folder + " is as it was");
      return ExitCode::interrupted;
    }
  }
  const std::string complaint = write_reports(plan);
  if (!complaint.empty()) say(complaint);
  if (counts.interrupted) {
    say("interrupted; the same call again goes on: raybundle bench -o " + arguments.folder);
    return ExitCode::interrupted;
  }
  print("results in " + (plan.folder / "summary.md").string() + "\n");
  if (counts.refused == 0) return ExitCode::usable;
  say("raybundle: " + count_text(counts.refused, "run") + " could not be carried out");
  return ExitCode::failure;
}

void add_problem_options(CLI::App& parser, BenchCall& call) {
  parser
      .add_option("PROBLEM", call.problems,
                  "[NAME=]FILE[:TRUTH], a BAL file or a folder in ParallaxBA's\n"
                  "format, and where known its truth, as of eval.\n"
                  "None, and no --scene: what the last call for FOLDER was given,\n"
                  "but for the options given now")
      ->type_name("");
  parser.add_option("--scene", call.scenes, "A scene that `raybundle generate ARGUMENTS` makes")
      ->type_name("NAME=ARGUMENTS")
      ->take_all();
  parser
      .add_option("--best", call.best, "Cost of the best solution known of a problem [least found]")
      ->type_name("NAME=COST")
      ->take_all();
}

void add_variant_options(CLI::App& parser, BenchCall& call) {
  parser
      .add_option("--variant", call.variants,
                  "A method with its options of `raybundle solve` [every method]")
      ->type_name("NAME=OPTIONS")
      ->take_all();
  parser
      .add_option("--common", call.common,
                  "Options of all variants that do not say otherwise\n[" +
                      std::string(default_common) + "]")
      ->type_name("OPTIONS");
  parser
      .add_option("--ceres", call.ceres,
                  "The Ceres driver to compare with, or none [that of this build, if there]")
      ->type_name("PROGRAM");
  parser
      .add_option("--ceres-variant", call.ceres_variants,
                  "Options of the Ceres driver [dense with Eigen, dense with LAPACK, sparse]")
      ->type_name("NAME=OPTIONS")
      ->take_all();
}

void add_limit_options(CLI::App& parser, BenchCall& call) {
  parser.add_option("--runs", call.runs, "Runs of every variant on every problem [3]")
      ->type_name("N");
  parser.add_option("--threads", call.threads, "Worker threads of every run; 0: all cores [0]")
      ->type_name("N")
      ->check(CLI::Range(0, 1024));
  parser.add_option("--time-limit", call.time_limit, "Seconds of each solve [300]")->type_name("S");
  parser
      .add_option_function<std::string>(
          "--memory-limit",
          [&call](const std::string& text) {
            call.memory_limit = static_cast<std::uint64_t>(parse_size("--memory-limit", text));
          },
          "Memory of each run, such as 4GB or 500MB [what the machine has]")
      ->type_name("SIZE");
}

}  // namespace

Command add_bench(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "bench", "Compare methods on problems: tables, plots and performance profiles");
  auto arguments = std::make_shared<Arguments>();
  add_problem_options(*parser, arguments->call);
  add_variant_options(*parser, arguments->call);
  add_limit_options(*parser, arguments->call);
  parser
      ->add_option("-o,--output", arguments->folder,
                   "Folder of all results. What it holds already of the same bench is not repeated")
      ->type_name("FOLDER")
      ->required();
  parser->add_flag("--only-report", arguments->only_report,
                   "Run nothing, only make the report again, --best applied [off]");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
