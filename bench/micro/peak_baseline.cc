#define RAYBUNDLE_ISA baseline
#include <raybundle/bench/micro/peak_impl.h>
