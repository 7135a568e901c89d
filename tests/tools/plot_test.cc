// Scripts of plots, and, where gnuplot is there, what it makes of them.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tools/plot.h>

namespace raybundle::tools {
namespace {

using test::read_text;
using test::TemporaryFolder;

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

const std::string awkward = "it's <a> & \"b\"_c^2 \\n 100% ½ {x}";

TEST(Plot, TextIsQuoted) {
  EXPECT_EQ(quoted("it's\nso"), "'it''s so'");
  EXPECT_EQ(quoted(""), "''");
}

TEST(Plot, LongCurvesAreThinned) {
  EXPECT_EQ(thinned(3, 5), (std::vector<std::size_t>{0, 1, 2}));
  EXPECT_TRUE(thinned(0, 5).empty());
  const auto kept = thinned(100'000, 200);
  EXPECT_EQ(kept.front(), 0u);
  EXPECT_EQ(kept.back(), 99'999u);
  EXPECT_LE(kept.size(), 200u);
  EXPECT_GT(kept.size(), 150u);
  for (std::size_t i = 1; i < kept.size(); ++i) EXPECT_GT(kept[i], kept[i - 1]);
}

TEST(Plot, LeavesOutWhatAnAxisCannotShow) {
  LinePlot plot{.log_y = true, .series = {{"a", {0, 1, 2, 3, 4}, {1e3, NAN, 0, -1, 10}}}};
  const std::string script = plot_script("p", plot);
  EXPECT_TRUE(contains(script, "<< END\n0 1000\n4 10\nEND\n")) << script;
  EXPECT_TRUE(contains(script, "set logscale y"));
  plot.series[0].y[4] = 900;  // not worth a logarithm
  EXPECT_FALSE(contains(plot_script("p", plot), "logscale"));
}

TEST(Plot, AnAxisOfOneValueHasALength) {
  LinePlot plot{.log_x = true, .log_y = true, .series = {{"a", {2}, {30}}}};
  std::string script = plot_script("p", plot);
  EXPECT_TRUE(contains(script, "set xrange [1.8:2.2]\nset yrange [27:33]\n")) << script;
  plot = {.series = {{"a", {0, 0}, {100, 100.00000001}}}};  // the same to the script's six digits
  script = plot_script("p", plot);
  EXPECT_TRUE(contains(script, "set xrange [-1:1]\nset yrange [90:110]\n")) << script;
  plot = {.series = {{"a", {0, 1}, {1, 2}}}};
  EXPECT_FALSE(contains(plot_script("p", plot), "range ["));
}

TEST(Plot, ACurveWithoutPointsHasNoEntry) {
  const LinePlot plot{.series = {{"empty", {}, {}}, {"full", {1, 2}, {1, 2}}}};
  const std::string script = plot_script("p", plot);
  EXPECT_FALSE(contains(script, "empty"));
  EXPECT_TRUE(contains(script, "'full'"));
  EXPECT_TRUE(contains(plot_script("p", LinePlot{}), "no data"));
}

TEST(Plot, HistogramCounts) {
  Histogram plot{.bins = 2, .values = {0, 1, 4, 4, 3, NAN, INFINITY}};
  EXPECT_TRUE(contains(plot_script("p", plot), "<< END\n1 2\n3 3\nEND\n"))
      << plot_script("p", plot);
  plot.values = {5, 5};
  EXPECT_TRUE(contains(plot_script("p", plot), "5.5 2\n"));
  plot.values.clear();
  EXPECT_TRUE(contains(plot_script("p", plot), "no data"));
}

TEST(Plot, BarsStandSideBySide) {
  BarPlot plot{.title = awkward,
               .groups = {"a", "b's"},
               .log_y = true,
               .levels = {5},
               .series = {{"one", {2, 0}}, {"two", {4, 8}}}};
  const std::string script = plot_script("p", plot);
  EXPECT_TRUE(contains(script, "$d0 << END\n-0.2 2\nEND\n")) << script;
  EXPECT_TRUE(contains(script, "$d1 << END\n0.2 4\n1.2 8\nEND\n")) << script;
  EXPECT_TRUE(contains(script, "('a' 0, 'b''s' 1)")) << script;
  EXPECT_TRUE(contains(script, "set yrange [1:*]")) << script;
  EXPECT_TRUE(contains(plot_script("p", BarPlot{}), "no data"));
  const TemporaryFolder folder;
  PlotFolder plots(folder.path());
  plots.add("p", plot);
  if (have_gnuplot()) {
    EXPECT_EQ(plots.draw(), "");
  }
}

TEST(Plot, SegmentsAreDifferencesAndSaidToBeThinned) {
  SegmentPlot plot{.title = "t", .most = 2, .segments = {{1, 2, 4, 6}, {0, 0, 1, 1}}};
  EXPECT_TRUE(contains(plot_script("p", plot), "<< END\n1 2 3 4\n0 0 1 1\nEND\n"));
  plot.segments.push_back({9, 9, 9, 9});
  const std::string script = plot_script("p", plot);
  EXPECT_TRUE(contains(script, "one of 2 shown"));
  EXPECT_FALSE(contains(script, "\n0 0 1 1\n"));
  EXPECT_TRUE(contains(script, "\n9 9 0 0\n"));
}

TEST(Plot, GnuplotDrawsThemAll) {
  if (!have_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const TemporaryFolder folder;
  const auto draw = [&] {
    PlotFolder plots(folder / "plots");
    Series curve{.name = awkward, .x = {}, .y = {}};
    for (int i = 0; i < 5000; ++i) {
      curve.x.push_back(i);
      curve.y.push_back(std::exp(-i / 100.0));
    }
    LinePlot line{
        .title = awkward, .x_label = "x", .y_label = awkward, .log_y = true, .series = {}};
    line.series.assign(12, curve);  // more than colours
    plots.add("line", line);
    plots.add("steps", LinePlot{.steps = true, .series = {{"s", {1, 2}, {0.5, 1}, true}}});
    plots.add("one", LinePlot{.series = {{"s", {0}, {-5}}}});
    plots.add("flat", LinePlot{.log_y = true, .series = {{"s", {1, 1}, {2, 2.00000001}}}});
    plots.add("nothing", LinePlot{.log_x = true, .log_y = true});
    plots.add("histogram", Histogram{.title = awkward, .log_y = true, .values = {1, 2, 2, 3}});
    plots.add("segments", SegmentPlot{.title = awkward, .segments = {{1, 2, 3, 4}}});
    return plots.draw();
  };
  EXPECT_EQ(draw(), "");
  const std::string line = read_text(folder / "plots/line.svg");
  EXPECT_TRUE(contains(line, "it's &lt;a> &amp; ")) << "not escaped";
  EXPECT_TRUE(contains(line, "_c^2 \\n 100% ½ {x}")) << "taken for markup";
  EXPECT_LT(line.size(), 100'000u);
  for (const char* name : {"line", "steps", "nothing", "histogram", "segments"}) {
    EXPECT_TRUE(contains(read_text(folder / ("plots/" + std::string(name) + ".svg")), "</svg>"));
  }
  EXPECT_EQ(draw(), "");
  EXPECT_EQ(read_text(folder / "plots/line.svg"), line) << "not the same picture again";
}

TEST(Plot, WhatGnuplotComplainsAboutIsTold) {
  if (!have_gnuplot()) GTEST_SKIP() << "gnuplot is not installed";
  const TemporaryFolder folder;
  PlotFolder plots(folder / "plots");
  plots.add("p", LinePlot{});
  test::write_text(folder / "plots/p.gp", "no such command\n");
  EXPECT_TRUE(contains(plots.draw(), "invalid command"));
}

}  // namespace
}  // namespace raybundle::tools
