#include <raybundle/models/residual_kernels.h>

#include <raybundle/linalg/cpu.h>

#include <stdexcept>

namespace raybundle {

namespace baseline {
extern const KernelsByUpdate residual_kernel_table[2];
}
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
namespace avx2 {
extern const KernelsByUpdate residual_kernel_table[2];
}
namespace avx512 {
extern const KernelsByUpdate residual_kernel_table[2];
}
#endif

Sensor sensor_of(const Formulation& formulation) {
  const bool lens = formulation.lens == Lens::free;
  if (formulation.objective == ObjectiveKind::pixel) {
    return lens ? Sensor::pixel_and_lens : Sensor::pixel;
  }
  if (lens) throw std::invalid_argument("rays are of undistorted pixels: the lenses must be fixed");
  return formulation.ray_weight == RayWeight::pixel ? Sensor::pixel_ray : Sensor::ray;
}

const ResidualKernels& residual_kernels(bool anchored, PoseUpdate update, Sensor sensor) {
  const int kind = anchored ? 1 : 0;
  const auto row = static_cast<int>(update);
  const auto column = static_cast<int>(sensor);
#ifdef RAYBUNDLE_HAVE_X86_KERNELS
  if (linalg::instruction_set() == linalg::InstructionSet::avx512) {
    return avx512::residual_kernel_table[kind].of[row].of[column];
  }
  if (linalg::instruction_set() == linalg::InstructionSet::avx2) {
    return avx2::residual_kernel_table[kind].of[row].of[column];
  }
#endif
  return baseline::residual_kernel_table[kind].of[row].of[column];
}

}  // namespace raybundle
