#pragma once

#include <filesystem>
#include <string>
#include <vector>

/// Plots for reports: scripts of gnuplot with their data inside, and the SVG that gnuplot makes of
/// them. One look and one palette, which people who confuse colours can tell apart.
namespace raybundle::tools {

/// A curve. Whatever an axis cannot show (not finite, not positive on a logarithmic one) is left
/// out. Long curves are thinned to what a plot can resolve.
struct Series {
  std::string name = {};
  std::vector<double> x = {};
  std::vector<double> y = {};  ///< as many as x
  bool dashed = false;
};

struct LinePlot {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  bool log_x = false;
  bool log_y = false;
  bool steps = false;  ///< the value holds until the next one, as in a distribution
  std::vector<Series> series = {};
};

/// How often values fall into `bins` intervals of the same width between the least and the largest.
struct Histogram {
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  int bins = 50;
  bool log_y = false;
  std::vector<double> values = {};
};

/// Short lines from (x0, y0) to (x1, y1), such as reprojection errors in an image; both axes have
/// the same scale. The start of each is marked.
struct SegmentPlot {
  struct Segment {
    double x0, y0, x1, y1;
  };
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  std::size_t most = 2000;  ///< of more, every n-th is shown, and the title says so
  std::vector<Segment> segments = {};
};

/// Groups of bars side by side, one bar of each series in each. A value that the axis cannot show
/// has none.
struct BarPlot {
  struct Bars {
    std::string name = {};
    std::vector<double> y = {};  ///< as many as groups
  };
  std::string title = {};
  std::string x_label = {};
  std::string y_label = {};
  std::vector<std::string> groups = {};
  bool log_y = false;
  std::vector<double> levels = {};  ///< lines across
  std::vector<Bars> series = {};
};

/// The script of a plot; running it writes `name`.svg into the working folder. Pure functions.
std::string plot_script(const std::string& name, const LinePlot& plot);
std::string plot_script(const std::string& name, const Histogram& plot);
std::string plot_script(const std::string& name, const SegmentPlot& plot);
std::string plot_script(const std::string& name, const BarPlot& plot);

/// Text as a string of gnuplot.
std::string quoted(const std::string& text);
/// At most about `most` of the indices 0 ... count - 1, both ends included, the early ones (where
/// curves bend) more densely.
std::vector<std::size_t> thinned(std::size_t count, std::size_t most);

/// Collects plots of one folder.
class PlotFolder {
 public:
  /// Creates the folder where it does not exist. Throws std::system_error.
  explicit PlotFolder(std::filesystem::path folder);

  /// Writes `name`.gp. `name`: without folder and ending.
  template <class Plot>
  void add(const std::string& name, const Plot& plot) {
    write(name, plot_script(name, plot));
  }
  /// Runs gnuplot on all that was added. An empty string when every SVG was made, else what is the
  /// matter: gnuplot is not installed, or what it complained about.
  std::string draw() const;

 private:
  void write(const std::string& name, const std::string& script);

  std::filesystem::path folder_;
  std::vector<std::string> names_;
};

/// Whether gnuplot can be run.
bool have_gnuplot();

}  // namespace raybundle::tools
