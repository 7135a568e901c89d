#include <raybundle/models/residual_kernels.h>

#include <raybundle/linalg/cpu.h>

namespace raybundle {

namespace baseline {
extern const ResidualKernels residual_kernel_table[2][3][3];
}
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
namespace avx2 {
extern const ResidualKernels residual_kernel_table[2][3][3];
}
namespace avx512 {
extern const ResidualKernels residual_kernel_table[2][3][3];
}
#endif

Sensor sensor_for(ObjectiveKind objective, Lens lens) {
  if (objective == ObjectiveKind::ray) return Sensor::ray;
  return lens == Lens::free ? Sensor::pixel_and_lens : Sensor::pixel;
}

const ResidualKernels& residual_kernels(bool anchored, PoseUpdate update, Sensor sensor) {
  const int kind = anchored ? 1 : 0;
  const auto row = static_cast<int>(update);
  const auto column = static_cast<int>(sensor);
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
  if (linalg::instruction_set() == linalg::InstructionSet::avx512) {
    return avx512::residual_kernel_table[kind][row][column];
  }
  if (linalg::instruction_set() == linalg::InstructionSet::avx2) {
    return avx2::residual_kernel_table[kind][row][column];
  }
#endif
  return baseline::residual_kernel_table[kind][row][column];
}

}  // namespace raybundle
