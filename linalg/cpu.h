#pragma once

#include <string>
#include <string_view>

/// What the processor can do.
namespace raybundle::linalg {

/// Instruction sets the kernels are compiled for, from the least to the most capable.
/// `avx2` includes FMA; `avx512` is F, CD, BW, DQ and VL.
enum class InstructionSet { baseline, avx2, avx512 };

/// The best set this processor and operating system support.
InstructionSet detected_instruction_set();

/// The set to use, decided once per process: the detected one, lowered (never raised) by the
/// environment variable RAYBUNDLE_ISA=baseline|avx2|avx512. Other values are ignored.
InstructionSet instruction_set();

/// What RAYBUNDLE_ISA says if that is ignored, for a program to complain of; else empty.
std::string ignored_instruction_set();

/// "baseline", "avx2" or "avx512".
std::string_view name(InstructionSet set);

/// Tells the processor that the calling thread is waiting in a loop.
inline void spin_pause() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ __volatile__("yield" ::: "memory");
#endif
}

}  // namespace raybundle::linalg
