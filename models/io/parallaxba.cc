#include <raybundle/models/io/parallaxba.h>

#include <raybundle/models/error.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/parallaxba_frame.h>
#include <raybundle/models/io/text_reader.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cctype>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace raybundle::io {
namespace {

namespace fs = std::filesystem;
using so3::Matrix3;
using so3::Vector3;

struct Calibration {
  double fx, fy, cx, cy;
};

double read_number(TextReader& reader, const std::string& what) {
  return reader.number([&] { return "a finite number, " + what; });
}

// The content of a folder's file; compressed ones are told by bytes that no text has.
TextReader read_text(const FileContent& content, const fs::path& path) {
  const std::string_view start = content.text().substr(0, 4);
  const auto is_binary = [](unsigned char c) { return c >= 0x80 || (c < ' ' && !std::isspace(c)); };
  if (std::any_of(start.begin(), start.end(), is_binary)) {
    throw InputError(path.string(), 1, quoted(start), "numbers: files of a folder are plain text");
  }
  return {content.text(), path.string()};
}

void end_line(TextReader& reader, const std::string& after) {
  reader.skip_blanks();
  if (!reader.at_line_end()) reader.fail("the end of the line after " + after);
}

using Starts = std::span<const std::string_view>;
constexpr std::array<std::string_view, 2> calibration_starts = {"cal", "intrinsic"};
constexpr std::array<std::string_view, 1> camera_starts = {"Cam"};
constexpr std::array<std::string_view, 1> feature_starts = {"Feature"};

bool starts_with_one(const fs::path& file, Starts starts) {
  const std::string name = file.filename().string();
  return std::any_of(starts.begin(), starts.end(),
                     [&](std::string_view start) { return name.starts_with(start); });
}

// The only file of the folder whose name starts with one of these; otherwise `wrong` is told.
fs::path only_file(const fs::path& folder, Starts starts, std::string& wrong) {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (starts_with_one(entry.path(), starts)) found.push_back(entry.path());
  }
  if (found.size() == 1) return found.front();
  std::string names;
  for (const std::string_view start : starts) {
    names += (names.empty() ? "" : " or ") + std::string(start) + "*";
  }
  wrong += (wrong.empty() ? "" : ", ") + std::to_string(found.size()) + " files " + names;
  return {};
}

Calibration read_calibration(const fs::path& path) {
  const FileContent content(path);
  TextReader reader = read_text(content, path);
  std::array<double, 9> K{};
  for (std::size_t i = 0; i < K.size(); ++i) {
    reader.skip_space();
    K[i] = read_number(
        reader, "entry " + std::to_string(i / 3 + 1) + ", " + std::to_string(i % 3 + 1) + " of K");
  }
  const bool shape =
      K[0] > 0 && K[4] > 0 && K[1] == 0 && K[3] == 0 && K[6] == 0 && K[7] == 0 && K[8] == 1;
  if (!shape) reader.fail("another matrix", "K = [fx 0 cx; 0 fy cy; 0 0 1] with fx, fy > 0");
  return {K[0], K[4], K[2], K[5]};
}

void append_camera(const std::array<double, 6>& numbers, double f, Problem& problem) {
  const Matrix3 R_cw = parallaxba_rotation({numbers[0], numbers[1], numbers[2]});
  const Vector3 phi = so3::log(R_cw);
  const Vector3 t_cw = -(R_cw * Vector3(numbers[3], numbers[4], numbers[5]));
  problem.cameras.insert(problem.cameras.end(), phi.begin(), phi.end());
  problem.cameras.insert(problem.cameras.end(), t_cw.begin(), t_cw.end());
  problem.cameras.insert(problem.cameras.end(), {f, 0, 0});
}

void read_cameras(TextReader reader, double f, Problem& problem) {
  constexpr std::array<const char*, 6> names = {"alpha", "beta", "gamma", "tx", "ty", "tz"};
  for (reader.skip_space(); !reader.at_end(); reader.skip_space()) {
    const std::string camera = " of camera " + std::to_string(problem.camera_count());
    std::array<double, 6> numbers{};
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      reader.skip_blanks();
      numbers[i] = read_number(reader, names[i] + camera);
    }
    end_line(reader, "tz" + camera);
    append_camera(numbers, f, problem);
  }
  if (problem.cameras.empty()) reader.fail("a camera: alpha beta gamma tx ty tz");
}

void read_features(const fs::path& path, const Calibration& K, Problem& problem) {
  const FileContent content(path);
  TextReader reader = read_text(content, path);
  const auto cameras = static_cast<std::int32_t>(problem.camera_count());
  constexpr std::int32_t most = std::numeric_limits<std::int32_t>::max();
  std::int32_t point = 0;
  for (reader.skip_space(); !reader.at_end(); reader.skip_space(), ++point) {
    const std::string of = " of feature " + std::to_string(point);
    const auto count =
        reader.integer<std::int32_t>(1, most, [&] { return "the number of observations" + of; });
    for (std::int32_t k = 0; k < count; ++k) {
      const std::string which = " of observation " + std::to_string(k + 1) + of;
      reader.skip_blanks();
      problem.observation_camera.push_back(reader.integer<std::int32_t>(0, cameras - 1, [&] {
        return "the camera, 0 to " + std::to_string(cameras - 1) + "," + which;
      }));
      problem.observation_point.push_back(point);
      reader.skip_blanks();
      const double u = read_number(reader, "u" + which);
      reader.skip_blanks();
      const double v = read_number(reader, "v" + which);
      problem.observations.push_back(u - K.cx);
      problem.observations.push_back(K.cy - v);
    }
    end_line(reader, "the observations" + of);
  }
  if (point == 0) reader.fail("a feature: its number of observations, then camera u v of each");
  problem.points.resize(3 * static_cast<std::size_t>(point), 0.0);
}

}  // namespace

bool is_parallaxba(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

bool is_parallaxba_file(const fs::path& file) {
  return starts_with_one(file, camera_starts) || starts_with_one(file, feature_starts) ||
         starts_with_one(file, calibration_starts);
}

bool holds_parallaxba(const fs::path& folder) {
  std::error_code ignored;
  fs::directory_iterator entries(folder, ignored);
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) { return is_parallaxba_file(entry.path()); });
}

ParallaxBaFiles parallaxba_files(const fs::path& folder) {
  std::string wrong;
  const ParallaxBaFiles files = {only_file(folder, calibration_starts, wrong),
                                 only_file(folder, camera_starts, wrong),
                                 only_file(folder, feature_starts, wrong)};
  if (wrong.empty()) return files;
  throw InputError(folder.string(), 0, wrong,
                   "one of each, as ParallaxBA's folders have Cam*, Feature* and cal* or "
                   "intrinsic*");
}

Problem read_parallaxba(const fs::path& folder) {
  const ParallaxBaFiles files = parallaxba_files(folder);
  const Calibration K = read_calibration(files.calibration);
  Problem problem;
  problem.aspect = K.fy / K.fx;
  const FileContent cameras(files.cameras);
  read_cameras(read_text(cameras, files.cameras), K.fx, problem);
  read_features(files.features, K, problem);
  return with_points_from_rays(std::move(problem));
}

Problem parse_parallaxba_cameras(std::string_view text, const std::string& source) {
  Problem problem;
  read_cameras(TextReader(text, source), 1, problem);
  return problem;
}

Problem read_parallaxba_cameras(const fs::path& file) {
  const FileContent content(file);
  return parse_parallaxba_cameras(content.text(), file.string());
}

}  // namespace raybundle::io
