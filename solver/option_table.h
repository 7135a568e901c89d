#pragma once

#include <raybundle/solver/options.h>

#include <limits>
#include <stdexcept>

namespace raybundle {

/// An option that is unknown, out of range, or without effect on the chosen method.
class OptionError : public std::invalid_argument {
 public:
  using std::invalid_argument::invalid_argument;
};

/// What the command line, the log and the documentation know of an option.
struct OptionInfo {
  const char* name;  ///< as on the command line, without the dashes
  const char* help;  ///< one line
  double low = -std::numeric_limits<double>::infinity();  ///< smallest legal value (numbers only)
  double high = std::numeric_limits<double>::infinity();  ///< largest legal value (numbers only)
  bool bytes = false;  ///< a size, which may be written with a unit
};

/// The one table of options: calls visit(field, info) for each, in the order of the help page.
/// A field is an enumeration, a bool, an int, a double, or an optional of one of these.
template <class AnyOptions, class Visit>
void visit_options(AnyOptions& o, Visit&& visit) {
  constexpr double inf = std::numeric_limits<double>::infinity();
  visit(o.method, OptionInfo{"method", "optimisation method"});
  visit(o.elimination,
        OptionInfo{"elimination",
                   "side eliminated before the inner solve; auto: points, adinm: by condition"});
  visit(o.linear, OptionInfo{"linear", "solver of the (reduced) linear system; auto: by work"});
  visit(o.preconditioner, OptionInfo{"preconditioner",
                                     "preconditioner of the inner iterations; auto: adaptive for "
                                     "auto and tnm, else block-diag-s; with elimination none b, "
                                     "with cameras block-diag-s"});
  visit(o.damping_matrix, OptionInfo{"damping-matrix",
                                     "matrix that the damping multiplies; auto: held-h for "
                                     "auto, or diag-h with anchored points; diag-h for "
                                     "lm-cholesky and tnm, else identity"});
  visit(o.scaling, OptionInfo{"scaling",
                              "scaling of the unknowns in the linear system and of the trust "
                              "region; auto: inc for inm, dinm, adinm, irls, else identity"});
  visit(o.pose_update, OptionInfo{"pose-update", "how a pose takes a step"});
  visit(o.lens, OptionInfo{"lens",
                           "whether f, k1, k2 are unknowns; auto: free, of rays or a "
                           "ParallaxBA folder fixed"});
  visit(o.points, OptionInfo{"points", "how points are described"});
  visit(o.point_start,
        OptionInfo{"point-start",
                   "where points start: as given, or from two of their rays; auto: problem, of a "
                   "ParallaxBA folder rays"});
  visit(o.point_steps, OptionInfo{"point-steps",
                                  "which points take their part of a step: all, those whose own "
                                  "cost it does not raise, or none; auto: all, dogleg: better"});
  visit(o.objective, OptionInfo{"objective", "what a residual compares"});
  visit(o.ray_weight, OptionInfo{"ray-weight", "weight of a ray's residual; auto: pixel"});
  visit(
      o.gauge,
      OptionInfo{"gauge", "whether the first pose and the scale stay; auto: free, dogleg: fixed"});
  visit(o.loss, OptionInfo{"loss", "robust loss; auto: none, irls: tukey"});
  visit(o.loss_scope,
        OptionInfo{"loss-scope", "what the loss is of, |r| or each component; auto: observation"});
  visit(o.loss_scale,
        OptionInfo{"loss-scale",
                   "scale of the loss, pixels; auto: 3 for geman-mcclure and truncated, "
                   "6 for tukey, else 1",
                   1e-100, 1e100});
  visit(o.loss_start_scale, OptionInfo{"loss-start-scale",
                                       "wider scale to start with, halved down to --loss-scale; "
                                       "auto: none, irls: from the start's residuals",
                                       1e-100, 1e100});
  visit(o.max_iterations,
        OptionInfo{"max-iterations", "most iterations, rejected ones included", 0, 1e9});
  visit(o.time_limit, OptionInfo{"time-limit", "stop after this many seconds", 0, inf});
  visit(o.function_tolerance,
        OptionInfo{"function-tolerance", "stop when |cost change| <= this * cost", 0, 1});
  visit(
      o.gradient_tolerance,
      OptionInfo{"gradient-tolerance", "stop when the largest gradient entry is <= this", 0, inf});
  visit(o.parameter_tolerance,
        OptionInfo{"parameter-tolerance",
                   "stop when each block's step is <= this * (its norm + this)", 0, 1});
  visit(o.max_consecutive_failures,
        OptionInfo{"max-consecutive-failures", "stop after this many rejected steps in a row", 1,
                   1e9});
  visit(
      o.initial_damping,
      OptionInfo{"initial-damping",
                 "damping mu at the start; auto: 1e-4 with damping matrix diag-h or held-h, else 1",
                 0, 1e32});
  visit(o.min_damping,
        OptionInfo{"min-damping", "mu never falls below this; auto: 1e-16", 0, 1e32});
  visit(o.max_damping,
        OptionInfo{"max-damping", "stop when mu would rise above this; auto: 1e32", 0, inf});
  visit(
      o.initial_radius,
      OptionInfo{"initial-radius",
                 "trust-region radius at the start; auto: length of the first step", 1e-100, inf});
  visit(
      o.min_radius,
      OptionInfo{"min-radius", "stop when the radius would fall below this; auto: 1e-32", 0, inf});
  visit(o.max_inner_iterations,
        OptionInfo{"max-inner-iterations", "most PCG iterations per linear solve; auto: 1000", 1,
                   1e9});
  visit(o.forcing_rule,
        OptionInfo{"forcing-rule", "what ends the inner iterations; auto: nash-sofer"});
  visit(o.forcing, OptionInfo{"forcing", "t of the forcing rule; auto: 0.1", 0, 0.99});
  visit(o.precision,
        OptionInfo{"precision",
                   "of the stored rows of the Jacobian; auto: single, and double where model and "
                   "cost disagree"});
  visit(o.inc.rotation,
        OptionInfo{"inc-rotation",
                   "increment of rotations, radians; auto: 1e-9, with anchored points 1e-8", 1e-100,
                   1e100});
  visit(o.inc.translation,
        OptionInfo{"inc-translation",
                   "increment of translations; auto: 1e-9, with anchored points 1e-8", 1e-100,
                   1e100});
  visit(o.inc.focal,
        OptionInfo{"inc-focal", "increment of focal lengths, pixels; auto: 1e-6", 1e-100, 1e100});
  visit(o.inc.k1, OptionInfo{"inc-k1", "increment of k1; auto: 1e-9", 1e-100, 1e100});
  visit(o.inc.k2, OptionInfo{"inc-k2", "increment of k2; auto: 1e-9", 1e-100, 1e100});
  visit(o.inc.point,
        OptionInfo{"inc-point", "increment of coordinates of points; auto: 1e-9", 1e-100, 1e100});
  visit(o.inc.parallax, OptionInfo{"inc-parallax",
                                   "increment of parallaxes, radians, or inverse distances of "
                                   "anchored points; auto: 1e-9, of pmba 1e-8",
                                   1e-100, 1e100});
  visit(
      o.inc.direction,
      OptionInfo{"inc-direction", "increment of directions of anchored points, radians; auto: 1e-9",
                 1e-100, 1e100});
  visit(o.memory_limit,
        OptionInfo{.name = "memory-limit",
                   .help = "most memory of the process, such as 4GB or 500MB: what would take "
                           "more is refused",
                   .low = 0,
                   .bytes = true});
  visit(o.diagnose,
        OptionInfo{"diagnose", "log eigenvalues of points and reduced system after each step"});
  visit(o.threads, OptionInfo{"threads", "worker threads; 0 means all cores", 0, 1024});
}

/// The value called `text`; throws OptionError that lists the legal names.
template <class Enum>
Enum parse_enum(const std::string& option, const std::string& text, const std::string& others = "");

/// All values of an enumeration in order, for help pages and tests.
template <class Enum>
constexpr int enum_count = 0;
template <>
inline constexpr int enum_count<Method> = 8;
template <>
inline constexpr int enum_count<Elimination> = 3;
template <>
inline constexpr int enum_count<Linear> = 5;
template <>
inline constexpr int enum_count<Preconditioner> = 7;
template <>
inline constexpr int enum_count<DiagonalMatrix> = 4;
template <>
inline constexpr int enum_count<ForcingRule> = 4;
template <>
inline constexpr int enum_count<Loss> = 7;
template <>
inline constexpr int enum_count<LossScope> = 2;
template <>
inline constexpr int enum_count<PoseUpdate> = 3;
template <>
inline constexpr int enum_count<Lens> = 2;
template <>
inline constexpr int enum_count<PointModel> = 4;
template <>
inline constexpr int enum_count<PointStart> = 2;
template <>
inline constexpr int enum_count<PointSteps> = 3;
template <>
inline constexpr int enum_count<ObjectiveKind> = 2;
template <>
inline constexpr int enum_count<RayWeight> = 3;
template <>
inline constexpr int enum_count<Gauge> = 2;
template <>
inline constexpr int enum_count<Precision> = 2;

template <class Enum>
Enum parse_enum(const std::string& option, const std::string& text, const std::string& others) {
  std::string legal;
  for (int i = 0; i < enum_count<Enum>; ++i) {
    const auto value = static_cast<Enum>(i);
    if (text == name(value)) return value;
    legal += (i == 0 ? "" : ", ") + std::string(name(value));
  }
  throw OptionError("--" + option + ": '" + text + "' is none of " + legal + others);
}

}  // namespace raybundle
