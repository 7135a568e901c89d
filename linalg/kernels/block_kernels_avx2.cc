#define RAYBUNDLE_ISA avx2
#include <raybundle/linalg/kernels/kernels_impl.h>
