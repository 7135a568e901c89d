// The kernels of residual_kernels.h for one instruction set; see linalg/kernels.

#include <raybundle/models/anchored_rows_impl.h>
#include <raybundle/models/xyz_rows_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

template <class Rows, PoseUpdate Update>
constexpr ResidualKernels kernels = {&Rows::cost, &Rows::residuals,
                                     &Rows::template linearize<Update>};

#define RAYBUNDLE_BY_SENSOR(Rows, update)                                                \
  {                                                                                      \
    kernels<Rows<Sensor::pixel_and_lens>, update>, kernels<Rows<Sensor::pixel>, update>, \
        kernels<Rows<Sensor::ray>, update>, kernels<Rows<Sensor::pixel_ray>, update>     \
  }
#define RAYBUNDLE_BY_UPDATE(Rows)                                                                \
  {                                                                                              \
    RAYBUNDLE_BY_SENSOR(Rows, PoseUpdate::global), RAYBUNDLE_BY_SENSOR(Rows, PoseUpdate::local), \
        RAYBUNDLE_BY_SENSOR(Rows, PoseUpdate::se3)                                               \
  }

}  // namespace

// Indexed by anchored, PoseUpdate and Sensor, in the order of their values.
extern const ResidualKernels residual_kernel_table[2][3][sensors] = {
    RAYBUNDLE_BY_UPDATE(XyzRows), RAYBUNDLE_BY_UPDATE(AnchoredRows)};

#undef RAYBUNDLE_BY_SENSOR
#undef RAYBUNDLE_BY_UPDATE

}  // namespace raybundle::RAYBUNDLE_ISA
