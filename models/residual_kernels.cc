#include <raybundle/models/residual_kernels.h>

#include <raybundle/linalg/cpu.h>

namespace raybundle {

namespace baseline {
extern const ResidualKernels residual_kernel_table[3][2];
}
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
namespace avx2 {
extern const ResidualKernels residual_kernel_table[3][2];
}
namespace avx512 {
extern const ResidualKernels residual_kernel_table[3][2];
}
#endif

const ResidualKernels& residual_kernels(PoseUpdate update, Lens lens) {
  const auto row = static_cast<int>(update);
  const auto column = static_cast<int>(lens);
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
  if (linalg::instruction_set() == linalg::InstructionSet::avx512) {
    return avx512::residual_kernel_table[row][column];
  }
  if (linalg::instruction_set() == linalg::InstructionSet::avx2) {
    return avx2::residual_kernel_table[row][column];
  }
#endif
  return baseline::residual_kernel_table[row][column];
}

}  // namespace raybundle
