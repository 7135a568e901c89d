// The kernels of residual_kernels.h for one instruction set; see linalg/kernels.

#include <raybundle/models/anchored_rows_impl.h>
#include <raybundle/models/xyz_rows_impl.h>

namespace raybundle::RAYBUNDLE_ISA {
namespace {

template <class Rows, PoseUpdate update>
constexpr ResidualKernels kernels = {&Rows::cost, &Rows::residuals,
                                     &Rows::template linearize<update>};

template <template <Sensor> class Rows, PoseUpdate update>
constexpr KernelsBySensor by_sensor = {
    {kernels<Rows<Sensor::pixel_and_lens>, update>, kernels<Rows<Sensor::pixel>, update>,
     kernels<Rows<Sensor::ray>, update>, kernels<Rows<Sensor::pixel_ray>, update>}};

template <template <Sensor> class Rows>
constexpr KernelsByUpdate by_update = {{by_sensor<Rows, PoseUpdate::global>,
                                        by_sensor<Rows, PoseUpdate::local>,
                                        by_sensor<Rows, PoseUpdate::se3>}};

}  // namespace

// Of coordinates, and of anchored points.
extern const KernelsByUpdate residual_kernel_table[2] = {by_update<XyzRows>,
                                                         by_update<AnchoredRows>};

}  // namespace raybundle::RAYBUNDLE_ISA
