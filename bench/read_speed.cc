// How fast BAL text is read and written, by all cores (taskset gives fewer):
//   bench_read_speed [--copies N] FILE
// With --copies, FILE is repeated N times side by side into one larger valid problem, in a
// temporary file that keeps the spelling of every number, and that one is read.

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <ostream>
#include <stdexcept>
#include <streambuf>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/file_content.h>

namespace {

namespace fs = std::filesystem;
using raybundle::Problem;

/// The text of `count` lines from `at` on, which moves behind them.
std::string_view take_lines(std::string_view text, std::size_t& at, std::int64_t count) {
  const std::size_t first = at;
  for (; count > 0 && at < text.size(); --count) at = text.find('\n', at) + 1;
  return text.substr(first, at - first);
}

/// `copies` problems side by side; expects one parameter per line, as BAL files have it.
void write_copies(std::string_view text, int copies, const fs::path& path) {
  const Problem problem = raybundle::io::parse_bal(text, "original");
  std::size_t at = 0;
  take_lines(text, at, 1);
  std::vector<std::string_view> pixels;  // "x y\n"
  for (std::int64_t i = 0; i < problem.observation_count(); ++i) {
    const std::string_view line = take_lines(text, at, 1);
    std::size_t third = line.find_first_not_of(" \t");
    for (int token = 0; token < 2; ++token) {
      third = line.find_first_not_of(" \t", line.find_first_of(" \t", third));
    }
    pixels.push_back(line.substr(third));
  }
  const std::string_view cameras =
      take_lines(text, at, problem.camera_count() * Problem::camera_size);
  const std::string_view points = text.substr(at);

  raybundle::io::AtomicFile file(path);
  file.write(std::to_string(copies * problem.camera_count()) + " " +
             std::to_string(copies * problem.point_count()) + " " +
             std::to_string(copies * problem.observation_count()) + "\n");
  for (int copy = 0; copy < copies; ++copy) {
    std::string lines;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      lines += std::to_string(copy * problem.camera_count() + problem.observation_camera[i]) + " ";
      lines +=
          std::to_string(copy * problem.point_count() + problem.observation_point[i]) + "     ";
      lines += pixels[i];
    }
    file.write(lines);
  }
  for (int copy = 0; copy < copies; ++copy) file.write(cameras);
  for (int copy = 0; copy < copies; ++copy) file.write(points);
  file.commit();
}

/// Counts what is written and drops it.
class CountingBuffer final : public std::streambuf {
 public:
  double megabytes() const { return static_cast<double>(count_) * 1e-6; }

 protected:
  int overflow(int character) override {
    ++count_;
    return character == traits_type::eof() ? 0 : character;
  }
  std::streamsize xsputn(const char*, std::streamsize size) override {
    count_ += size;
    return size;
  }

 private:
  std::int64_t count_ = 0;
};

struct Time {
  double wall;
  double processor;
};

/// The fastest of five.
template <class Work>
Time fastest(const Work& work) {
  Time best{1e9, 1e9};
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t clock = std::clock();
    work();
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    best.wall = std::min(best.wall, wall.count());
    best.processor =
        std::min(best.processor, static_cast<double>(std::clock() - clock) / CLOCKS_PER_SEC);
  }
  return best;
}

void report(const char* what, double megabytes, Time time) {
  std::printf("%s %.1f MB: %.0f MB/s by the clock, %.0f MB/s of processor time\n", what, megabytes,
              megabytes / time.wall, megabytes / time.processor);
}

void measure(const fs::path& path) {
  Problem problem;
  const Time reading = fastest([&] { problem = raybundle::io::read_bal(path); });
  report("read", static_cast<double>(fs::file_size(path)) * 1e-6, reading);
  double megabytes = 0;
  const Time writing = fastest([&] {
    CountingBuffer buffer;
    std::ostream out(&buffer);
    raybundle::io::write_bal(problem, out);
    megabytes = buffer.megabytes();
  });
  report("format", megabytes, writing);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::vector<std::string> words(argv + 1, argv + argc);
    if (words.size() == 1) {
      measure(words[0]);
      return 0;
    }
    if (words.size() != 3 || words[0] != "--copies") {
      throw std::invalid_argument("usage: bench_read_speed [--copies N] FILE");
    }
    const fs::path large =
        fs::temp_directory_path() / ("read_speed-" + std::to_string(::getpid()) + ".txt");
    write_copies(raybundle::io::FileContent(words[2]).text(), std::stoi(words[1]), large);
    measure(large);
    fs::remove(large);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_read_speed: %s\n", error.what());
    return 1;
  }
}
