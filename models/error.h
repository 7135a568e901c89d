#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace raybundle {

/// Input that cannot be used: says where, what was found and what was expected.
/// what() reads "source:line: found ..., expected ..."; the line is left out when it is 0.
class InputError : public std::runtime_error {
 public:
  InputError(std::string source, std::int64_t line, std::string found, std::string expected);

  const std::string& source() const { return source_; }      ///< file name, "-" or "problem"
  std::int64_t line() const { return line_; }                ///< 1-based; 0 when no line applies
  const std::string& found() const { return found_; }        ///< what stood there
  const std::string& expected() const { return expected_; }  ///< what should have stood there

 private:
  std::string source_;
  std::int64_t line_;
  std::string found_;
  std::string expected_;
};

}  // namespace raybundle
