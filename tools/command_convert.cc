// raybundle convert: a problem from one format into another.

#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/models/rays.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

enum class Format { bal, parallaxba };

struct Arguments {
  std::string input;
  std::string output;
  std::optional<Format> to;
  bool undistort = false;
};

Format parse_format(const std::string& text) {
  if (text == "bal") return Format::bal;
  if (text == "parallaxba") return Format::parallaxba;
  throw OptionError("--to: '" + text + "' is none of bal, parallaxba");
}

Format output_format(const Arguments& arguments) {
  if (arguments.to) return *arguments.to;
  return names_folder(arguments.output) ? Format::parallaxba : Format::bal;
}

/// Whatever can be refused before the input is read.
void check(const Arguments& arguments) {
  if (arguments.undistort && io::is_parallaxba(arguments.input)) {
    throw OptionError("--undistort has no effect: ParallaxBA's format knows no distortion");
  }
  if (output_format(arguments) == Format::bal) {
    if (names_folder(arguments.output)) {
      throw OptionError("OUTPUT: " + arguments.output + " is a folder; BAL is one file");
    }
    return check_result("OUTPUT", arguments.output, arguments.input);
  }
  if (arguments.output == "-") {
    throw OptionError("OUTPUT: ParallaxBA's format is a folder, which standard output is not");
  }
  check_folder("OUTPUT", arguments.output, arguments.input);
}

Problem converted(const Arguments& arguments, Format format) {
  Problem problem = read_input(arguments.input);
  const bool one_lens = format == Format::parallaxba;
  if (arguments.undistort) {
    naming("problem", arguments.input, [&] {
      problem = undistorted(std::move(problem));
      if (one_lens) problem = with_one_focal_length(std::move(problem));
    });
  }
  if (!one_lens) return problem;
  const std::string breach = io::lens_breach(problem);
  if (breach.empty()) return problem;
  throw InputError(arguments.input, 0, breach,
                   "the same f > 0 everywhere and no distortion, as ParallaxBA's format has one K "
                   "for all cameras" +
                       std::string(arguments.undistort ? "" : "; see --undistort"));
}

/// A line on what the format has no place for; empty where all is there.
std::string what_is_lost(const Problem& problem, Format format) {
  if (format == Format::parallaxba) return without_points + std::string("\n");
  return problem.aspect == 1 ? "" : square_pixels + std::string("\n");
}

ExitCode run(const Arguments& arguments) {
  check(arguments);
  const Format format = output_format(arguments);
  const Problem problem = converted(arguments, format);
  if (format == Format::parallaxba) {
    io::write_parallaxba(problem, arguments.output);
  } else {
    io::write_bal(problem, std::filesystem::path(output_path(arguments.output)));
  }
  const std::string counts = count_text(problem.camera_count(), "camera") + ", " +
                             count_text(problem.point_count(), "point") + ", " +
                             count_text(problem.observation_count(), "observation");
  std::fputs((counts + "\n" + what_is_lost(problem, format)).c_str(), stderr);
  return ExitCode::usable;
}

}  // namespace

Command add_convert(CLI::App& program) {
  CLI::App* parser = program.add_subcommand(
      "convert", "Write a problem in another format: BAL, or a folder as ParallaxBA has it");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("INPUT", arguments->input, input_help)->type_name("")->required();
  parser
      ->add_option("OUTPUT", arguments->output,
                   "A BAL file, with points (those of a folder from its rays); - is\n"
                   "standard output. Or a folder, which has no points: a new one, or\n"
                   "one that holds no problem yet")
      ->type_name("")
      ->required()
      ->check(has_name, "");
  parser
      ->add_option_function<std::string>(
          "--to", [arguments](const std::string& text) { arguments->to = parse_format(text); },
          "Format [parallaxba if OUTPUT is a folder or ends in /, else bal]")
      ->type_name("bal|parallaxba");
  parser->add_flag("--undistort", arguments->undistort,
                   "Observe what lenses without distortion would: observations are\n"
                   "moved, k1 and k2 become 0. For ParallaxBA all cameras then get one\n"
                   "f too, the median: pixels, and with them residuals, are scaled,\n"
                   "which changes the weights of cameras to one another [off]");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
