// The block kernels for one instruction set and one precision (RAYBUNDLE_NUMBER in a namespace
// RAYBUNDLE_PRECISION), for the shapes that are compiled; of anchored leaves, where
// RAYBUNDLE_ANCHORED is defined, or of others.

#include <raybundle/linalg/kernels/elimination_kernels_impl.h>

namespace raybundle::linalg::RAYBUNDLE_ISA::RAYBUNDLE_PRECISION {

#ifdef RAYBUNDLE_ANCHORED
#define RAYBUNDLE_DEFINE(R, K, E)                                      \
  extern const BlockKernels anchored_##R##_##K##_##E =                 \
      make_block_kernels<RAYBUNDLE_NUMBER, R, K, E, true>();           \
  extern const EliminationKernels eliminate_anchored_##R##_##K##_##E = \
      make_elimination_kernels<RAYBUNDLE_NUMBER, R, K, E, true>();
#else
#define RAYBUNDLE_DEFINE(R, K, E)                                   \
  extern const BlockKernels blocks_##R##_##K##_##E =                \
      make_block_kernels<RAYBUNDLE_NUMBER, R, K, E, false>();       \
  extern const EliminationKernels eliminate_##R##_##K##_##E =       \
      make_elimination_kernels<RAYBUNDLE_NUMBER, R, K, E, false>(); \
  extern const EliminationKernels eliminate_##R##_##E##_##K =       \
      make_elimination_kernels<RAYBUNDLE_NUMBER, R, E, K, false>();
#endif
RAYBUNDLE_DEFINE(2, 9, 3)
RAYBUNDLE_DEFINE(2, 6, 3)
RAYBUNDLE_DEFINE(3, 6, 3)
#undef RAYBUNDLE_DEFINE

}  // namespace raybundle::linalg::RAYBUNDLE_ISA::RAYBUNDLE_PRECISION
