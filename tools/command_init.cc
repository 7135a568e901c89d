// raybundle init: poses and points from observations and lenses alone.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include <unistd.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/solver/init/incremental.h>
#include <raybundle/solver/init/initialize.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/solver/phase_timer.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/init_report.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/interrupt.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::string log;
  bool quiet = false;
  bool incremental = false;
  init::InitializeOptions options;
};

void check_effects(const CLI::App& parser, const Arguments& arguments) {
  const auto refuse = [&parser](const std::string& name, const char* reason) {
    if (parser.count(name) > 0) throw OptionError(name + " has no effect " + reason);
  };
  if (arguments.incremental) {
    for (const char* name : {"--rotations", "--prune", "--loss", "--loss-scale"}) {
      refuse(name, "with --pipeline incremental");
    }
  } else if (arguments.options.positions.loss == Loss::none) {
    refuse("--loss-scale", "without a loss");
  }
}

void check(const Arguments& arguments) {
  if (names_folder(arguments.output)) {
    throw OptionError("--output: the folder " + arguments.output +
                      " would hold no points; name a file");
  }
  check_apart(arguments.output, arguments.log);
  check_result("--output", arguments.output, arguments.input);
  check_result("--log", arguments.log, arguments.input);
}

/// Stages and how far they are: a line each, on a terminal written over.
class StageLine {
 public:
  void show(const std::string& stage, std::int64_t done, std::int64_t all) {
    const auto now = Clock::now();
    const bool fresh = stage != stage_;
    if (!fresh && (!terminal_ || now - shown_ < std::chrono::milliseconds(200))) return;
    end();
    stage_ = stage;
    shown_ = now;
    const std::string share =
        all > 0 && terminal_ ? "  " + percent_text(done, all) + " of " + std::to_string(all) : "";
    std::fprintf(stderr, terminal_ ? "\r\033[K%s%s" : "%s%s\n", stage.c_str(), share.c_str());
    open_ = terminal_;
  }
  ~StageLine() { end(); }

 private:
  void end() {
    if (open_ && terminal_) std::fputs("\r\033[K", stderr);
    open_ = false;
  }

  using Clock = std::chrono::steady_clock;

  bool terminal_ = ::isatty(STDERR_FILENO) == 1;
  bool open_ = false;
  std::string stage_;
  Clock::time_point shown_;
};

/// What was placed, by the one or the other way.
init::Restriction place(const Arguments& arguments, Problem& problem, InitRecord& record) {
  const InterruptGuard interrupt(!arguments.quiet);
  StageLine line;
  const auto progress = [&](const char* stage, std::int64_t done, std::int64_t all) {
    if (!arguments.quiet) line.show(stage, done, all);
    return interrupt.signal() == nullptr ? Control::proceed : Control::stop;
  };
  return naming("problem", arguments.input, [&] {
    if (arguments.incremental) {
      const double threshold = arguments.options.relative_pose.threshold;
      const init::IncrementalOptions options = {.pairs = arguments.options.pairs,
                                                .relative_pose = arguments.options.relative_pose,
                                                .resection = {.threshold = 2 * threshold},
                                                .triangulation = {.threshold = threshold},
                                                .seed = arguments.options.seed,
                                                .threads = arguments.options.threads};
      record.incremental = init::reconstruct_incrementally(problem, options, progress);
      return init::placed_part(problem, *record.incremental);
    }
    init::InitializeOptions options = arguments.options;
    options.linear.scale = options.relative_pose.threshold;
    options.resection.threshold = 2 * options.relative_pose.threshold;
    record.global = init::initialize(problem, options, progress);
    return init::placed_part(problem, *record.global);
  });
}

void write_result(const Arguments& arguments, const Problem& placed, InitRecord& record) {
  io::write_bal(placed, std::filesystem::path(output_path(arguments.output)),
                arguments.options.threads);
  record.output = shown_name(arguments.output);
  if (placed.aspect != 1) std::fprintf(stderr, "warning: %s\n", square_pixels);
}

ExitCode exit_code(const InitRecord& record) {
  const bool no_memory =
      record.global && record.global->positions.termination == Termination::out_of_memory;
  switch (conclusion(record).ending) {
    case init::Ending::placed:
      return ExitCode::usable;
    case init::Ending::no_pose:
    case init::Ending::disagreement:
    case init::Ending::no_parallax:
      return ExitCode::bad_input;
    case init::Ending::not_computable:
      return no_memory ? ExitCode::no_memory : ExitCode::numerical_failure;
    case init::Ending::interrupted:
      return ExitCode::interrupted;
  }
  return ExitCode::numerical_failure;
}

ExitCode run(const Arguments& arguments) {
  check(arguments);
  InitRecord record;
  Problem problem;
  {
    const PhaseTimer timer(record.read_seconds);
    problem = read_input(arguments.input, arguments.options.threads);
  }
  record.source = arguments.input;
  record.cameras = problem.camera_count();
  record.points = problem.point_count();
  record.observations = problem.observation_count();
  record.seed = arguments.options.seed;
  record.rotation_source = arguments.options.rotation_source;
  record.threads =
      arguments.options.threads > 0 ? arguments.options.threads : linalg::available_threads();
  const Problem placed = place(arguments, problem, record).problem;
  const bool any = placed.camera_count() > 0;
  if (any && !arguments.output.empty()) write_result(arguments, placed, record);
  if (!arguments.log.empty()) {
    record.log = shown_name(arguments.log);
    io::write_file_atomically(output_path(arguments.log), init_json(record));
  }
  print_report(init_report(record), arguments.output == "-" || arguments.log == "-");
  const std::string& message = conclusion(record).message;
  if (!message.empty()) {
    std::fprintf(stderr, "raybundle: %s: %s\n", arguments.input.c_str(), message.c_str());
    if (!any && !arguments.output.empty()) {
      std::fprintf(stderr, "raybundle: %s was not written\n", arguments.output.c_str());
    }
  }
  return exit_code(record);
}

}  // namespace

Command add_init(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "init", "Find poses and points from observations and lenses alone, to be solved then");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("INPUT", arguments->input, input_help)->type_name("")->required();
  parser
      ->add_option("-o,--output", arguments->output,
                   "Write what was placed here, as BAL: cameras and points that were\n"
                   "not are left out; - is standard output")
      ->type_name("OUT")
      ->check(has_name, "");
  parser
      ->add_option("--log", arguments->log,
                   "Write what was done, and what became of each camera, here, as JSON")
      ->type_name("LOG")
      ->check(has_name, "");
  parser
      ->add_option_function<std::string>(
          "--pipeline",
          [arguments](const std::string& text) {
            if (text != "global" && text != "incremental") {
              throw OptionError("--pipeline: '" + text + "' is none of global, incremental");
            }
            arguments->incremental = text == "incremental";
          },
          "All images at once, or one batch after the other with a bundle\n"
          "adjustment after each [global]")
      ->type_name("global|incremental");
  parser
      ->add_option_function<std::string>(
          "--seed",
          [arguments](const std::string& text) {
            arguments->options.seed = parse_seed("seed", text);
          },
          "Of the samples: the same seed gives the same result [1]")
      ->type_name("N");
  parser->add_flag("-q,--quiet", arguments->quiet, "No progress on standard error [off]");
  add_init_options(*parser, arguments->options);
  return {parser, [arguments, parser] {
            check_effects(*parser, *arguments);
            return run(*arguments);
          }};
}

}  // namespace raybundle::tools
