// raybundle info: the shape of a problem, what solving it would take, and advice.

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <nlohmann/json.hpp>

#include <raybundle/linalg/memory.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/memory_estimate.h>
#include <raybundle/tools/output.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

struct Info {
  std::string source;
  StructureStatistics structure;
  ReprojectionStatistics reprojection;
  MemoryEstimates memory;
  std::vector<std::string> warnings;
  std::vector<std::string> advice;
};

/// Which method, judged by memory.
std::string method_advice(const MemoryEstimates& memory) {
  const double available = linalg::available_memory();
  const auto fits = [&](const MemoryEstimate& estimate) {
    return estimate.bytes < 0.8 * available;
  };
  const auto best = [&](Method method) {
    MemoryEstimate found = memory.methods.front();
    found.bytes = std::numeric_limits<double>::infinity();
    for (const MemoryEstimate& each : memory.methods) {
      const bool counts = each.method == method && each.elimination == Elimination::points;
      if (counts && each.bytes < found.bytes) found = each;
    }
    return found;
  };
  const MemoryEstimate direct = best(Method::lm_cholesky);
  const MemoryEstimate iterative = best(Method::tnm);
  const std::string machine = bytes_text(available) + " that are available";
  if (fits(direct)) {
    const std::string order = std::to_string(memory.reduced.order);
    constexpr std::int64_t large = 20'000;
    if (memory.reduced.order <= large) {
      return "The default, --method auto, may choose: the linear system has order " + order +
             ", and factorising it (lm-cholesky) fits and takes about " + bytes_text(direct.bytes) +
             ".";
    }
    return "--method lm-cholesky fits into memory (about " + bytes_text(direct.bytes) +
           "), but a linear system of order " + order +
           " takes long to factor: the default, --method auto, may rather iterate (tnm), which "
           "takes about " +
           bytes_text(iterative.bytes) + ".";
  }
  if (fits(iterative)) {
    return "--method lm-cholesky would take " + bytes_text(direct.bytes) + ", too much for the " +
           machine + ": --method tnm iterates and takes about " + bytes_text(iterative.bytes) + ".";
  }
  return "No method fits into the " + machine + "; the least is " + bytes_text(iterative.bytes) +
         " with --method tnm.";
}

/// How to describe points whose depth is hardly determined.
std::string parallax_advice(const StructureStatistics& s) {
  std::string text = percent_text(s.low_parallax_points, s.points) +
                     " of the points have less than 1 degree of parallax";
  if (s.collinear_points > 0) {
    text += ", " + percent_text(s.collinear_points, s.points) +
            " lie along the motion of their observers";
  }
  return text +
         ": their depth is hardly determined, and coordinates converge slowly. Angles describe "
         "them better: --points pmba, with lenses you trust also --objective ray --method dogleg.";
}

std::vector<std::string> advice(const Info& info) {
  const StructureStatistics& s = info.structure;
  std::vector<std::string> result = {method_advice(info.memory)};
  constexpr double notable = 0.05;
  const auto is_notable = [&](std::int64_t points) {
    return static_cast<double>(points) > notable * static_cast<double>(s.points);
  };
  if (is_notable(s.low_parallax_points) || is_notable(s.collinear_points)) {
    result.push_back(parallax_advice(s));
  }
  constexpr std::int64_t determined = 5;  // of two numbers each, for nine parameters
  if (s.fewest_observations < determined && s.cameras > s.unobserved_cameras) {
    result.push_back("A camera has only " + std::to_string(s.fewest_observations) +
                     " observations, too few for its nine parameters; --lens fixed needs less.");
  }
  if (info.reprojection.behind_camera > 0) {
    result.push_back(std::to_string(info.reprojection.behind_camera) +
                     " observations are of points behind their camera: the start is poor there, "
                     "and a solve may leave such points on the wrong side. By parallax (--points "
                     "pmba) they may be beyond infinity, and often come to a lower cost.");
  }
  return result;
}

Info inspect(const std::string& input) {
  const Problem problem = read_input(input);
  Info info;
  info.source = input;
  info.structure = structure_statistics(problem);
  info.reprojection = reprojection_statistics(problem);
  // The lens of a folder is known.
  info.memory = estimate_memory(problem, io::is_parallaxba(input) ? Lens::fixed : Lens::free);
  info.warnings = warnings(info.structure);
  info.advice = advice(info);
  return info;
}

const char* in_words(Bound bound) {
  return bound == Bound::none ? "" : bound == Bound::at_most ? "at most " : "at least ";
}

std::string count(std::int64_t value) { return std::to_string(value); }

std::string info_text(const Info& info) {
  const StructureStatistics& s = info.structure;
  const double observed = static_cast<double>(s.cameras - s.unobserved_cameras);
  const double mean = observed > 0 ? static_cast<double>(s.observations) / observed : 0;
  const std::int64_t all_pairs = s.cameras * (s.cameras - 1) / 2;

  Table table;
  table.add("cameras", count(s.cameras));
  table.add("points", count(s.points));
  table.add("observations", count(s.observations));
  table.add("unknowns", count(9 * s.cameras + 3 * s.points));
  table.add("track length", format("mean %.2f, longest %s observations of a point",
                                   s.mean_track_length, count(s.longest_track).c_str()));
  table.add("per camera",
            format("fewest %s, mean %.1f, most %s observations",
                   count(s.fewest_observations).c_str(), mean, count(s.most_observations).c_str()));
  table.add("connectivity",
            format("%s connected %s, the largest of %s cameras", count(s.components).c_str(),
                   s.components == 1 ? "set" : "sets", count(s.largest_component).c_str()));
  table.add("camera pairs", count(s.camera_pairs) + " share points (" +
                                percent_text(s.camera_pairs, all_pairs) + ")");
  table.add("low parallax", count(s.low_parallax_points) + " points below 1 degree (" +
                                percent_text(s.low_parallax_points, s.points) + ")");
  table.add("collinear", count(s.collinear_points) + " points along their observers' motion (" +
                             percent_text(s.collinear_points, s.points) + ")");
  table.add("cost", format("%.6e", info.reprojection.cost));
  table.add("RMSE", format("%.6g px", info.reprojection.rmse));
  table.add("behind cameras", count(info.reprojection.behind_camera) + " observations");
  std::string text = info.source + "\n" + table.text();

  text += "\nmemory estimates (available: " + bytes_text(linalg::available_memory()) + ")\n";
  for (const MemoryEstimate& each : info.memory.methods) {
    text += format("  %-12s %-5s eliminating %-8s %-16s %s%s", name(each.method), name(each.points),
                   each.elimination ? name(*each.elimination) : "either", name(each.linear),
                   in_words(each.bound), bytes_text(each.bytes).c_str());
    if (each.bytes_of_two_levels) {
      text += ", " + bytes_text(*each.bytes_of_two_levels) + " with two levels";
    }
    text += "\n";
  }
  if (!info.warnings.empty()) text += "\nwarnings\n";
  for (const std::string& each : info.warnings) text += "  " + each + "\n";
  text += "\nadvice\n";
  for (const std::string& each : info.advice) text += "  " + each + "\n";
  return text;
}

double share(std::int64_t part, std::int64_t whole) {
  return static_cast<double>(part) / static_cast<double>(whole);
}

std::string info_json(const Info& info) {
  using Json = nlohmann::ordered_json;
  const StructureStatistics& s = info.structure;
  Json memory = Json::array();
  for (const MemoryEstimate& each : info.memory.methods) {
    memory.push_back({{"method", name(each.method)},
                      {"points", name(each.points)},
                      {"elimination", each.elimination ? Json(name(*each.elimination)) : Json()},
                      {"linear", name(each.linear)},
                      {"bytes", each.bytes},
                      {"upper_bound", each.bound == Bound::at_most},
                      {"lower_bound", each.bound == Bound::at_least},
                      {"bytes_of_two_levels",
                       each.bytes_of_two_levels ? Json(*each.bytes_of_two_levels) : Json()}});
  }
  const Json json = {{"source", info.source},
                     {"cameras", s.cameras},
                     {"points", s.points},
                     {"observations", s.observations},
                     {"unobserved_cameras", s.unobserved_cameras},
                     {"unobserved_points", s.unobserved_points},
                     {"points_seen_once", s.points_seen_once},
                     {"duplicate_observations", s.duplicate_observations},
                     {"mean_track_length", s.mean_track_length},
                     {"longest_track", s.longest_track},
                     {"fewest_observations", s.fewest_observations},
                     {"most_observations", s.most_observations},
                     {"components", s.components},
                     {"largest_component", s.largest_component},
                     {"camera_pairs", s.camera_pairs},
                     {"low_parallax_points", s.low_parallax_points},
                     {"low_parallax_share", share(s.low_parallax_points, s.points)},
                     {"collinear_points", s.collinear_points},
                     {"collinear_share", share(s.collinear_points, s.points)},
                     {"cost", info.reprojection.cost},
                     {"rmse", info.reprojection.rmse},
                     {"behind_cameras", info.reprojection.behind_camera},
                     {"memory", std::move(memory)},
                     {"warnings", info.warnings},
                     {"advice", info.advice}};
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

struct Arguments {
  std::string input;
  bool json = false;
};

ExitCode run(const Arguments& arguments) {
  const Info info = inspect(arguments.input);
  print(arguments.json ? info_json(info) : info_text(info));
  return ExitCode::usable;
}

}  // namespace

Command add_info(CLI::App& program) {
  CLI::App* parser =
      program.add_subcommand("info", "Sizes, structure, memory estimates and advice");
  auto arguments = std::make_shared<Arguments>();
  parser->add_option("INPUT", arguments->input, input_help)->type_name("")->required();
  parser->add_flag("--json", arguments->json, "Print JSON [off]");
  return {parser, [arguments] { return run(*arguments); }};
}

}  // namespace raybundle::tools
