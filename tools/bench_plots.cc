#include <raybundle/tools/bench_plots.h>

#include <algorithm>
#include <cmath>

#include <raybundle/tools/plot.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

/// One curve per variant on a problem; `x` and `y` of an Iterate. `compared`: only costs that
/// compare with the best.
template <class X, class Y>
std::vector<Series> curves(const BenchPlan& plan, const std::vector<MedianResult>& medians,
                           std::size_t problem, bool compared, X x, Y y) {
  std::vector<Series> all;
  for (const MedianResult& each : medians) {
    if (each.problem != problem || each.middle == nullptr) continue;
    if (compared && !each.compared) continue;
    const BenchVariant& variant = plan.variants[each.variant];
    Series series{
        .name = variant.name, .x = {}, .y = {}, .dashed = variant.solver == BenchSolver::ceres};
    for (const Iterate& iterate : each.middle->trace) {
      series.x.push_back(x(iterate));
      series.y.push_back(y(iterate));
    }
    all.push_back(std::move(series));
  }
  return all;
}

void add_problem(const BenchPlan& plan, const BenchResults& results,
                 const std::vector<MedianResult>& medians, std::size_t p, PlotFolder& folder) {
  const double best = results.best[p];
  const auto seconds = [](const Iterate& i) { return i.seconds; };
  const auto iteration = [](const Iterate& i) { return static_cast<double>(i.iteration); };
  const auto cost = [](const Iterate& i) { return i.cost; };
  const auto gradient = [](const Iterate& i) { return i.gradient_norm; };
  const auto excess = [best](const Iterate& i) { return i.cost / best - 1; };
  const auto add = [&](const std::string& what, const char* label, bool over_time, const auto& y) {
    const bool compared = what == "excess";
    LinePlot plot{.title = plan.problems[p].name,
                  .x_label = over_time ? "time in seconds" : "iteration",
                  .y_label = label,
                  .log_x = over_time,
                  .log_y = true,
                  .steps = false,
                  .series = over_time ? curves(plan, medians, p, compared, seconds, y)
                                      : curves(plan, medians, p, compared, iteration, y)};
    folder.add(plan.problems[p].name + "_" + what + (over_time ? "_time" : "_iterations"), plot);
  };
  for (const bool over_time : {true, false}) {
    add("cost", "cost", over_time, cost);
    add("excess", "cost / best cost - 1", over_time, excess);
    add("gradient", "gradient norm", over_time, gradient);
  }
}

void add_profile(const BenchPlan& plan, const std::vector<MedianResult>& medians, std::size_t which,
                 PlotFolder& folder) {
  const std::vector<Profile> all = profiles(plan, medians, which);
  double last = 10;  // where the axis ends: all curves are level from there on
  for (const Profile& profile : all) last = std::max(last, 1.5 * profile.ratio.back());
  LinePlot plot{.title = format("Solved to within tau = %.0e of the best", accuracies[which]),
                .x_label = "time relative to the fastest",
                .y_label = "share of problems",
                .log_x = true,
                .log_y = false,
                .steps = true,
                .series = {}};
  for (std::size_t v = 0; v < all.size(); ++v) {
    Series series{.name = plan.variants[v].name,
                  .x = all[v].ratio,
                  .y = all[v].share,
                  .dashed = plan.variants[v].solver == BenchSolver::ceres};
    series.x.push_back(last);
    series.y.push_back(all[v].share.back());
    plot.series.push_back(std::move(series));
  }
  folder.add(format("profile_%.0e", accuracies[which]), plot);
}

}  // namespace

std::string write_plots(const BenchPlan& plan, const BenchResults& results) {
  const std::vector<MedianResult> all = medians(plan, results);
  PlotFolder folder(plan.folder / "plots");
  for (std::size_t p = 0; p < plan.problems.size(); ++p) {
    add_problem(plan, results, all, p, folder);
  }
  for (std::size_t i = 0; i < accuracies.size(); ++i) add_profile(plan, all, i, folder);
  return folder.draw();
}

}  // namespace raybundle::tools
