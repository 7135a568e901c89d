#include <raybundle/models/io/bal.h>

#include <ostream>
#include <system_error>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/text_writer.h>

namespace raybundle::io {
namespace {

void write_bal(const Problem& problem, TextWriter& writer) {
  writer.number(problem.camera_count(), ' ');
  writer.number(problem.point_count(), ' ');
  writer.number(problem.observation_count(), '\n');
  for (std::size_t i = 0; i < problem.observation_camera.size(); ++i) {
    writer.number(problem.observation_camera[i], ' ');
    writer.number(problem.observation_point[i], ' ');
    writer.number(problem.observations[2 * i], ' ');
    writer.number(problem.observations[2 * i + 1] / problem.aspect, '\n');
  }
  for (const double value : problem.cameras) writer.number(value, '\n');
  for (const double value : problem.points) writer.number(value, '\n');
  writer.flush();
}

}  // namespace

void write_bal(const Problem& problem, const std::filesystem::path& path) {
  validate(problem);
  AtomicFile file(path);
  TextWriter writer([&](std::string_view piece) { file.write(piece); });
  write_bal(problem, writer);
  file.commit();
}

void write_bal(const Problem& problem, std::ostream& out) {
  validate(problem);
  TextWriter writer([&](std::string_view piece) {
    out.write(piece.data(), static_cast<std::streamsize>(piece.size()));
  });
  write_bal(problem, writer);
  out.flush();
  if (!out) throw std::system_error(std::make_error_code(std::errc::io_error), "cannot write BAL");
}

}  // namespace raybundle::io
