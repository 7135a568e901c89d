#define RAYBUNDLE_ISA baseline
#include <raybundle/models/residual_kernels_impl.h>
