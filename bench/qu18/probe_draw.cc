#include <cmath>
#include <stdexcept>

#include <raybundle/bench/qu18/probe.h>
#include <raybundle/tools/plot.h>

namespace raybundle::bench {
namespace {

std::vector<double> numbers(const Json& list) {
  std::vector<double> values;
  for (const Json& each : list) values.push_back(each.is_null() ? NAN : each.get<double>());
  return values;
}

tools::LinePlot lines(const Json& plot) {
  tools::LinePlot result{.title = plot.at("title"),
                         .x_label = plot.at("x_label"),
                         .y_label = plot.at("y_label"),
                         .log_x = plot.value("log_x", false),
                         .log_y = plot.value("log_y", false)};
  for (const Json& each : plot.at("series")) {
    result.series.push_back({.name = each.at("name"),
                             .x = numbers(each.at("x")),
                             .y = numbers(each.at("y")),
                             .dashed = each.value("dashed", false)});
  }
  return result;
}

tools::SegmentPlot segments(const Json& plot) {
  tools::SegmentPlot result{
      .title = plot.at("title"), .x_label = plot.at("x_label"), .y_label = plot.at("y_label")};
  for (const Json& each : plot.at("segments")) {
    result.segments.push_back({each.at(0), each.at(1), each.at(2), each.at(3)});
  }
  return result;
}

tools::BarPlot bars(const Json& plot) {
  tools::BarPlot result{.title = plot.at("title"),
                        .y_label = plot.at("y_label"),
                        .groups = plot.at("groups"),
                        .log_y = plot.value("log_y", false)};
  if (plot.contains("levels")) result.levels = numbers(plot["levels"]);
  for (const Json& each : plot.at("series")) {
    result.series.push_back({.name = each.at("name"), .y = numbers(each.at("y"))});
  }
  return result;
}

}  // namespace

std::string draw(const Json& specification, const std::filesystem::path& folder) {
  tools::PlotFolder plots(folder);
  for (const Json& plot : specification) {
    const std::string kind = plot.at("kind");
    if (kind == "lines") {
      plots.add(plot.at("name"), lines(plot));
    } else if (kind == "bars") {
      plots.add(plot.at("name"), bars(plot));
    } else if (kind == "segments") {
      plots.add(plot.at("name"), segments(plot));
    } else {
      throw std::invalid_argument("no kind of plot: " + kind);
    }
  }
  return plots.draw();
}

}  // namespace raybundle::bench
