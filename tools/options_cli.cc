#include <raybundle/tools/options_cli.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>
#include <optional>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <CLI/Validators.hpp>

#include <raybundle/solver/init/option_table.h>
#include <raybundle/solver/option_table.h>

namespace raybundle::tools {
namespace {

template <class T>
struct ValueOf {
  using Type = T;
};
template <class T>
struct ValueOf<std::optional<T>> {
  using Type = T;
};

template <class T>
std::string text(const T& value) {
  if constexpr (std::is_enum_v<T>) {
    return name(value);
  } else if constexpr (std::is_same_v<T, bool>) {
    return value ? "on" : "off";
  } else {
    std::array<char, 32> buffer;
    return {buffer.data(), std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr};
  }
}
template <class T>
std::string text(const std::optional<T>& value) {
  return value ? text(*value) : "auto";
}

/// What the help page shows as the value: its kind, or all that are legal.
template <class T>
std::string kind() {
  if constexpr (std::is_enum_v<T>) {
    std::string names;
    for (int i = 0; i < enum_count<T>; ++i) {
      names += (i == 0 ? "" : "|") + std::string(name(static_cast<T>(i)));
    }
    return names;
  } else {
    return std::is_integral_v<T> ? "N" : "X";
  }
}

/// The number that `text` is, all of it, within the bounds of the option. `others`: what else is
/// legal, for the complaint.
template <class Number>
Number parse_number(const OptionInfo& info, const std::string& given, const std::string& others) {
  const std::string option = "--" + std::string(info.name);
  const std::string plain = info.bytes ? std::to_string(parse_size(option, given)) : given;
  Number value{};
  const char* end = plain.data() + plain.size();
  const auto [last, error] = std::from_chars(plain.data(), end, value);
  const auto number = static_cast<double>(value);
  const bool legal = error == std::errc() && last == end && !plain.empty() && number >= info.low &&
                     number <= info.high;
  if (legal) return value;
  throw OptionError(option + ": '" + given + "' is not a " +
                    (std::is_integral_v<Number> ? "whole number" : "number") + " from " +
                    text(info.low) + " to " + text(info.high) + others);
}

template <class T>
void assign(T& field, const OptionInfo& info, const std::string& given,
            const std::string& others = "") {
  if constexpr (std::is_enum_v<T>) {
    field = parse_enum<T>(info.name, given, others.empty() ? "" : ", " + others);
  } else {
    field = parse_number<T>(info, given, others.empty() ? "" : ", or " + others);
  }
}
/// What a method may choose by itself can be left to it by name.
template <class T>
void assign(std::optional<T>& field, const OptionInfo& info, const std::string& given) {
  if (given == "auto") return field.reset();
  T value{};
  assign(value, info, given, "auto");
  field = value;
}

/// All options of a table in one group of the help page.
template <class AnyOptions>
void add_options(CLI::App& parser, AnyOptions& options, const std::string& group) {
  visit_options(options, [&](auto& field, const OptionInfo& info) {
    using Field = std::remove_reference_t<decltype(field)>;
    using Value = typename ValueOf<Field>::Type;
    constexpr bool is_optional = !std::is_same_v<Field, Value>;
    const std::string help = std::string(info.help) + " [" + text(field) + "]";
    const std::string flag = "--" + std::string(info.name);
    if constexpr (std::is_same_v<Field, bool>) {
      parser.add_flag(flag, field, help)->group(group);
      return;
    } else {
      parser
          .add_option_function<std::string>(
              flag, [&field, info](const std::string& given) { assign(field, info, given); }, help)
          ->type_name((info.bytes ? "SIZE" : kind<Value>()) + (is_optional ? "|auto" : ""))
          ->group(group);
    }
  });
}

}  // namespace

double parse_size(const std::string& option, const std::string& text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  std::string unit = "1" + text.substr(digits);
  double number = 0;
  const auto [last, error] = std::from_chars(text.data(), text.data() + digits, number);
  try {
    const bool whole = error == std::errc() && last == text.data() + digits;
    if (whole && CLI::AsSizeValue(true)(unit).empty()) return number * std::stod(unit);
  } catch (const CLI::ValidationError&) {
    // said below, with the option's name
  }
  throw OptionError(option + ": '" + text + "' is not a size such as 4GB, 1.5GiB or 500MB");
}

void add_solver_options(CLI::App& parser, Options& options) {
  add_options(parser, options, "Solver options");
}

void add_init_options(CLI::App& parser, init::InitializeOptions& options) {
  add_options(parser, options, "Options of the initialisation");
}

Options parse_solver_options(const std::vector<std::string>& words) {
  CLI::App parser;
  parser.set_help_flag();
  Options options;
  add_solver_options(parser, options);
  try {
    parser.parse(
        std::vector<std::string>(words.rbegin(), words.rend()));  // it wants the last first
  } catch (const CLI::ParseError& error) {
    throw OptionError(error.what());
  }
  return options;
}

std::uint64_t parse_seed(const std::string& option, const std::string& text) {
  std::uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [last, error] = std::from_chars(text.data(), end, seed);
  if (error == std::errc() && last == end && !text.empty()) return seed;
  throw OptionError("--" + option + ": '" + text + "' is not a whole number from 0 to " +
                    std::to_string(std::numeric_limits<std::uint64_t>::max()));
}

std::string has_name(const std::string& name) { return name.empty() ? "the name is empty" : ""; }

}  // namespace raybundle::tools
