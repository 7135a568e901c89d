#define RAYBUNDLE_ISA baseline
#include <raybundle/linalg/kernels/block_kernels_impl.h>
