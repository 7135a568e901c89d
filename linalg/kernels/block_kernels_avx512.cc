#define RAYBUNDLE_ISA avx512
#include <raybundle/linalg/kernels/kernels_impl.h>
