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
#define RAYBUNDLE_DECLARE_KERNELS(number) \
  namespace number {                      \
  RAYBUNDLE_DECLARE_SHAPE(2, 9, 3)        \
  RAYBUNDLE_DECLARE_SHAPE(2, 6, 3)        \
  RAYBUNDLE_DECLARE_SHAPE(3, 6, 3)        \
  }
#define RAYBUNDLE_DECLARE_SET(isa)   \
  namespace isa {                    \
  RAYBUNDLE_DECLARE_KERNELS(singles) \
  RAYBUNDLE_DECLARE_KERNELS(doubles) \
  }
RAYBUNDLE_DECLARE_SET(baseline)
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
RAYBUNDLE_DECLARE_SET(avx2)
RAYBUNDLE_DECLARE_SET(avx512)
#endif
#undef RAYBUNDLE_DECLARE_SET
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
#define RAYBUNDLE_CHOOSE_SET(kernels) choose(baseline::kernels, avx2::kernels, avx512::kernels)
#else
#define RAYBUNDLE_CHOOSE_SET(kernels) \
  choose(baseline::kernels, baseline::kernels, baseline::kernels)
#endif
#define RAYBUNDLE_CHOOSE(kernels)                                                          \
  (shape.precision == Precision::single_precision ? RAYBUNDLE_CHOOSE_SET(singles::kernels) \
                                                  : RAYBUNDLE_CHOOSE_SET(doubles::kernels))

bool is(const KernelShape& shape, int row, int hub) {
  return shape.row == row && shape.hub == hub && shape.leaf == 3;
}

[[noreturn]] void unknown(const KernelShape& shape) {
  throw std::invalid_argument("no kernels for blocks of " + std::to_string(shape.hub) + " and " +
                              std::to_string(shape.leaf) + " unknowns with rows of " +
                              std::to_string(shape.row) +
                              (shape.anchored ? ", or none that eliminate anchors" : ""));
}

}  // namespace

const BlockKernels& block_kernels(const KernelShape& shape) {
  if (shape.anchored) {
    if (is(shape, 2, 9)) return RAYBUNDLE_CHOOSE(anchored_2_9_3);
    if (is(shape, 2, 6)) return RAYBUNDLE_CHOOSE(anchored_2_6_3);
    if (is(shape, 3, 6)) return RAYBUNDLE_CHOOSE(anchored_3_6_3);
  } else {
    if (is(shape, 2, 9)) return RAYBUNDLE_CHOOSE(blocks_2_9_3);
    if (is(shape, 2, 6)) return RAYBUNDLE_CHOOSE(blocks_2_6_3);
    if (is(shape, 3, 6)) return RAYBUNDLE_CHOOSE(blocks_3_6_3);
  }
  unknown(shape);
}

const EliminationKernels& elimination_kernels(const KernelShape& shape, bool eliminate_leaves) {
  if (shape.anchored && eliminate_leaves) {
    if (is(shape, 2, 9)) return RAYBUNDLE_CHOOSE(eliminate_anchored_2_9_3);
    if (is(shape, 2, 6)) return RAYBUNDLE_CHOOSE(eliminate_anchored_2_6_3);
    if (is(shape, 3, 6)) return RAYBUNDLE_CHOOSE(eliminate_anchored_3_6_3);
  } else if (!shape.anchored && eliminate_leaves) {
    if (is(shape, 2, 9)) return RAYBUNDLE_CHOOSE(eliminate_2_9_3);
    if (is(shape, 2, 6)) return RAYBUNDLE_CHOOSE(eliminate_2_6_3);
    if (is(shape, 3, 6)) return RAYBUNDLE_CHOOSE(eliminate_3_6_3);
  } else if (!shape.anchored) {
    if (is(shape, 2, 9)) return RAYBUNDLE_CHOOSE(eliminate_2_3_9);
    if (is(shape, 2, 6)) return RAYBUNDLE_CHOOSE(eliminate_2_3_6);
    if (is(shape, 3, 6)) return RAYBUNDLE_CHOOSE(eliminate_3_3_6);
  }
  unknown(shape);
}

#undef RAYBUNDLE_CHOOSE
#undef RAYBUNDLE_CHOOSE_SET

}  // namespace raybundle::linalg
