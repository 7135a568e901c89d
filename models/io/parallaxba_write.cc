#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/models/io/parallaxba_frame.h>
#include <raybundle/models/io/text_writer.h>
#include <raybundle/models/observation_rows.h>
#include <raybundle/models/rotation.h>

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace raybundle::io {
namespace {

namespace fs = std::filesystem;
using so3::Vector3;

void require_observed_points(const Problem& problem) {
  std::vector<bool> seen(static_cast<std::size_t>(problem.point_count()));
  for (const std::int32_t i : problem.observation_point) seen[static_cast<std::size_t>(i)] = true;
  const auto unseen = std::find(seen.begin(), seen.end(), false) - seen.begin();
  if (unseen == problem.point_count()) return;
  throw InputError("problem", 0, "point " + std::to_string(unseen) + ", which nobody observes",
                   "an observation of every point: ParallaxBA has points by their observations");
}

// The three files of a folder, all or none: they appear when all are complete, and what appeared
// vanishes when one cannot. Nothing that was there is touched.
class FolderWriter {
 public:
  explicit FolderWriter(const fs::path& folder) : folder_(folder) {
    if (holds_parallaxba(folder)) {
      throw std::system_error(std::make_error_code(std::errc::file_exists),
                              folder.string() + ": holds a problem already");
    }
    std::error_code error;
    const bool there = fs::is_directory(folder, error);
    if (!there) fs::create_directory(folder);
    made_ = !there;
  }
  ~FolderWriter() {
    if (complete_) return;
    files_.clear();
    std::error_code ignored;
    for (const fs::path& path : committed_) fs::remove(path, ignored);
    if (made_) fs::remove(folder_, ignored);
  }
  FolderWriter(const FolderWriter&) = delete;
  FolderWriter& operator=(const FolderWriter&) = delete;

  template <class Write>
  void add(const char* name, Write&& write) {
    const fs::path path = folder_ / name;
    files_.emplace_back(path, std::make_unique<AtomicFile>(path));
    TextWriter writer([&](std::string_view piece) { files_.back().second->write(piece); });
    write(writer);
    writer.flush();
  }
  void commit() {
    for (auto& [path, file] : files_) {
      file->commit();
      committed_.push_back(path);
    }
    complete_ = true;
  }

 private:
  fs::path folder_;
  bool made_ = false, complete_ = false;
  std::vector<std::pair<fs::path, std::unique_ptr<AtomicFile>>> files_;
  std::vector<fs::path> committed_;
};

void write_cameras(const Problem& problem, TextWriter& writer) {
  for (std::int64_t c = 0; c < problem.camera_count(); ++c) {
    const double* camera = problem.cameras.data() + Problem::camera_size * c;
    const so3::Matrix3 R_cw = so3::exp(Vector3(Eigen::Map<const Vector3>(camera)));
    const Vector3 P = -(R_cw.transpose() * Eigen::Map<const Vector3>(camera + 3));
    for (const double angle : parallaxba_angles(R_cw)) writer.number(angle, ' ');
    writer.number(P.x(), ' ');
    writer.number(P.y(), ' ');
    writer.number(P.z(), '\n');
  }
}

void write_calibration(const Problem& problem, TextWriter& writer) {
  const double f = problem.cameras[6];
  const std::array<double, 9> K = {f, 0, 0, 0, problem.aspect * f, 0, 0, 0, 1};
  for (std::size_t i = 0; i < K.size(); ++i) writer.number(K[i], i % 3 == 2 ? '\n' : ' ');
}

void write_features(const Problem& problem, TextWriter& writer) {
  linalg::ThreadPool alone(1);
  const ObservationRows rows(problem, alone);
  for (std::int64_t i = 0; i < problem.point_count(); ++i) {
    const auto first = static_cast<std::size_t>(rows.begin[static_cast<std::size_t>(i)]);
    const auto last = static_cast<std::size_t>(rows.begin[static_cast<std::size_t>(i) + 1]);
    writer.number(last - first, ' ');
    for (std::size_t row = first; row < last; ++row) {
      const auto k = static_cast<std::size_t>(rows.observation_of(static_cast<std::int64_t>(row)));
      writer.number(rows.camera[row], ' ');
      writer.number(problem.observations[2 * k], ' ');
      writer.number(-problem.observations[2 * k + 1], row + 1 < last ? ' ' : '\n');
    }
  }
}

}  // namespace

std::string lens_breach(const Problem& problem) {
  for (std::int64_t c = 0; c < problem.camera_count(); ++c) {
    const double* lens = problem.cameras.data() + Problem::camera_size * c + 6;
    if (lens[0] == problem.cameras[6] && lens[0] > 0 && lens[1] == 0 && lens[2] == 0) continue;
    std::ostringstream text;
    text << "camera " << c << " with f " << lens[0] << ", k1 " << lens[1] << ", k2 " << lens[2];
    return text.str();
  }
  return "";
}

void write_parallaxba(const Problem& problem, const fs::path& folder) {
  validate(problem);
  if (const std::string breach = lens_breach(problem); !breach.empty()) {
    throw InputError("problem", 0, breach,
                     "the same f > 0 everywhere and no distortion: ParallaxBA has one K for all");
  }
  require_observed_points(problem);
  FolderWriter writer(folder);
  writer.add("Cam.txt", [&](TextWriter& text) { write_cameras(problem, text); });
  writer.add("Feature.txt", [&](TextWriter& text) { write_features(problem, text); });
  writer.add("cal.txt", [&](TextWriter& text) { write_calibration(problem, text); });
  writer.commit();
}

}  // namespace raybundle::io
