#define RAYBUNDLE_ISA avx2
#include <raybundle/models/residual_kernels_impl.h>
