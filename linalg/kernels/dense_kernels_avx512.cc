#include <raybundle/linalg/kernels/dense_kernels.h>

#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
#define RAYBUNDLE_LANES 8
#include <raybundle/linalg/kernels/dense_kernels_impl.h>
#endif

namespace raybundle::linalg {

#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__)
const DenseKernels* dense_kernels_avx512() { return &kernels; }
#else
const DenseKernels* dense_kernels_avx512() { return nullptr; }
#endif

}  // namespace raybundle::linalg
