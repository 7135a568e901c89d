#include <raybundle/models/increments.h>

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/models/error.h>
#include <raybundle/models/objective.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace raybundle {
namespace {

using linalg::index;

struct Slice {
  const char* name;
  int first, size;  // among the nine parameters of a camera, or the three of a point
  double Increments::*increment;
};
constexpr std::array<Slice, parameter_kinds> slices = {
    {{"rotation", 0, 3, &Increments::rotation},
     {"translation", 3, 3, &Increments::translation},
     {"focal", 6, 1, &Increments::focal},
     {"k1", 7, 1, &Increments::k1},
     {"k2", 8, 1, &Increments::k2},
     {"point", 0, 3, &Increments::point},
     {"parallax", 0, 1, &Increments::parallax},
     {"direction", 1, 2, &Increments::direction}}};
constexpr int smallest_decade = -12;

double squares(const std::vector<double>& x) {
  double sum = 0;
  for (const double value : x) sum += value * value;
  return sum;
}

bool is_of_camera(std::size_t kind) {
  return static_cast<ParameterKind>(kind) < ParameterKind::point;
}

// Moves one argument of every camera, or of every point, at once: a residual depends on a single
// point and, but for anchored points, on a single camera, so that one evaluation gives a whole
// column of derivatives; of anchored points, their sum over the row's cameras.
class Differences {
 public:
  Differences(const Problem& problem, PointModel points, linalg::ThreadPool& pool)
      : pool_(pool),
        anchored_(is_anchored(points)),
        problem_(without_masks(problem)),
        objective_(problem_, {.pose_update = PoseUpdate::global, .points = points}, pool),
        state_(objective_.state_of(problem)),
        moved_(state_),
        J_(objective_.layout()),
        unused_(objective_.layout()),
        normal_(objective_.layout()),
        residual_(index(objective_.layout().residuals())),
        other_(residual_.size()),
        direction_(index(objective_.layout().unknowns())) {
    objective_.linearize(state_, J_, normal_, residual_.data());
  }

  // Squared norms of the error of one column, and of the analytic column itself.
  struct Column {
    double error, norm;
  };
  Column compare(linalg::Side side, int argument, double step) {
    const linalg::BlockLayout& layout = objective_.layout();
    std::fill(direction_.begin(), direction_.end(), 0.0);
    for (std::int64_t b = 0; b < layout.block_count(side); ++b) {
      const bool other_way = anchored_ && side == linalg::Side::hubs && b % 2 == 1;
      direction_[index(layout.offset(side) + b * layout.block_size(side) + argument)] =
          other_way ? -step : step;
    }
    objective_.retract(state_, direction_.data(), moved_);
    objective_.linearize(moved_, unused_, normal_, other_.data());
    std::vector<double> analytic(residual_.size());
    multiply(J_, direction_.data(), analytic.data(), pool_);
    for (std::size_t i = 0; i < other_.size(); ++i) {
      analytic[i] /= step;
      other_[i] = (other_[i] - residual_[i]) / step - analytic[i];
    }
    return {squares(other_), squares(analytic)};
  }

 private:
  // What is fixed has no derivative to compare.
  static Problem without_masks(Problem problem) {
    problem.fixed_camera_parameters.clear();
    problem.fixed_points.clear();
    return problem;
  }

  linalg::ThreadPool& pool_;
  bool anchored_;
  Problem problem_;
  Objective objective_;
  State state_, moved_;
  linalg::BlockJacobian J_, unused_;
  linalg::NormalEquations normal_;
  std::vector<double> residual_, other_, direction_;
};

double relative_error(Differences& differences, const Slice& slice, linalg::Side side,
                      double step) {
  double error = 0, norm = 0;
  for (int k = slice.first; k < slice.first + slice.size; ++k) {
    const Differences::Column column = differences.compare(side, k, step);
    error += column.error;
    norm += column.norm;
  }
  const double ratio = std::sqrt(error / norm);
  return std::isfinite(ratio) ? ratio : std::numeric_limits<double>::infinity();
}

double least_error(const std::vector<IncrementTrial>& trials) {
  double least = std::numeric_limits<double>::infinity();
  for (const IncrementTrial& trial : trials) least = std::min(least, trial.error);
  return least;
}

}  // namespace

const char* name(ParameterKind kind) { return slices[static_cast<std::size_t>(kind)].name; }

double increment(const Increments& increments, ParameterKind kind) {
  return increments.*slices[static_cast<std::size_t>(kind)].increment;
}

Increments shipped_increments(PointModel points) {
  Increments shipped = {.focal = 1e-6, .k1 = 1e-9, .k2 = 1e-9};
  if (is_anchored(points)) {
    shipped.rotation = shipped.translation = 1e-8;
    shipped.parallax = points == PointModel::pmba ? 1e-8 : 1e-9;
    shipped.direction = 1e-9;
  } else {
    shipped.rotation = shipped.translation = shipped.point = 1e-9;
  }
  return shipped;
}

bool has_kind(PointModel model, ParameterKind kind) {
  if (kind < ParameterKind::point) return true;
  return is_anchored(model) != (kind == ParameterKind::point);
}

IncrementSearch search_increments(const Problem& problem, PointModel points,
                                  linalg::ThreadPool& pool) {
  Differences differences(problem, points, pool);
  IncrementSearch search;
  for (std::size_t kind = 0; kind < slices.size(); ++kind) {
    if (!has_kind(points, static_cast<ParameterKind>(kind))) continue;
    const linalg::Side side = is_of_camera(kind) ? linalg::Side::hubs : linalg::Side::leaves;
    for (int decade = 0; decade >= smallest_decade; --decade) {
      const double step = std::pow(10.0, decade);
      const double error = relative_error(differences, slices[kind], side, step);
      search.trials[kind].push_back({step, error});
    }
    search.attainable = std::max(search.attainable, least_error(search.trials[kind]));
  }
  if (!std::isfinite(search.attainable)) {
    throw InputError("problem", 0, "derivatives that are not finite",
                     "points off the cameras' planes and parameters that act on some pixel");
  }
  for (std::size_t kind = 0; kind < slices.size(); ++kind) {
    for (const IncrementTrial& trial : search.trials[kind]) {
      if (trial.error <= search.attainable) search.found.*slices[kind].increment = trial.step;
    }
  }
  return search;
}

}  // namespace raybundle
