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
#include <raybundle/tools/commands.h>
#include <raybundle/tools/init_report.h>
#include <raybundle/tools/input.h>
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

void check_least(const char* option, double value, double least) {
  if (value >= least) return;
  throw OptionError(std::string(option) + ": " + format("%g", value) + " is less than " +
                    format("%g", least));
}

void check(const Arguments& arguments) {
  check_least("--min-common", static_cast<double>(arguments.options.pairs.min_common), 6);
  check_least("--pairs-per-camera", static_cast<double>(arguments.options.pairs.most_per_image), 1);
  check_least("--threshold", arguments.options.relative_pose.threshold, 1e-6);
  check_least("--threads", arguments.options.threads, 0);
  if (names_folder(arguments.output)) {
    throw OptionError("--output: the folder " + arguments.output +
                      " would hold no points; name a file");
  }
  const bool both = !arguments.output.empty() && !arguments.log.empty();
  if (both && same_file(arguments.output, arguments.log)) {
    throw OptionError("--output and --log are the same: " + arguments.log);
  }
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
  StageLine line;
  const auto progress = [&](const char* stage, std::int64_t done, std::int64_t all) {
    if (!arguments.quiet) line.show(stage, done, all);
  };
  return naming("problem", arguments.input, [&] {
    if (arguments.incremental) {
      const init::IncrementalOptions options = {.pairs = arguments.options.pairs,
                                                .relative_pose = arguments.options.relative_pose,
                                                .seed = arguments.options.seed,
                                                .threads = arguments.options.threads};
      record.incremental = init::reconstruct_incrementally(problem, options, progress);
      return init::placed_part(problem, *record.incremental);
    }
    record.global = init::initialize(problem, arguments.options, progress);
    return init::placed_part(problem, *record.global);
  });
}

void write_result(const Arguments& arguments, const Problem& placed, InitRecord& record) {
  io::write_bal(placed, std::filesystem::path(output_path(arguments.output)),
                arguments.options.threads);
  record.output = arguments.output == "-" ? "standard output" : arguments.output;
  if (placed.aspect != 1) std::fprintf(stderr, "warning: %s\n", square_pixels);
}

ExitCode run(const Arguments& arguments) {
  check(arguments);
  InitRecord record;
  const auto start = std::chrono::steady_clock::now();
  Problem problem = read_input(arguments.input, arguments.options.threads);
  record.read_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  record.source = arguments.input;
  record.cameras = problem.camera_count();
  record.points = problem.point_count();
  record.observations = problem.observation_count();
  record.seed = arguments.options.seed;
  record.threads =
      arguments.options.threads > 0 ? arguments.options.threads : linalg::available_threads();
  const Problem placed = place(arguments, problem, record).problem;
  if (!arguments.output.empty()) write_result(arguments, placed, record);
  if (!arguments.log.empty()) {
    record.log = arguments.log == "-" ? "standard output" : arguments.log;
    io::write_file_atomically(output_path(arguments.log), init_json(record));
  }
  const bool taken = arguments.output == "-" || arguments.log == "-";
  const std::string report = init_report(record);
  if (taken) {
    std::fputs(report.c_str(), stderr);
  } else {
    print(report);
  }
  return ExitCode::usable;
}

}  // namespace

Command add_init(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "init", "Find poses and points from observations and lenses alone, to be solved then");
  auto arguments = std::make_shared<Arguments>();
  init::InitializeOptions& options = arguments->options;
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
      ->add_option("--min-common", options.pairs.min_common,
                   "Fewest points that a pair of images has in common, from 6 [20]")
      ->type_name("N");
  parser
      ->add_option("--pairs-per-camera", options.pairs.most_per_image,
                   "Most pairs that an image asks for, those with most points in common [40]")
      ->type_name("N");
  parser
      ->add_option("--threshold", options.relative_pose.threshold,
                   "Largest epipolar error of a point that fits a pair, pixels [4]")
      ->type_name("X");
  parser
      ->add_option_function<std::string>(
          "--seed",
          [arguments](const std::string& text) {
            arguments->options.seed = parse_seed("--seed", text);
          },
          "Of the samples: the same seed gives the same result [1]")
      ->type_name("N");
  parser->add_option("--threads", options.threads, "0: all cores [0]")->type_name("N");
  parser->add_flag("-q,--quiet", arguments->quiet, "No progress on standard error [off]");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
