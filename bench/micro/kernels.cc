// The kernels of a step, each by itself on the same linearisation.

#include <string>

#include <benchmark/benchmark.h>

#include <raybundle/bench/micro/benchmarks.h>
#include <raybundle/bench/micro/machine.h>
#include <raybundle/bench/micro/work.h>
#include <raybundle/bench/micro/workload.h>

namespace raybundle::bench {
namespace {

struct Kernel {
  const char* name;
  void (*run)(Workload& w);
  Work (*work)(const Workload& w);
};

constexpr Kernel kernels[] = {
    {"linearisation", [](Workload& w) { w.objective.linearize(w.state, w.J, w.normal); },
     linearize_work},
    {"cost", [](Workload& w) { benchmark::DoNotOptimize(w.objective.cost(w.state)); }, cost_work},
    {"point elimination", [](Workload& w) { w.schur.prepare(w.at(), w.damping.data()); },
     prepare_work},
    {"reduced right side", [](Workload& w) { w.schur.gradient(w.y.data()); }, gradient_work},
    {"implicit Schur product", [](Workload& w) { w.schur.apply(w.x.data(), w.y.data()); },
     apply_work},
    {"diagonal of S", [](Workload& w) { w.schur.reduced_diagonal(w.diagonal, w.y.data()); },
     diagonal_work},
    {"explicit assembly", [](Workload& w) { w.schur.assemble(w.reduced_matrix(), w.y.data()); },
     assemble_work},
    {"back-substitution",
     [](Workload& w) { benchmark::DoNotOptimize(w.schur.expand(w.x.data(), w.step.data())); },
     expand_work},
};

void measure(benchmark::State& state, const Kernel& kernel, std::int64_t observations,
             int threads) {
  Workload& w = workload(observations, threads);
  kernel.run(w);
  for (auto _ : state) {
    kernel.run(w);
    benchmark::ClobberMemory();
  }
  report(state, kernel.work(w), threads);
}

}  // namespace

void report(benchmark::State& state, Work work, int threads) {
  const auto rate = [](double amount) {
    return benchmark::Counter(amount, benchmark::Counter::kIsIterationInvariantRate);
  };
  const Machine& most = machine(threads);
  if (work.bytes > 0) {
    state.counters["GB/s"] = rate(1e-9 * work.bytes);
    state.counters["of_triad"] = rate(1e-9 * work.bytes / most.triad);
  }
  if (work.flops > 0) {
    state.counters["GFlop/s"] = rate(1e-9 * work.flops);
    state.counters["of_peak"] = rate(1e-9 * work.flops / most.peak);
  }
}

void register_kernels(std::int64_t observations, int threads) {
  for (const Kernel& kernel : kernels) {
    const std::string name = std::string(kernel.name) +
                             "/observations:" + std::to_string(observations) +
                             "/threads:" + std::to_string(threads);
    benchmark::RegisterBenchmark(name.c_str(), measure, kernel, observations, threads)
        ->UseRealTime()
        ->MinTime(0.2)
        ->Unit(benchmark::kMillisecond);
  }
}

}  // namespace raybundle::bench
