#include <raybundle/linalg/kernels/kernel_table.h>

#include <raybundle/linalg/cpu.h>

#include <stdexcept>
#include <string>

namespace raybundle::linalg {

#define RAYBUNDLE_DECLARE_KERNELS(isa)             \
  namespace isa {                                  \
  extern const BlockKernels blocks_2_9_3;          \
  extern const BlockKernels blocks_2_6_3;          \
  extern const EliminationKernels eliminate_2_9_3; \
  extern const EliminationKernels eliminate_2_3_9; \
  extern const EliminationKernels eliminate_2_6_3; \
  extern const EliminationKernels eliminate_2_3_6; \
  }
RAYBUNDLE_DECLARE_KERNELS(baseline)
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
RAYBUNDLE_DECLARE_KERNELS(avx2)
RAYBUNDLE_DECLARE_KERNELS(avx512)
#endif
#undef RAYBUNDLE_DECLARE_KERNELS

namespace {

// The variant of a kernel set for the instruction set in use.
template <class Kernels>
const Kernels& choose([[maybe_unused]] const Kernels& baseline,
                      [[maybe_unused]] const Kernels& avx2,
                      [[maybe_unused]] const Kernels& avx512) {
  switch (instruction_set()) {
    case InstructionSet::avx512:
      return avx512;
    case InstructionSet::avx2:
      return avx2;
    case InstructionSet::baseline:
      break;
  }
  return baseline;
}

#ifdef RAYBUNDLE_HAVE_X86_KERNELS
#define RAYBUNDLE_CHOOSE(kernels) choose(baseline::kernels, avx2::kernels, avx512::kernels)
#else
#define RAYBUNDLE_CHOOSE(kernels) choose(baseline::kernels, baseline::kernels, baseline::kernels)
#endif

[[noreturn]] void unknown(int row, int a, int b) {
  throw std::invalid_argument("no kernels for blocks of " + std::to_string(a) + " and " +
                              std::to_string(b) + " unknowns with rows of " + std::to_string(row));
}

}  // namespace

const BlockKernels& block_kernels(int row_size, int hub_size, int leaf_size) {
  if (row_size == 2 && leaf_size == 3) {
    if (hub_size == 9) return RAYBUNDLE_CHOOSE(blocks_2_9_3);
    if (hub_size == 6) return RAYBUNDLE_CHOOSE(blocks_2_6_3);
  }
  unknown(row_size, hub_size, leaf_size);
}

const EliminationKernels& elimination_kernels(int row_size, int kept, int eliminated) {
  if (row_size == 2) {
    if (kept == 9 && eliminated == 3) return RAYBUNDLE_CHOOSE(eliminate_2_9_3);
    if (kept == 3 && eliminated == 9) return RAYBUNDLE_CHOOSE(eliminate_2_3_9);
    if (kept == 6 && eliminated == 3) return RAYBUNDLE_CHOOSE(eliminate_2_6_3);
    if (kept == 3 && eliminated == 6) return RAYBUNDLE_CHOOSE(eliminate_2_3_6);
  }
  unknown(row_size, kept, eliminated);
}

#undef RAYBUNDLE_CHOOSE

}  // namespace raybundle::linalg
