#include <raybundle/models/io/bal.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>

#include <raybundle/linalg/huge_pages.h>
#include <raybundle/models/error.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/text_pieces.h>
#include <raybundle/models/io/text_reader.h>

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
              "no more than fits into the " + std::to_string(available) +
                  " bytes after it: the file is cut off, or the header is wrong");
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

/// Parameter i of all cameras, then of all points: numbers separated by white space of any kind.
template <std::size_t size>
double read_parameter(TextReader& reader, const char* owner,
                      const std::array<const char*, size>& names, std::size_t i,
                      std::size_t count) {
  reader.skip_space();
  return reader.number([&] {
    return "a finite number, " + std::string(names[i % size]) + " of " + owner + " " +
           std::to_string(i / size) + " (of " +
           range(0, static_cast<std::int64_t>(count / size) - 1) + ")";
  });
}

void read_parameter(TextReader& reader, std::size_t i, Problem& problem) {
  const std::size_t cameras = problem.cameras.size(), points = problem.points.size();
  if (i < cameras) {
    problem.cameras[i] = read_parameter(reader, "camera", camera_parameters, i, cameras);
  } else {
    problem.points[i - cameras] =
        read_parameter(reader, "point", point_coordinates, i - cameras, points);
  }
}

/// Zeros; their memory is asked for in large pages, which the system has ready sooner.
template <class T>
void allocate(std::int64_t count, std::vector<T>& values) {
  values.reserve(static_cast<std::size_t>(count));
  linalg::advise_huge_pages(values.data(), values.capacity() * sizeof(T));
  values.resize(static_cast<std::size_t>(count));
}

Problem allocate(const Header& header) {
  Problem problem;
  allocate(header.observations, problem.observation_camera);
  allocate(header.observations, problem.observation_point);
  allocate(2 * header.observations, problem.observations);
  allocate(std::int64_t{header.cameras} * Problem::camera_size, problem.cameras);
  allocate(std::int64_t{header.points} * Problem::point_size, problem.points);
  return problem;
}

/// All observations, of which the first stands on the next line that is not blank. Leaves the
/// reader behind the last. What is missing is missing at the end.
void read_observations(std::string_view text, const Header& header, TextReader& reader,
                       linalg::ThreadPool& pool, Problem& problem) {
  const TextPieces pieces(text, reader.position(), TextPieces::Unit::lines, pool);
  std::atomic<std::int64_t> end = static_cast<std::int64_t>(text.size());
  pieces.read(pool, [&](std::int64_t begin, std::int64_t first, std::int64_t last) {
    TextReader own = reader;
    own.move_to(begin);
    for (std::int64_t i = first; i < std::min(last, header.observations); ++i) {
      read_observation(own, header, static_cast<std::size_t>(i), problem);
      if (i + 1 == header.observations) end = own.position();
    }
  });
  reader.move_to(end);
  if (pieces.units() < header.observations) {
    read_observation(reader, header, static_cast<std::size_t>(pieces.units()), problem);
  }
}

/// All parameters, and nothing after them.
void read_parameters(std::string_view text, const Header& header, TextReader& reader,
                     linalg::ThreadPool& pool, Problem& problem) {
  const TextPieces pieces(text, reader.position(), TextPieces::Unit::words, pool);
  const auto count = static_cast<std::int64_t>(problem.cameras.size() + problem.points.size());
  pieces.read(pool, [&](std::int64_t begin, std::int64_t first, std::int64_t last) {
    TextReader own = reader;
    own.move_to(begin);
    for (std::int64_t i = first; i < std::min(last, count); ++i) {
      read_parameter(own, static_cast<std::size_t>(i), problem);
    }
    if (last <= count) return;
    own.skip_space();
    own.fail("the end of the file after what the header promises: " +
             std::to_string(header.cameras) + " cameras, " + std::to_string(header.points) +
             " points and " + std::to_string(header.observations) + " observations");
  });
  if (pieces.units() >= count) return;
  reader.move_to(static_cast<std::int64_t>(text.size()));
  read_parameter(reader, static_cast<std::size_t>(pieces.units()), problem);
}

/// Threads that a text of some bytes keeps busy.
int useful_threads(std::size_t bytes, int threads) {
  constexpr std::size_t little = std::size_t{1} << 20;
  if (bytes < little) return 1;
  return threads > 0 ? threads : linalg::available_threads();
}

}  // namespace

Problem read_bal(const std::filesystem::path& path, int threads) {
  const FileContent content(path);
  return parse_bal(content.text(), path.string(), threads);
}

Problem parse_bal(std::string_view text, const std::string& source, int threads) {
  TextReader reader(text, source);
  const Header header = read_header(reader);
  Problem problem = allocate(header);
  linalg::ThreadPool pool(useful_threads(text.size(), threads));
  read_observations(text, header, reader, pool, problem);
  read_parameters(text, header, reader, pool, problem);
  return problem;
}

}  // namespace raybundle::io
