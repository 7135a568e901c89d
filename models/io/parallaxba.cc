#include <raybundle/models/io/parallaxba.h>

#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/text_reader.h>
#include <raybundle/models/io/text_writer.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace raybundle::io {
namespace {

namespace fs = std::filesystem;
using so3::Matrix3;
using so3::Vector3;

// Theirs to ours and back.
const Vector3 flip(1, -1, -1);

struct Calibration {
  double fx, fy, cx, cy;
};

double read_number(TextReader& reader, const std::string& what) {
  return reader.number([&] { return "a finite number, " + what; });
}

void end_line(TextReader& reader, const std::string& after) {
  reader.skip_blanks();
  if (!reader.at_line_end()) reader.fail("the end of the line after " + after);
}

// The only file of the folder whose name starts with one of these.
fs::path only_file(const fs::path& folder, const std::vector<std::string>& starts) {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool named = std::any_of(starts.begin(), starts.end(),
                                   [&](const auto& start) { return name.rfind(start, 0) == 0; });
    if (named) found.push_back(entry.path());
  }
  if (found.size() == 1) return found.front();
  std::string names;
  for (const std::string& start : starts) names += (names.empty() ? "" : " or ") + start + "*";
  throw InputError(folder.string(), 0, std::to_string(found.size()) + " files " + names,
                   "one, as ParallaxBA's folders have Cam*, Feature* and cal* or intrinsic*");
}

Calibration read_calibration(const fs::path& path) {
  const FileContent content(path);
  TextReader reader(content.text(), path.string());
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

// Rows of a rotation about one axis by an angle, with the signs of [Zhao15].
Matrix3 about(int axis, double angle) {
  return Eigen::AngleAxisd(-angle, Vector3::Unit(axis)).toRotationMatrix();
}

void append_camera(const std::array<double, 6>& numbers, double f, Problem& problem) {
  const Matrix3 theirs = about(0, numbers[2]) * about(1, numbers[1]) * about(2, numbers[0]);
  const Matrix3 R_cw = flip.asDiagonal() * theirs;
  const Vector3 phi = so3::log(R_cw);
  const Vector3 t_cw = -(R_cw * Vector3(numbers[3], numbers[4], numbers[5]));
  problem.cameras.insert(problem.cameras.end(), phi.begin(), phi.end());
  problem.cameras.insert(problem.cameras.end(), t_cw.begin(), t_cw.end());
  problem.cameras.insert(problem.cameras.end(), {f, 0, 0});
}

void read_cameras(const fs::path& path, double f, Problem& problem) {
  constexpr std::array<const char*, 6> names = {"alpha", "beta", "gamma", "tx", "ty", "tz"};
  const FileContent content(path);
  TextReader reader(content.text(), path.string());
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
  TextReader reader(content.text(), path.string());
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

// The angles of theirs = R_X(gamma) R_Y(beta) R_Z(alpha).
std::array<double, 3> angles(const Matrix3& theirs) {
  const double beta = std::atan2(-theirs(0, 2), std::hypot(theirs(0, 0), theirs(0, 1)));
  const double alpha = std::atan2(theirs(0, 1), theirs(0, 0));
  // What is left is a rotation about x, however small cos(beta) is.
  const Matrix3 rest = theirs * about(2, alpha).transpose() * about(1, beta).transpose();
  return {alpha, beta, std::atan2(rest(1, 2), rest(1, 1))};
}

void require_one_plain_lens(const Problem& problem) {
  for (std::int64_t c = 0; c < problem.camera_count(); ++c) {
    const double* lens = problem.cameras.data() + Problem::camera_size * c + 6;
    if (lens[0] == problem.cameras[6] && lens[0] > 0 && lens[1] == 0 && lens[2] == 0) continue;
    throw InputError("problem", 0,
                     "camera " + std::to_string(c) + " with f " + std::to_string(lens[0]) +
                         ", k1 " + std::to_string(lens[1]) + ", k2 " + std::to_string(lens[2]),
                     "the same f > 0 everywhere and no distortion: ParallaxBA has one K for all");
  }
}

template <class Write>
void write_file(const fs::path& path, Write&& write) {
  AtomicFile file(path);
  TextWriter writer([&](std::string_view piece) { file.write(piece); });
  write(writer);
  writer.flush();
  file.commit();
}

void write_features(const Problem& problem, TextWriter& writer) {
  const ObservationRows rows(problem);
  for (std::int64_t i = 0; i < problem.point_count(); ++i) {
    const auto first = static_cast<std::size_t>(rows.begin[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::size_t>(rows.begin[static_cast<std::size_t>(i) + 1]);
    writer.number(last - first, ' ');
    for (std::size_t row = first; row < last; ++row) {
      const auto k = static_cast<std::size_t>(rows.observation[row]);
      writer.number(rows.camera[row], ' ');
      writer.number(problem.observations[2 * k], ' ');
      writer.number(-problem.observations[2 * k + 1], row + 1 < last ? ' ' : '\n');
    }
  }
}

}  // namespace

bool is_parallaxba(const fs::path& path) { return fs::is_directory(path); }

Problem read_parallaxba(const fs::path& folder) {
  const Calibration K = read_calibration(only_file(folder, {"cal", "intrinsic"}));
  Problem problem;
  problem.aspect = K.fy / K.fx;
  read_cameras(only_file(folder, {"Cam"}), K.fx, problem);
  read_features(only_file(folder, {"Feature"}), K, problem);
  linalg::ThreadPool pool(1);
  const Objective objective(problem, {.lens = Lens::fixed}, pool);
  objective.write(objective.state_from_rays(problem), problem);
  return problem;
}

Problem read_parallaxba_cameras(const fs::path& file) {
  Problem problem;
  read_cameras(file, 1, problem);
  return problem;
}

void write_parallaxba(const Problem& problem, const fs::path& folder) {
  validate(problem);
  require_one_plain_lens(problem);
  std::vector<bool> seen(static_cast<std::size_t>(problem.point_count()));
  for (const std::int32_t i : problem.observation_point) seen[static_cast<std::size_t>(i)] = true;
  const auto unseen = std::find(seen.begin(), seen.end(), false) - seen.begin();
  if (unseen < problem.point_count()) {
    throw InputError("problem", 0, "point " + std::to_string(unseen) + ", which nobody observes",
                     "an observation of every point: ParallaxBA has points by their observations");
  }
  fs::create_directories(folder);
  write_file(folder / "Cam.txt", [&](TextWriter& writer) {
    for (std::int64_t c = 0; c < problem.camera_count(); ++c) {
      const double* camera = problem.cameras.data() + Problem::camera_size * c;
      const Matrix3 R_cw = so3::exp(Vector3(Eigen::Map<const Vector3>(camera)));
      const Vector3 P = -(R_cw.transpose() * Eigen::Map<const Vector3>(camera + 3));
      for (const double angle : angles(flip.asDiagonal() * R_cw)) writer.number(angle, ' ');
      writer.number(P.x(), ' ');
      writer.number(P.y(), ' ');
      writer.number(P.z(), '\n');
    }
  });
  write_file(folder / "Feature.txt", [&](TextWriter& writer) { write_features(problem, writer); });
  write_file(folder / "cal.txt", [&](TextWriter& writer) {
    const double f = problem.cameras[6];
    const std::array<double, 9> K = {f, 0, 0, 0, problem.aspect * f, 0, 0, 0, 1};
    for (std::size_t i = 0; i < K.size(); ++i) writer.number(K[i], i % 3 == 2 ? '\n' : ' ');
  });
}

}  // namespace raybundle::io
