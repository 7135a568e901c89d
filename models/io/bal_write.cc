#include <raybundle/models/io/bal.h>

#include <algorithm>
#include <array>
#include <functional>
#include <ostream>
#include <string>
#include <system_error>

#include <raybundle/linalg/parallel.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/text_writer.h>

namespace raybundle::io {
namespace {

using Sink = std::function<void(std::string_view)>;

/// Calls format(writer, i) for all i below `count` and hands the text to `sink` in their order:
/// some pieces at a time are formatted in parallel.
template <class Format>
void write_each(std::size_t count, linalg::ThreadPool& pool, const Sink& sink,
                const Format& format) {
  constexpr std::size_t piece = 4096, pieces = 16;
  std::array<std::string, pieces> texts;
  for (std::size_t first = 0; first < count; first += piece * pieces) {
    pool.run(pieces, [&](std::int64_t k) {
      std::string& text = texts[static_cast<std::size_t>(k)];
      text.clear();
      TextWriter writer([&text](std::string_view part) { text += part; });
      const std::size_t begin = std::min(count, first + piece * static_cast<std::size_t>(k));
      for (std::size_t i = begin; i < std::min(count, begin + piece); ++i) format(writer, i);
      writer.flush();
    });
    for (const std::string& text : texts) sink(text);
  }
}

void write_bal(const Problem& problem, const Sink& sink, int threads) {
  const std::size_t observations = problem.observation_camera.size();
  constexpr std::size_t few = 50'000;
  linalg::ThreadPool pool(observations < few ? 1
                          : threads > 0      ? threads
                                             : linalg::available_threads());
  TextWriter header(sink);
  header.number(problem.camera_count(), ' ');
  header.number(problem.point_count(), ' ');
  header.number(problem.observation_count(), '\n');
  header.flush();
  write_each(observations, pool, sink, [&](TextWriter& writer, std::size_t i) {
    writer.number(problem.observation_camera[i], ' ');
    writer.number(problem.observation_point[i], ' ');
    writer.number(problem.observations[2 * i], ' ');
    writer.number(problem.observations[2 * i + 1] / problem.aspect, '\n');
  });
  for (const std::vector<double>* values : {&problem.cameras, &problem.points}) {
    write_each(values->size(), pool, sink,
               [&](TextWriter& writer, std::size_t i) { writer.number((*values)[i], '\n'); });
  }
}

}  // namespace

void write_bal(const Problem& problem, const std::filesystem::path& path, int threads) {
  validate(problem);
  AtomicFile file(path);
  write_bal(
      problem, [&](std::string_view piece) { file.write(piece); }, threads);
  file.commit();
}

void write_bal(const Problem& problem, std::ostream& out, int threads) {
  validate(problem);
  write_bal(
      problem,
      [&](std::string_view piece) {
        out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
      },
      threads);
  out.flush();
  if (!out) throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write BAL");
}

}  // namespace raybundle::io
