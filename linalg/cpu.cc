#include <raybundle/linalg/cpu.h>

#include <algorithm>
#include <cstdlib>
#include <optional>

namespace raybundle::linalg {
namespace {

/// Of RAYBUNDLE_ISA; empty where it is not set.
std::string wish() {
  const char* const value = std::getenv("RAYBUNDLE_ISA");
  return value == nullptr ? "" : value;
}

std::optional<InstructionSet> called(const std::string& text) {
  for (const auto set : {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
    if (name(set) == text) return set;
  }
  return std::nullopt;
}

InstructionSet choose() {
  const InstructionSet detected = detected_instruction_set();
  return std::min(called(wish()).value_or(detected), detected);
}

}  // namespace

InstructionSet detected_instruction_set() {
#if defined(__x86_64__) || defined(__i386__)
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512cd") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512vl");
  if (avx2 && avx512) return InstructionSet::avx512;
  if (avx2) return InstructionSet::avx2;
#endif
  return InstructionSet::baseline;
}

InstructionSet instruction_set() {
  static const InstructionSet chosen = choose();
  return chosen;
}

std::string ignored_instruction_set() { return called(wish()) ? "" : wish(); }

std::string_view name(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return "avx512";
    case InstructionSet::avx2:
      return "avx2";
    case InstructionSet::baseline:
      break;
  }
  return "baseline";
}

}  // namespace raybundle::linalg
