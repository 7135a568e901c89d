// Reading a BAL file that is in the system's cache.

#include <filesystem>
#include <string>
#include <system_error>

#include <unistd.h>

#include <benchmark/benchmark.h>

#include <raybundle/bench/micro/benchmarks.h>
#include <raybundle/bench/micro/workload.h>
#include <raybundle/models/io/bal.h>

namespace raybundle::bench {
namespace {

namespace fs = std::filesystem;

class TemporaryFile {
 public:
  TemporaryFile()
      : path_(fs::temp_directory_path() / ("bench_micro-" + std::to_string(::getpid()) + ".txt")) {}
  ~TemporaryFile() {
    std::error_code ignored;
    fs::remove(path_, ignored);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void measure(benchmark::State& state, std::int64_t observations) {
  const TemporaryFile file;
  io::write_bal(photos(observations), file.path());
  for (auto _ : state) {
    const Problem problem = io::read_bal(file.path());
    benchmark::DoNotOptimize(problem.observations.data());
  }
  report(state, {.bytes = static_cast<double>(fs::file_size(file.path())), .flops = 0}, 1);
}

}  // namespace

void register_reading(std::int64_t observations) {
  const std::string name =
      "reading a file/observations:" + std::to_string(observations) + "/threads:1";
  benchmark::RegisterBenchmark(name.c_str(), measure, observations)
      ->UseRealTime()
      ->MinTime(0.2)
      ->Unit(benchmark::kMillisecond);
}

}  // namespace raybundle::bench
