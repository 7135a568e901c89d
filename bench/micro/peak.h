#pragma once

#include <cstdint>

#include <raybundle/linalg/cpu.h>

/// Multiplications and additions from registers, as many as a core can do: what no kernel exceeds.
namespace raybundle::bench {

/// The loop of one instruction set.
struct PeakLoop {
  double flops;                        ///< per round
  double (*run)(std::int64_t rounds);  ///< returns something that depends on all of them
};

/// That of the set the program has chosen.
PeakLoop peak_loop(linalg::InstructionSet set = linalg::instruction_set());

}  // namespace raybundle::bench
