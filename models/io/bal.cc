#include <raybundle/models/io/bal.h>

#include <array>
#include <limits>
#include <ostream>
#include <system_error>

#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/text_reader.h>
#include <raybundle/models/io/text_writer.h>

namespace raybundle::io {
namespace {

struct Header {
  std::int32_t cameras;
  std::int32_t points;
  std::int64_t observations;
};

constexpr std::array<const char*, Problem::camera_size> camera_parameters = {
    "rotation vector x", "rotation vector y", "rotation vector z", "translation x", "translation y",
    "translation z",     "focal length",      "distortion k1",     "distortion k2"};
constexpr std::array<const char*, Problem::point_size> point_coordinates = {"x", "y", "z"};

std::string range(std::int64_t least, std::int64_t most) {
  return std::to_string(least) + " to " + std::to_string(most);
}

template <class Count>
Count read_count(TextReader& reader, const char* what) {
  constexpr Count most = std::numeric_limits<Count>::max();
  reader.skip_blanks();
  return reader.integer(Count{1}, most, [&] {
    return "the number of " + std::string(what) + ", " + range(1, most) +
           " (header: cameras points observations)";
  });
}

/// Refuses a header that needs more text than there is: whatever is allocated from it is then
/// bounded by the size of the file. An observation takes at least the 8 bytes "0 0 0 0\n", a
/// parameter the 2 bytes "0\n"; the last line end may be missing, that of the header is still
/// ahead.
void check_promise(const TextReader& reader, const Header& header) {
  const std::int64_t available = reader.remaining();
  const std::int64_t parameters = std::int64_t{header.cameras} * Problem::camera_size +
                                  std::int64_t{header.points} * Problem::point_size;
  const bool fits =
      header.observations <= available / 8 && 8 * header.observations + 2 * parameters <= available;
  if (fits) return;
  reader.fail("a header that promises " + std::to_string(header.cameras) + " cameras, " +
                  std::to_string(header.points) + " points and " +
                  std::to_string(header.observations) + " observations",
              "no more than fits into the " + std::to_string(available) + " bytes after it");
}

Header read_header(TextReader& reader) {
  reader.skip_space();
  Header header{};
  header.cameras = read_count<std::int32_t>(reader, "cameras");
  header.points = read_count<std::int32_t>(reader, "points");
  header.observations = read_count<std::int64_t>(reader, "observations");
  reader.skip_blanks();
  if (!reader.at_line_end()) reader.fail("the end of the line after the three header counts");
  check_promise(reader, header);
  return header;
}

/// One line. Its four numbers must stand on it: a shorter one must not eat the line after it.
void read_observation(TextReader& reader, const Header& header, std::size_t i, Problem& problem) {
  const auto expected = [&](const char* what, const std::string& values) {
    return std::string(what) + " of observation " + std::to_string(i + 1) + " of " +
           std::to_string(header.observations) + values;
  };
  const auto index = [&](const char* what, std::int32_t count) {
    return reader.integer(0, count - 1, [&] { return expected(what, ", " + range(0, count - 1)); });
  };
  const auto pixel = [&](const char* what) {
    return reader.number([&] { return "a finite number, " + expected(what, ""); });
  };

  reader.skip_space();
  problem.observation_camera[i] = index("the camera index", header.cameras);
  reader.skip_blanks();
  problem.observation_point[i] = index("the point index", header.points);
  reader.skip_blanks();
  problem.observations[2 * i] = pixel("x");
  reader.skip_blanks();
  problem.observations[2 * i + 1] = pixel("y");
  reader.skip_blanks();
  if (!reader.at_line_end()) reader.fail(expected("the end of the line after y", ""));
}

/// Numbers separated by white space of any kind: `names.size()` per camera or point.
template <std::size_t size>
void read_parameters(TextReader& reader, const char* owner,
                     const std::array<const char*, size>& names, std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    reader.skip_space();
    values[i] = reader.number([&] {
      return "a finite number, " + std::string(names[i % size]) + " of " + owner + " " +
             std::to_string(i / size) + " (of " +
             range(0, static_cast<std::int64_t>(values.size() / size) - 1) + ")";
    });
  }
}

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

Problem read_bal(const std::filesystem::path& path) {
  const FileContent content(path);
  return parse_bal(content.text(), path.string());
}

Problem parse_bal(std::string_view text, const std::string& source) {
  TextReader reader(text, source);
  const Header header = read_header(reader);
  const auto observations = static_cast<std::size_t>(header.observations);

  Problem problem;
  problem.observation_camera.resize(observations);
  problem.observation_point.resize(observations);
  problem.observations.resize(2 * observations);
  problem.cameras.resize(static_cast<std::size_t>(header.cameras) * Problem::camera_size);
  problem.points.resize(static_cast<std::size_t>(header.points) * Problem::point_size);

  for (std::size_t i = 0; i < observations; ++i) read_observation(reader, header, i, problem);
  read_parameters(reader, "camera", camera_parameters, problem.cameras);
  read_parameters(reader, "point", point_coordinates, problem.points);
  reader.skip_space();
  if (!reader.at_end()) {
    reader.fail("the end of the file after what the header promises: " +
                std::to_string(header.cameras) + " cameras, " + std::to_string(header.points) +
                " points and " + std::to_string(header.observations) + " observations");
  }
  return problem;
}

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
