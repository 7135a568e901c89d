#define RAYBUNDLE_ISA avx2
#include <raybundle/linalg/kernels/block_kernels_impl.h>
