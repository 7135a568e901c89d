#define RAYBUNDLE_ISA avx2
#include <raybundle/bench/micro/peak_impl.h>
