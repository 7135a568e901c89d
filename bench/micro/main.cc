// Micro benchmarks of the kernels, beside what the machine itself can do in the same run: the
// context of the output has triad_<threads> in GB/s and peak_<threads> in GFlop/s. Options are
// those of Google Benchmark; tools/roofline makes a table of the results.

#include <cstdio>
#include <exception>
#include <string>

#include <benchmark/benchmark.h>

#include <raybundle/bench/micro/benchmarks.h>
#include <raybundle/bench/micro/machine.h>
#include <raybundle/linalg/cpu.h>

int main(int argc, char** argv) {
  using namespace raybundle;
  try {
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::AddCustomContext("instructions",
                                std::string(linalg::name(linalg::instruction_set())));
    for (const int threads : {1, 2}) {
      const bench::Machine& most = bench::machine(threads);
      benchmark::AddCustomContext("triad_" + std::to_string(threads), std::to_string(most.triad));
      benchmark::AddCustomContext("peak_" + std::to_string(threads), std::to_string(most.peak));
    }
    bench::register_kernels(22'000, 1);  // from a core's own caches: without waiting for memory
    for (const std::int64_t observations : {200'000, 1'000'000}) {
      for (const int threads : {1, 2}) bench::register_kernels(observations, threads);
      bench::register_reading(observations);
    }
    for (const std::int64_t order : {189, 441, 900, 1800, 3600}) {
      for (const int threads : {1, 2}) bench::register_dense_cholesky(order, threads);
    }
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_micro: %s\n", error.what());
    return 1;
  }
}
