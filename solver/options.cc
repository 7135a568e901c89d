#include <raybundle/solver/options.h>

#include <raybundle/solver/diagonal_matrix.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>

#include <algorithm>
#include <sstream>
#include <type_traits>
#include <utility>

namespace raybundle {
namespace {

template <class T>
void check_range(const T& value, const OptionInfo& info) {
  if constexpr (std::is_arithmetic_v<T>) {
    const auto number = static_cast<double>(value);
    if (number >= info.low && number <= info.high) return;
    std::ostringstream text;
    text << "--" << info.name << ": " << value << " is outside " << info.low << " to " << info.high;
    throw OptionError(text.str());
  } else {
    static_assert(std::is_enum_v<T>);
    if (static_cast<int>(value) >= 0 && static_cast<int>(value) < enum_count<T>) return;
    throw OptionError("--" + std::string(info.name) + ": not a value of the enumeration");
  }
}
template <class T>
void check_range(const std::optional<T>& value, const OptionInfo& info) {
  if (value) check_range(*value, info);
}

[[noreturn]] void no_effect(const std::string& option, const std::string& reason) {
  throw OptionError("--" + option + " has no effect: " + reason);
}

/// Refuses those of the named options that were given.
template <class... Given>
void refuse(const std::string& reason, const Given&... given) {
  const auto check = [&](const auto& option) {
    if (option.second) no_effect(option.first, reason);
  };
  (check(given), ...);
}
template <class T>
std::pair<const char*, bool> given(const char* name, const std::optional<T>& value) {
  return {name, value.has_value()};
}

void refuse_solver_choices(const Options& o, const MethodTraits& method) {
  const std::string who = std::string("method ") + method.name;
  if (method.inner != InnerSolve::pcg) {
    if (!method.bounded) {
      refuse(who + " solves exactly, without a region", given("scaling", o.scaling));
    }
    refuse(who + " has no inner iterations", given("preconditioner", o.preconditioner),
           given("forcing", o.forcing), given("forcing-rule", o.forcing_rule),
           given("max-inner-iterations", o.max_inner_iterations));
    if (o.linear && iterates(*o.linear)) {
      throw OptionError(std::string("--linear ") + name(*o.linear) + ": " + who +
                        " factorises; use tnm");
    }
    return;
  }
  if (o.linear && !iterates(*o.linear)) {
    throw OptionError(std::string("--linear ") + name(*o.linear) + ": " + who +
                      " iterates; use lm-cholesky");
  }
  if (method.adaptive && o.linear == Linear::explicit_pcg) {
    throw OptionError("--linear explicit-pcg: " + who +
                      " may keep the points, whose matrix is too large to form; use dinm");
  }
  const bool schur = o.preconditioner && needs_schur_complement(*o.preconditioner);
  if (schur && o.elimination == Elimination::none) {
    throw OptionError(std::string("--preconditioner ") + name(*o.preconditioner) +
                      ": there is no Schur complement when nothing is eliminated; use diag-b or b");
  }
  const bool clusters =
      o.preconditioner == Preconditioner::two_level || o.preconditioner == Preconditioner::adaptive;
  if (clusters && (method.adaptive || o.elimination == Elimination::cameras)) {
    throw OptionError(
        std::string("--preconditioner ") + name(*o.preconditioner) + ": " +
        (method.adaptive ? who + " eliminates cameras too" : "--elimination cameras leaves none") +
        ", and the clusters are of cameras; use block-diag-s");
  }
  if (method.adaptive && o.elimination) {
    throw OptionError(std::string("--elimination ") + name(*o.elimination) + ": " + who +
                      " chooses the side in every iteration; use dinm");
  }
}

void refuse_globalisation(const Options& o, const MethodTraits& method) {
  const std::string who = std::string("method ") + method.name;
  if (!method.damped) {
    refuse(who + " has no damping", given("damping-matrix", o.damping_matrix),
           given("initial-damping", o.initial_damping), given("min-damping", o.min_damping),
           given("max-damping", o.max_damping));
  }
  if (!method.bounded) {
    refuse(who + " has no trust region", given("initial-radius", o.initial_radius),
           given("min-radius", o.min_radius));
  }
}

void refuse_loss_of_rays(const Options& o) {
  if (o.ray_weight == RayWeight::unit) {
    throw OptionError(
        "--ray-weight unit with a loss: its scale is in pixels, which residuals of rays are by "
        "--ray-weight pixel or focal");
  }
  if (o.loss_scope == LossScope::component) {
    throw OptionError(
        "--loss-scope component with --objective ray: the three components of a ray have no "
        "meaning of their own; use observation");
  }
}

// A spring that damping stretches between a point and where it is holds it, on the eliminated side.
void refuse_points_that_stay(const Options& o, const MethodTraits& method) {
  if (o.point_steps != PointSteps::none) return;
  const std::string who = std::string("--point-steps none: method ") + method.name;
  if (!method.damped) throw OptionError(who + " has no damping to hold points by; use lm-cholesky");
  if (method.adaptive || o.elimination.value_or(Elimination::points) != Elimination::points) {
    throw OptionError(
        "--point-steps none: points that stay must be what is eliminated; use "
        "--elimination points" +
        std::string(method.adaptive ? " and another method than adinm" : ""));
  }
}

void refuse_formulation(const Options& o, const MethodTraits& method) {
  if (o.objective == ObjectiveKind::ray && o.lens == Lens::free) {
    throw OptionError(
        "--lens free: rays are of pixels that were undistorted once, before the solve; use "
        "--objective pixel");
  }
  if (o.objective == ObjectiveKind::pixel) {
    refuse("the objective is of pixels", given("ray-weight", o.ray_weight));
  } else if (o.loss.value_or(method.loss) != Loss::none) {
    refuse_loss_of_rays(o);
  }
  if (!is_anchored(o.points)) return;
  const std::string who = std::string("--points ") + name(o.points);
  const bool damped = o.damping_matrix == DiagonalMatrix::held_h;
  if (damped || o.scaling == DiagonalMatrix::held_h) {
    throw OptionError(std::string(damped ? "--damping-matrix" : "--scaling") +
                      " held-h compares the unknowns of a point, and those of " + who +
                      " have no common unit; use diag-h");
  }
  const char* const reason =
      ": every observation of a point then depends on the point's anchors too, and the cameras' "
      "side of the normal equations is not block diagonal; use --points xyz";
  if (o.elimination == Elimination::cameras) {
    throw OptionError("--elimination cameras with " + who + reason);
  }
  if (method.adaptive) {
    throw OptionError("--method " + std::string(method.name) + " eliminates cameras too, with " +
                      who + reason);
  }
}

// Whether inc weighs the points themselves: eliminated ones have a share in the damping alone, and
// in the region where it bounds their blocks too. `o` is complete.
bool weighs_parallax(const Options& o) {
  const MethodTraits& method = traits(o.method);
  const bool of_kept_side = method.inner == InnerSolve::pcg && method.damped;
  return o.damping_matrix == DiagonalMatrix::inc ||
         (o.scaling == DiagonalMatrix::inc &&
          (!of_kept_side || o.elimination == Elimination::none));
}

void refuse_unused_parameters(const Options& effective, const Options& o) {
  const bool inc =
      effective.scaling == DiagonalMatrix::inc || effective.damping_matrix == DiagonalMatrix::inc;
  if (!inc) {
    refuse("neither scaling nor damping matrix is inc", given("inc-rotation", o.inc.rotation),
           given("inc-translation", o.inc.translation), given("inc-focal", o.inc.focal),
           given("inc-k1", o.inc.k1), given("inc-k2", o.inc.k2), given("inc-point", o.inc.point),
           given("inc-parallax", o.inc.parallax), given("inc-direction", o.inc.direction));
  }
  const std::string who = std::string("--points ") + name(o.points);
  if (is_anchored(o.points)) {
    refuse(who + " has parallaxes and directions", given("inc-point", o.inc.point));
    if (!weighs_parallax(effective)) {
      refuse("the points are eliminated, and only the cameras are weighed by inc",
             given("inc-parallax", o.inc.parallax));
    }
  } else {
    refuse(who + " has coordinates", given("inc-parallax", o.inc.parallax),
           given("inc-direction", o.inc.direction));
  }
  if (effective.lens == Lens::fixed) {
    refuse("the lenses are fixed", given("inc-focal", o.inc.focal), given("inc-k1", o.inc.k1),
           given("inc-k2", o.inc.k2));
  }
  if (effective.loss == Loss::none) {
    refuse("there is no loss", given("loss-scope", o.loss_scope), given("loss-scale", o.loss_scale),
           given("loss-start-scale", o.loss_start_scale));
  }
}

void fill_increments(Options& o) {
  if (o.scaling != DiagonalMatrix::inc && o.damping_matrix != DiagonalMatrix::inc) return;
  const Increments inc = increments(o);
  o.inc = {inc.rotation, inc.translation, inc.focal, inc.k1, inc.k2};
  if (is_anchored(o.points)) {
    if (weighs_parallax(o)) o.inc.parallax = inc.parallax;
    o.inc.direction = inc.direction;
  } else {
    o.inc.point = inc.point;
  }
  if (o.lens == Lens::fixed) o.inc.focal = o.inc.k1 = o.inc.k2 = std::nullopt;
}

void check_order(const Options& effective) {
  const auto ordered = [](const char* low, const char* high, const std::optional<double>& smaller,
                          const std::optional<double>& larger) {
    if (!smaller || !larger || *smaller <= *larger) return;
    throw OptionError(std::string("--") + low + " is larger than --" + high);
  };
  ordered("min-damping", "max-damping", effective.min_damping, effective.max_damping);
  ordered("initial-damping", "max-damping", effective.initial_damping, effective.max_damping);
  ordered("min-damping", "initial-damping", effective.min_damping, effective.initial_damping);
  ordered("min-radius", "initial-radius", effective.min_radius, effective.initial_radius);
  ordered("loss-scale", "loss-start-scale", effective.loss_scale, effective.loss_start_scale);
}

void fill_inner(const MethodTraits& method, Options& o) {
  // Without an elimination the undiminished blocks are the blocks of the system itself.
  Preconditioner preferred = method.preconditioner;
  if (o.elimination == Elimination::none && needs_schur_complement(preferred)) {
    preferred = Preconditioner::b;
  } else if (o.elimination == Elimination::cameras && preferred == Preconditioner::adaptive) {
    preferred = Preconditioner::block_diag_s;  // clusters are of cameras
  }
  o.preconditioner = o.preconditioner.value_or(preferred);
  if (method.inner == InnerSolve::pcg) o.linear = o.linear.value_or(Linear::implicit_pcg);
  o.forcing_rule = o.forcing_rule.value_or(method.forcing_rule);
  o.forcing = o.forcing.value_or(method.forcing);
  o.max_inner_iterations = o.max_inner_iterations.value_or(method.max_inner_iterations);
}

DiagonalMatrix preferred_damping(const MethodTraits& method, PointModel points) {
  const bool in_one_unit = !is_anchored(points);
  if (method.damping_matrix == DiagonalMatrix::held_h && !in_one_unit)
    return DiagonalMatrix::diag_h;
  return method.damping_matrix;
}

void fill_damping(const MethodTraits& method, Options& o) {
  o.damping_matrix = o.damping_matrix.value_or(preferred_damping(method, o.points));
  o.initial_damping = o.initial_damping.value_or(is_of_h(*o.damping_matrix) ? 1e-4 : 1.0);
  o.min_damping = o.min_damping.value_or(std::min(1e-16, *o.initial_damping));
  o.max_damping = o.max_damping.value_or(1e32);
}

void fill_loss(const MethodTraits& method, Options& o) {
  o.loss = o.loss.value_or(method.loss);
  if (*o.loss == Loss::none) return;
  o.loss_scope = o.loss_scope.value_or(LossScope::observation);
  o.loss_scale = o.loss_scale.value_or(default_scale(*o.loss));
}

template <class T>
void forget(std::optional<T>& choice, const T& preferred) {
  if (choice == preferred) choice.reset();
}

// auto stands for one of the damped methods where something is asked for that only one of them has.
Options settle(Options o) {
  if (o.method != Method::automatic) return o;
  const MethodTraits& own = traits(Method::automatic);
  forget(o.preconditioner, own.preconditioner);
  forget(o.forcing_rule, own.forcing_rule);
  forget(o.forcing, own.forcing);
  forget(o.max_inner_iterations, own.max_inner_iterations);
  const bool asks_inner =
      o.scaling || o.preconditioner || o.forcing || o.forcing_rule || o.max_inner_iterations;
  if (asks_inner && o.linear && !iterates(*o.linear)) {
    throw OptionError(std::string("--linear ") + name(*o.linear) +
                      " factorises, and scaling, preconditioner, forcing and their limit are of "
                      "inner iterations: leave out one or the other");
  }
  const bool factorises = (o.linear && !iterates(*o.linear)) || o.elimination == Elimination::none;
  const bool inner =
      asks_inner || (o.linear ? iterates(*o.linear) : o.elimination == Elimination::cameras);
  if (inner) {
    o.method = Method::tnm;
  } else if (factorises) {
    o.method = Method::lm_cholesky;
  }
  o.damping_matrix = o.damping_matrix.value_or(preferred_damping(own, o.points));
  return o;
}

}  // namespace

Options resolve(const Options& options) {
  visit_options(options,
                [](const auto& value, const OptionInfo& info) { check_range(value, info); });
  const Options given = settle(options);
  const MethodTraits& method = traits(given.method);
  refuse_solver_choices(given, method);
  refuse_globalisation(given, method);
  refuse_formulation(given, method);
  refuse_points_that_stay(given, method);

  Options effective = given;
  if (!method.adaptive) effective.elimination = given.elimination.value_or(Elimination::points);
  if (has_inner_iterations(method)) fill_inner(method, effective);
  if (method.inner == InnerSolve::pcg || method.bounded) {
    effective.scaling = given.scaling.value_or(method.scaling);
  }
  if (method.damped) fill_damping(method, effective);
  const bool ray = given.objective == ObjectiveKind::ray;
  effective.lens = given.lens.value_or(ray ? Lens::fixed : Lens::free);
  effective.gauge = given.gauge.value_or(method.gauge);
  effective.point_steps = given.point_steps.value_or(method.point_steps);
  effective.point_start = given.point_start.value_or(PointStart::problem);
  if (given.diagnose) effective.precision = given.precision.value_or(Precision::double_precision);
  if (ray) effective.ray_weight = given.ray_weight.value_or(RayWeight::pixel);
  if (method.bounded) {
    const double first = given.initial_radius.value_or(1);
    effective.min_radius = given.min_radius.value_or(std::min(1e-32, first));
  }
  fill_loss(method, effective);
  refuse_unused_parameters(effective, given);
  fill_increments(effective);
  check_order(effective);
  return effective;
}

Formulation formulation(const Options& options) {
  return {.pose_update = options.pose_update,
          .lens = *options.lens,
          .points = options.points,
          .objective = options.objective,
          .ray_weight = options.ray_weight.value_or(RayWeight::pixel),
          .gauge = *options.gauge};
}

}  // namespace raybundle
