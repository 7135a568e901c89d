#define RAYBUNDLE_ISA baseline
#include <raybundle/linalg/kernels/kernels_impl.h>
