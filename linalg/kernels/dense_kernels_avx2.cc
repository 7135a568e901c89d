#include <raybundle/linalg/kernels/dense_kernels.h>

#if defined(__AVX2__) && defined(__FMA__)
#define RAYBUNDLE_LANES 4
#include <raybundle/linalg/kernels/dense_kernels_impl.h>
#endif

namespace raybundle::linalg {

#if defined(__AVX2__) && defined(__FMA__)
const DenseKernels* dense_kernels_avx2() { return &kernels; }
#else
const DenseKernels* dense_kernels_avx2() { return nullptr; }
#endif

}  // namespace raybundle::linalg
