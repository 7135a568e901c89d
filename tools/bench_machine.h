#pragma once

#include <cstdint>
#include <string>

/// On what a benchmark ran.
namespace raybundle::tools {

struct Machine {
  std::string processor;        ///< as the system calls it
  int cores = 0;                ///< that this process may use
  std::int64_t memory = 0;      ///< bytes
  std::string instruction_set;  ///< of our kernels
  std::string blas;
  std::string system;  ///< distribution and kernel
  std::string build;   ///< of this program
  std::string version;
};

Machine this_machine();

std::string to_json(const Machine& machine);
/// Throws InputError naming `source` when the text is something else.
Machine machine_from_json(const std::string& text, const std::string& source);

}  // namespace raybundle::tools
