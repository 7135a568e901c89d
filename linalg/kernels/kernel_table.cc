#include <raybundle/linalg/kernels/kernel_table.h>

#include <raybundle/linalg/cpu.h>

#include <stdexcept>
#include <string>

namespace raybundle::linalg {

#define RAYBUNDLE_DECLARE_SHAPE(R, K, E)                     \
  extern const BlockKernels blocks_##R##_##K##_##E;          \
  extern const BlockKernels anchored_##R##_##K##_##E;        \
  extern const EliminationKernels eliminate_##R##_##K##_##E; \
  extern const EliminationKernels eliminate_##R##_##E##_##K; \
  extern const EliminationKernels eliminate_anchored_##R##_##K##_##E;
#define RAYBUNDLE_DECLARE_KERNELS(isa) \
  namespace isa {                      \
  RAYBUNDLE_DECLARE_SHAPE(2, 9, 3)     \
  RAYBUNDLE_DECLARE_SHAPE(2, 6, 3)     \
  RAYBUNDLE_DECLARE_SHAPE(3, 6, 3)     \
  }
RAYBUNDLE_DECLARE_KERNELS(baseline)
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
RAYBUNDLE_DECLARE_KERNELS(avx2)
RAYBUNDLE_DECLARE_KERNELS(avx512)
#endif
#undef RAYBUNDLE_DECLARE_KERNELS
#undef RAYBUNDLE_DECLARE_SHAPE

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

const BlockKernels& block_kernels(bool anchored, int row_size, int hub_size, int leaf_size) {
  const auto is = [&](int row, int hub) {
    return row_size == row && hub_size == hub && leaf_size == 3;
  };
  if (is(2, 9))
    return !anchored ? RAYBUNDLE_CHOOSE(blocks_2_9_3) : RAYBUNDLE_CHOOSE(anchored_2_9_3);
  if (is(2, 6))
    return !anchored ? RAYBUNDLE_CHOOSE(blocks_2_6_3) : RAYBUNDLE_CHOOSE(anchored_2_6_3);
  if (is(3, 6))
    return !anchored ? RAYBUNDLE_CHOOSE(blocks_3_6_3) : RAYBUNDLE_CHOOSE(anchored_3_6_3);
  unknown(row_size, hub_size, leaf_size);
}

const EliminationKernels& elimination_kernels(bool anchored, int row_size, int kept,
                                              int eliminated) {
  const auto is = [&](bool with_anchors, int row, int keep, int eliminate) {
    return anchored == with_anchors && row_size == row && kept == keep && eliminated == eliminate;
  };
  if (is(false, 2, 9, 3)) return RAYBUNDLE_CHOOSE(eliminate_2_9_3);
  if (is(false, 2, 3, 9)) return RAYBUNDLE_CHOOSE(eliminate_2_3_9);
  if (is(false, 2, 6, 3)) return RAYBUNDLE_CHOOSE(eliminate_2_6_3);
  if (is(false, 2, 3, 6)) return RAYBUNDLE_CHOOSE(eliminate_2_3_6);
  if (is(false, 3, 6, 3)) return RAYBUNDLE_CHOOSE(eliminate_3_6_3);
  if (is(false, 3, 3, 6)) return RAYBUNDLE_CHOOSE(eliminate_3_3_6);
  if (is(true, 2, 9, 3)) return RAYBUNDLE_CHOOSE(eliminate_anchored_2_9_3);
  if (is(true, 2, 6, 3)) return RAYBUNDLE_CHOOSE(eliminate_anchored_2_6_3);
  if (is(true, 3, 6, 3)) return RAYBUNDLE_CHOOSE(eliminate_anchored_3_6_3);
  unknown(row_size, kept, eliminated);
}

#undef RAYBUNDLE_CHOOSE

}  // namespace raybundle::linalg
