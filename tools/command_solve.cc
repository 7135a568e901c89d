// raybundle solve: reads or makes a problem, solves it, writes solution, log and report.

#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/models/statistics.h>
#include <raybundle/solver/solve.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/interrupt.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/progress.h>
#include <raybundle/tools/record.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;  // empty: the street scene
  std::string output;
  std::string log;
  std::optional<std::uint64_t> seed;
  bool quiet = false;
  Options options;
};

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

void say(const std::string& line) { std::fputs((line + "\n").c_str(), stderr); }

void say_warnings(const std::vector<std::string>& warnings) {
  for (const std::string& warning : warnings) say("warning: " + warning);
}

/// A folder holds cameras of one fixed lens and what they observed, but no points.
void check_output_folder(const Arguments& arguments, const Options& effective) {
  const std::string folder = "--output: the folder " + arguments.output + " ";
  if (!io::is_parallaxba(arguments.input)) {
    throw OptionError(folder +
                      "would be in ParallaxBA's format, without points, which INPUT is "
                      "not; name a file, and see raybundle convert");
  }
  if (effective.lens == Lens::free) {
    throw OptionError(folder +
                      "has one lens for all cameras, and each is to be solved for its "
                      "own; leave --lens fixed, or name a file");
  }
  check_folder("--output", arguments.output, arguments.input);
}

/// Whatever can be refused before the first long stage.
void check(const Arguments& arguments) {
  if (!arguments.input.empty() && arguments.seed) {
    throw OptionError("--seed has no effect: the problem comes from " + arguments.input);
  }
  check_apart(arguments.output, arguments.log);
  const Options effective = resolve(arguments.options);
  if (names_folder(arguments.output)) {
    check_output_folder(arguments, effective);
  } else {
    check_result("--output", arguments.output, arguments.input);
  }
  check_result("--log", arguments.log, arguments.input);
}

Problem obtain(const Arguments& arguments, SolveRecord& record) {
  const Stopwatch watch;
  Problem problem;
  if (arguments.input.empty()) {
    record.source = "street";
    record.seed = arguments.seed.value_or(scenes::StreetOptions{}.seed);
    if (!arguments.quiet) say("generating a street, seed " + std::to_string(*record.seed));
    problem = scenes::street({.seed = *record.seed});
  } else {
    record.source = arguments.input;
    if (!arguments.quiet) {
      say("reading " + (arguments.input == "-" ? "standard input" : arguments.input));
    }
    problem = read_input(arguments.input, arguments.options.threads);
  }
  record.read_seconds = watch.seconds();
  record.cameras = problem.camera_count();
  record.points = problem.point_count();
  record.observations = problem.observation_count();
  if (!arguments.quiet) {
    say(std::to_string(record.cameras) + " cameras, " + std::to_string(record.points) +
        " points, " + std::to_string(record.observations) + " observations");
  }
  say_warnings(warnings(degree_statistics(problem)));
  return problem;
}

Summary solve_shown(const Arguments& arguments, const std::string& source,
                    const InterruptGuard& interrupt, Problem& problem) {
  ProgressTable table;
  const auto observer = [&](const IterationRecord& record) {
    if (!arguments.quiet) table.show(record);
    return interrupt.signal() == nullptr ? Control::proceed : Control::stop;
  };
  Summary summary =
      naming("problem", source, [&] { return solve(problem, arguments.options, observer); });
  if (summary.termination == Termination::stopped) {
    summary.message = std::string("interrupted by ") + interrupt.signal();
  }
  return summary;
}

void write_solution(const Arguments& arguments, const Problem& problem, SolveRecord& record) {
  const std::string& output = arguments.output;
  const Stopwatch watch;
  if (names_folder(output)) {
    io::write_parallaxba(problem, output);
  } else {
    io::write_bal(problem, std::filesystem::path(output_path(output)), arguments.options.threads);
  }
  record.write_seconds = watch.seconds();
  record.output = shown_name(output);
  const std::vector<std::string> lost = file_warnings(record, problem, names_folder(output));
  say_warnings(lost);
  record.warnings.insert(record.warnings.end(), lost.begin(), lost.end());
}

void write_log(const std::string& log, SolveRecord& record) {
  io::write_file_atomically(output_path(log), log_json(record));
  record.log = shown_name(log);
}

void write_report(const Arguments& arguments, const SolveRecord& record) {
  print_report(solve_report(record), arguments.output == "-" || arguments.log == "-");
}

/// Solution, log and report, each tried whatever became of the others. False when one failed.
bool write_all(const Arguments& arguments, const Problem& problem, SolveRecord& record) {
  bool good = true;
  const auto attempt = [&good](const auto& write) {
    try {
      write();
    } catch (const std::system_error& error) {
      say(std::string("raybundle: ") + error.what());
      good = false;
    }
  };
  attempt([&] {
    if (!arguments.output.empty()) write_solution(arguments, problem, record);
  });
  attempt([&] {
    if (!arguments.log.empty()) write_log(arguments.log, record);
  });
  attempt([&] { write_report(arguments, record); });
  return good;
}

ExitCode exit_code(const Summary& summary) {
  if (summary.termination == Termination::out_of_memory) return ExitCode::no_memory;
  switch (outcome(summary.termination)) {
    case Outcome::converged:
      return ExitCode::usable;
    case Outcome::limit_reached: {
      const bool no_step = summary.iterations.size() <= 1;
      const bool lower = summary.final_cost < summary.initial_cost;
      return no_step || lower ? ExitCode::usable : ExitCode::numerical_failure;
    }
    case Outcome::interrupted:
      return ExitCode::interrupted;
    case Outcome::failed:
      break;
  }
  return ExitCode::numerical_failure;
}

/// What a folder in ParallaxBA's format says by being one: its K is known, and its points come from
/// the rays, so that their parallax is exact.
void take_folder_defaults(Arguments& arguments) {
  if (!io::is_parallaxba(arguments.input)) return;
  Options& options = arguments.options;
  if (!options.point_start) options.point_start = PointStart::rays;
  if (!options.lens) options.lens = Lens::fixed;
}

ReprojectionStatistics reprojection(const Problem& problem, const Options& options) {
  linalg::ThreadPool pool(options.threads > 0 ? options.threads : linalg::available_threads());
  return reprojection_statistics(problem, pool);
}

/// The figures of what the solve starts from.
void measure_start(const Problem& problem, const Options& effective, SolveRecord& record) {
  record.before = reprojection(problem, effective);
  if (has_loss(effective)) record.robust_before = robust_statistics(problem, *effective.loss_scale);
}

ExitCode run(Arguments arguments) {
  take_folder_defaults(arguments);
  check(arguments);
  SolveRecord record;
  Problem problem = obtain(arguments, record);
  const Options effective = resolve(arguments.options);
  if (effective.point_start == PointStart::problem) {
    measure_start(problem, effective, record);
  } else {
    measure_start(with_points_from_rays(problem, effective.points), effective, record);
  }
  const std::vector<std::string> at_start = start_warnings(record, effective);
  say_warnings(at_start);

  // Lives until all is written: by then an interrupt would only lose what has been computed.
  const InterruptGuard interrupt(!arguments.quiet);
  record.summary = solve_shown(arguments, record.source, interrupt, problem);
  record.after = reprojection(problem, effective);
  if (has_loss(effective)) record.robust_after = robust_statistics(problem, *effective.loss_scale);
  record.warnings = result_warnings(record);
  say_warnings(record.warnings);
  record.warnings.insert(record.warnings.begin(), at_start.begin(), at_start.end());

  if (!write_all(arguments, problem, record)) return ExitCode::failure;
  return exit_code(record.summary);
}

}  // namespace

Command add_solve(CLI::App& program) {
  CLI::App* parser = program.add_subcommand("solve", "Solve a bundle adjustment problem");
  auto arguments = std::make_shared<Arguments>();
  parser
      ->add_option("INPUT", arguments->input,
                   std::string(input_help) +
                       ".\nWithout it a street is made and solved: the\n"
                       "scene of generate street with noise of its own")
      ->type_name("")
      ->check(has_name, "");
  parser
      ->add_option("-o,--output", arguments->output,
                   "Write the solution here, as BAL; - is standard output. A folder\n"
                   "(one that is there, or ends in /): in ParallaxBA's format, where\n"
                   "INPUT is in it and lenses are fixed [none]")
      ->type_name("OUT")
      ->check(has_name, "");
  parser
      ->add_option("--log", arguments->log,
                   "Write a log here, in JSON; - is standard output [none]")
      ->type_name("LOG.json")
      ->check(has_name, "");
  parser
      ->add_option_function<std::string>(
          "--seed",
          [arguments](const std::string& text) { arguments->seed = parse_seed("seed", text); },
          "Seed of the generated scene [" + std::to_string(scenes::StreetOptions{}.seed) + "]")
      ->type_name("N");
  parser->add_flag("-q,--quiet", arguments->quiet, "No progress on standard error [off]");
  add_solver_options(*parser, arguments->options);
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
