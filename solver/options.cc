#include <raybundle/solver/options.h>

#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>

#include <array>
#include <sstream>
#include <type_traits>

namespace raybundle {
namespace {

template <std::size_t Count, class Enum>
const char* pick(const std::array<const char*, Count>& names, Enum value) {
  return names[static_cast<std::size_t>(value)];
}

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

void refuse_ineffective(const Options& options, InnerSolve inner) {
  const std::string method = std::string("method ") + name(options.method);
  if (inner == InnerSolve::cholesky) {
    const std::string reason = method + " has no inner iterations";
    if (options.preconditioner) no_effect("preconditioner", reason);
    if (options.forcing) no_effect("forcing", reason);
    if (options.max_inner_iterations) no_effect("max-inner-iterations", reason);
    if (options.linear == Linear::implicit_pcg) {
      throw OptionError("--linear implicit-pcg: " + method + " factorises; use tnm");
    }
    return;
  }
  if (options.linear && *options.linear != Linear::implicit_pcg) {
    throw OptionError(std::string("--linear ") + name(*options.linear) + ": " + method +
                      " iterates; use lm-cholesky");
  }
  const bool schur = options.preconditioner == Preconditioner::diag_s ||
                     options.preconditioner == Preconditioner::block_diag_s;
  if (schur && options.elimination == Elimination::none) {
    throw OptionError(std::string("--preconditioner ") + name(*options.preconditioner) +
                      ": there is no Schur complement when nothing is eliminated; use diag-b or b");
  }
}

}  // namespace

const char* name(Method value) { return traits(value).name; }
const char* name(Elimination value) { return pick(std::array{"none", "points", "cameras"}, value); }
const char* name(Linear value) {
  return pick(std::array{"dense-cholesky", "sparse-cholesky", "implicit-pcg"}, value);
}
const char* name(Preconditioner value) {
  return pick(std::array{"identity", "diag-b", "b", "diag-s", "block-diag-s"}, value);
}
const char* name(DiagonalMatrix value) { return pick(std::array{"identity", "diag-h"}, value); }
const char* name(PoseUpdate value) { return pick(std::array{"global", "local", "se3"}, value); }
const char* name(Lens value) { return pick(std::array{"free", "fixed"}, value); }

Options resolve(const Options& options) {
  visit_options(options,
                [](const auto& value, const OptionInfo& info) { check_range(value, info); });
  if (options.min_damping > options.max_damping) {
    throw OptionError("--min-damping is larger than --max-damping");
  }
  if (options.initial_damping > options.max_damping) {
    throw OptionError("--initial-damping is larger than --max-damping");
  }
  const MethodTraits& method = traits(options.method);
  refuse_ineffective(options, method.inner);

  Options effective = options;
  effective.elimination = options.elimination.value_or(method.elimination);
  effective.damping_matrix = options.damping_matrix.value_or(method.damping_matrix);
  effective.scaling = options.scaling.value_or(method.scaling);
  if (method.inner == InnerSolve::pcg) {
    // Without an elimination the undiminished blocks are the blocks of the system itself.
    const bool nothing = *effective.elimination == Elimination::none;
    effective.preconditioner =
        options.preconditioner.value_or(nothing ? Preconditioner::b : method.preconditioner);
    effective.linear = Linear::implicit_pcg;
    effective.forcing = options.forcing.value_or(method.forcing);
    effective.max_inner_iterations =
        options.max_inner_iterations.value_or(method.max_inner_iterations);
  }
  return effective;
}

}  // namespace raybundle
