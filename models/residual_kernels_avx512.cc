#define RAYBUNDLE_ISA avx512
#include <raybundle/models/residual_kernels_impl.h>
