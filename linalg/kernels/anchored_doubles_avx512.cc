#define RAYBUNDLE_ANCHORED
#define RAYBUNDLE_ISA avx512
#define RAYBUNDLE_PRECISION doubles
#define RAYBUNDLE_NUMBER double
#include <raybundle/linalg/kernels/kernels_impl.h>
