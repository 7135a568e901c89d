#include <raybundle/linalg/kernels/dense_kernels.h>

#define RAYBUNDLE_LANES 2
#include <raybundle/linalg/kernels/dense_kernels_impl.h>

namespace raybundle::linalg {

const DenseKernels* dense_kernels_baseline() { return &kernels; }

}  // namespace raybundle::linalg
