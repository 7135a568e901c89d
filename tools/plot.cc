#include <raybundle/tools/plot.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string_view>
#include <system_error>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/tools/bench_process.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

constexpr std::size_t most_points = 250;  // of one curve

// Okabe and Ito's colours, without yellow, which vanishes on white. Beyond them the dash differs.
constexpr std::string_view palette[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                        "#56b4e9", "#e69f00", "#000000"};
constexpr int colours = static_cast<int>(std::size(palette));

/// What all plots begin with. `noenhanced`: underscores in names mean themselves.
std::string head(const std::string& name, const auto& plot) {
  return "# gnuplot " + name + ".gp writes " + name +
         ".svg\n"
         "reset session\n"
         "set encoding utf8\n"
         "set terminal svg size 720,450 font 'sans-serif,12' linewidth 1 noenhanced background "
         "'#ffffff'\n"
         "set output " +
         quoted(name + ".svg") + "\nset title " + quoted(plot.title) + "\nset xlabel " +
         quoted(plot.x_label) + "\nset ylabel " + quoted(plot.y_label) +
         "\n"
         "set border 3 linewidth 0.6 linecolor '#666666'\n"
         "set tics nomirror out scale 0.6\n"
         "set grid linewidth 0.4 linecolor '#dddddd'\n";
}

struct Range {
  double low = INFINITY, high = -INFINITY;
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// Below a decade a logarithmic axis has hardly a tic and shows no more than a linear one.
bool worth_log(const Range& range) { return range.high >= 10 * range.low; }

/// gnuplot complains about an axis of no length. The scripts' numbers have six digits.
std::string range_of_one_value(const char* axis, const Range& range) {
  const double size = std::max(std::abs(range.low), std::abs(range.high));
  if (range.high - range.low > 1e-5 * size) return "";
  const double margin = size > 0 ? 0.1 * size : 1;
  return format("set %srange [%.6g:%.6g]\n", axis, range.low - margin, range.high + margin);
}

bool can_show(double value, bool log) { return std::isfinite(value) && (!log || value > 0); }

struct Curve {
  const Series* series;
  std::vector<double> x, y;
};

Curve shown(const Series& series, const LinePlot& plot) {
  Curve all{&series, {}, {}};
  const std::size_t count = std::min(series.x.size(), series.y.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (!can_show(series.x[i], plot.log_x) || !can_show(series.y[i], plot.log_y)) continue;
    all.x.push_back(series.x[i]);
    all.y.push_back(series.y[i]);
  }
  Curve curve{&series, {}, {}};
  for (const std::size_t i : thinned(all.x.size(), most_points)) {
    curve.x.push_back(all.x[i]);
    curve.y.push_back(all.y[i]);
  }
  return curve;
}

/// One data block, and the command that draws it, per curve.
std::string curves_text(const LinePlot& plot, const std::vector<Curve>& curves) {
  std::string data, commands;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    const int number = static_cast<int>(c);
    data += format("$d%d << END\n", number);
    for (std::size_t i = 0; i < curves[c].x.size(); ++i) {
      data += format("%.6g %.6g\n", curves[c].x[i], curves[c].y[i]);
    }
    data += "END\n";
    const int turn = number / colours;
    const int dash = curves[c].series->dashed ? 2 + turn : 1 + (turn > 0 ? 2 + turn : 0);
    commands += (c == 0 ? "plot " : ", \\\n     ") + format("$d%d with ", number) +
                (plot.steps ? "steps" : "lines") +
                format(" linewidth 1.6 dashtype %d linecolor '%s' title ", dash,
                       palette[number % colours].data()) +
                quoted(curves[c].series->name);
  }
  return data + commands + "\n";
}

std::string nothing_to_show() {
  return "set xrange [0:1]\nset yrange [0:1]\nset label 'no data' at 0.5,0.5 center\n"
         "plot 2 notitle\n";
}

}  // namespace

std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result + "'";
}

std::vector<std::size_t> thinned(std::size_t count, std::size_t most) {
  std::vector<std::size_t> kept;
  if (count <= most || most < 2) {
    for (std::size_t i = 0; i < count; ++i) kept.push_back(i);
    return kept;
  }
  for (std::size_t k = 0; k < most; ++k) {
    // Half linear, half quadratic: the steps grow along the curve.
    const double t = static_cast<double>(k) / static_cast<double>(most - 1);
    const double at = 0.5 * (t + t * t) * static_cast<double>(count - 1);
    const auto index = static_cast<std::size_t>(std::lround(at));
    if (kept.empty() || index > kept.back()) kept.push_back(index);
  }
  return kept;
}

std::string plot_script(const std::string& name, const LinePlot& plot) {
  std::vector<Curve> curves;
  Range x, y;
  for (const Series& series : plot.series) {
    Curve curve = shown(series, plot);
    if (curve.x.empty()) continue;
    for (const double value : curve.x) x.include(value);
    for (const double value : curve.y) y.include(value);
    curves.push_back(std::move(curve));
  }
  std::string text = head(name, plot);
  if (curves.empty()) return text + nothing_to_show();
  if (plot.log_x && worth_log(x)) text += "set logscale x\n";
  if (plot.log_y && worth_log(y)) text += "set logscale y\n";
  text +=
      "set format '%g'\nset autoscale xfix\n"
      "set key outside right top vertical Left reverse samplen 2\n";
  text += range_of_one_value("x", x);
  text += plot.steps ? "set yrange [0:1.02]\n" : range_of_one_value("y", y);
  return text + curves_text(plot, curves);
}

std::string plot_script(const std::string& name, const Histogram& plot) {
  std::string text = head(name, plot);
  Range range;
  for (const double value : plot.values) {
    if (std::isfinite(value)) range.include(value);
  }
  if (!(range.low <= range.high) || plot.bins < 1) {
    return text + nothing_to_show();
  }
  const double span = range.high - range.low;
  const double width = span > 0 ? span / plot.bins : 1;
  std::vector<long long> counts(static_cast<std::size_t>(plot.bins), 0);
  for (const double value : plot.values) {
    if (!std::isfinite(value)) continue;
    const auto bin = static_cast<std::size_t>((value - range.low) / width);
    ++counts[std::min(bin, counts.size() - 1)];
  }
  text += format("set boxwidth %.6g absolute\nset style fill solid 0.7 noborder\n", width);
  text += plot.log_y ? "set logscale y\nset yrange [0.5:*]\n" : "set yrange [0:*]\n";
  text += "$d0 << END\n";
  for (std::size_t bin = 0; bin < counts.size(); ++bin) {
    if (counts[bin] == 0) continue;
    text +=
        format("%.6g %lld\n", range.low + (static_cast<double>(bin) + 0.5) * width, counts[bin]);
  }
  return text + format("END\nplot $d0 with boxes linecolor '%s' notitle\n", palette[0].data());
}

std::string plot_script(const std::string& name, const SegmentPlot& plot) {
  const std::size_t stride =
      plot.most == 0 ? 1
                     : (plot.segments.size() + plot.most - 1) / std::max<std::size_t>(plot.most, 1);
  SegmentPlot titled = plot;
  titled.segments.clear();
  if (stride > 1) titled.title += format(" (one of %zu shown)", stride);
  std::string text = head(name, titled) + "set size ratio -1\n";
  std::string data;
  for (std::size_t i = 0; i < plot.segments.size(); i += std::max<std::size_t>(stride, 1)) {
    const auto& s = plot.segments[i];
    const bool finite =
        std::isfinite(s.x0) && std::isfinite(s.y0) && std::isfinite(s.x1) && std::isfinite(s.y1);
    if (!finite) continue;
    data += format("%.6g %.6g %.6g %.6g\n", s.x0, s.y0, s.x1 - s.x0, s.y1 - s.y0);
  }
  if (data.empty()) return text + nothing_to_show();
  return text + "$d0 << END\n" + data +
         format(
             "END\nplot $d0 using 1:2:3:4 with vectors nohead linewidth 0.8 linecolor '%s' "
             "notitle, \\\n     $d0 using 1:2 with dots linecolor '%s' notitle\n",
             palette[1].data(), palette[0].data());
}

std::string plot_script(const std::string& name, const BarPlot& plot) {
  constexpr double width = 0.8;  // of a group
  std::string text = head(name, plot), data, commands;
  Range range;
  const double bars = static_cast<double>(plot.series.size());
  for (std::size_t s = 0; s < plot.series.size(); ++s) {
    const int number = static_cast<int>(s);
    const auto& y = plot.series[s].y;
    data += format("$d%d << END\n", number);
    for (std::size_t i = 0; i < std::min(y.size(), plot.groups.size()); ++i) {
      if (!can_show(y[i], plot.log_y)) continue;
      range.include(y[i]);
      const double offset = (static_cast<double>(s) + 0.5) / bars - 0.5;
      data += format("%.6g %.6g\n", static_cast<double>(i) + width * offset, y[i]);
    }
    data += "END\n";
    commands +=
        (s == 0 ? "plot " : ", \\\n     ") +
        format("$d%d with boxes linecolor '%s' title ", number, palette[number % colours].data()) +
        quoted(plot.series[s].name);
  }
  if (!(range.low <= range.high)) return text + nothing_to_show();
  for (const double level : plot.levels) {
    if (can_show(level, plot.log_y)) range.include(level);
    commands += format(", \\\n     %.6g with lines dashtype 2 linecolor '#666666' notitle", level);
  }
  std::string tics;
  for (std::size_t i = 0; i < plot.groups.size(); ++i) {
    tics += (i == 0 ? "" : ", ") + quoted(plot.groups[i]) + format(" %zu", i);
  }
  text += format("set boxwidth %.6g absolute\nset style fill solid 0.8 noborder\n", width / bars);
  text += plot.log_y ? format("set logscale y\nset yrange [%.6g:*]\n", range.low / 2)
                     : "set yrange [0:*]\n";
  text += format("set xrange [-0.6:%.6g]\n", static_cast<double>(plot.groups.size()) - 0.4) +
          "set xtics rotate by 35 right (" + tics +
          ")\nset key outside top horizontal Left reverse samplen 2\n";
  return text + data + commands + "\n";
}

bool have_gnuplot() { return !find_program("gnuplot").empty(); }

PlotFolder::PlotFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  std::filesystem::create_directories(folder_);
}

void PlotFolder::write(const std::string& name, const std::string& script) {
  io::write_file_atomically(folder_ / (name + ".gp"), script);
  names_.push_back(name);
}

std::string PlotFolder::draw() const {
  if (names_.empty()) return "";
  const std::filesystem::path gnuplot = find_program("gnuplot");
  if (gnuplot.empty()) {
    return "gnuplot is not installed (on Debian: gnuplot-nox); the plots are in " +
           folder_.string() + " as scripts for it";
  }
  ProcessRequest request{.command = {gnuplot.string()}, .folder = folder_};
  for (const std::string& name : names_) request.command.push_back(name + ".gp");
  const ProcessResult result = run_process(request);
  if (result.code == 0 && result.output.empty()) return "";
  return "gnuplot, in " + folder_.string() + ": " +
         (result.output.empty() ? describe(result) : result.output);
}

}  // namespace raybundle::tools
