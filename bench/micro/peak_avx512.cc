#define RAYBUNDLE_ISA avx512
#include <raybundle/bench/micro/peak_impl.h>
