#pragma once

#include <cstdint>

#include <benchmark/benchmark.h>

#include <raybundle/bench/micro/work.h>

namespace raybundle::bench {

/// Adds the counters GB/s and GFlop/s and the shares of what the machine can do with that many
/// threads, of_triad and of_peak; those of nothing are left out.
void report(benchmark::State& state, Work work, int threads);

/// Names are "<kernel>/<size>:<number>/threads:<number>".
void register_kernels(std::int64_t observations, int threads);
void register_dense_cholesky(std::int64_t order, int threads);
void register_reading(std::int64_t observations);

}  // namespace raybundle::bench
