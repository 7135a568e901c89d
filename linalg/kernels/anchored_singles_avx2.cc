#define RAYBUNDLE_ANCHORED
#define RAYBUNDLE_ISA avx2
#define RAYBUNDLE_PRECISION singles
#define RAYBUNDLE_NUMBER float
#include <raybundle/linalg/kernels/kernels_impl.h>
