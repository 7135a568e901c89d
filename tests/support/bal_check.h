#pragma once

#include <bit>
#include <cstdint>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>

namespace raybundle::test {

inline bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::bit_cast<std::uint64_t>(a[i]) != std::bit_cast<std::uint64_t>(b[i])) return false;
  }
  return true;
}

inline bool same_bits(const Problem& a, const Problem& b) {
  return same_bits(a.cameras, b.cameras) && same_bits(a.points, b.points) &&
         same_bits(a.observations, b.observations) &&
         a.observation_camera == b.observation_camera && a.observation_point == b.observation_point;
}

inline std::string bal_text(const Problem& problem) {
  std::ostringstream out;
  io::write_bal(problem, out);
  return out.str();
}

/// The problem that `text` was read into, valid and surviving writing; or nothing where it was
/// refused, by an InputError that says all it has to. Anything else throws std::logic_error.
inline std::optional<Problem> read_or_refuse(const std::string& text) {
  Problem problem;
  try {
    problem = io::parse_bal(text, "text");
  } catch (const InputError& error) {
    const bool complete = error.source() == "text" && error.line() >= 1 && !error.found().empty() &&
                          !error.expected().empty();
    if (!complete) throw std::logic_error(std::string("incomplete error: ") + error.what());
    return std::nullopt;
  }
  try {
    validate(problem);
  } catch (const InputError& error) {
    throw std::logic_error(std::string("was read, but is not valid: ") + error.what());
  }
  if (!same_bits(problem, io::parse_bal(bal_text(problem), "written"))) {
    throw std::logic_error("changed by writing and reading");
  }
  return problem;
}

}  // namespace raybundle::test
