#pragma once

#include <optional>
#include <string>

/// Numbers in the text files by which the system tells of itself; empty where there is none.
namespace raybundle::linalg {

/// The one that a file begins with.
std::optional<double> number_in(const std::string& file);

/// The one behind `key`, the first word of its line.
std::optional<double> number_in(const std::string& file, const std::string& key);

}  // namespace raybundle::linalg
