#define RAYBUNDLE_ISA avx512
#include <raybundle/linalg/kernels/block_kernels_impl.h>
