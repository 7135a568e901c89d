#include <raybundle/models/io/epipolar_geometries.h>

#include <raybundle/models/io/file_content.h>
#include <raybundle/models/io/text_reader.h>

#include <Eigen/LU>

#include <limits>

namespace raybundle::io {
namespace {

std::int32_t read_image(TextReader& reader) {
  reader.skip_blanks();
  return reader.integer<std::int32_t>(0, std::numeric_limits<std::int32_t>::max(),
                                      [] { return "the number of an image"; });
}

double read_entry(TextReader& reader, const char* what) {
  reader.skip_blanks();
  return reader.number([&] { return std::string("a finite number, ") + what; });
}

EpipolarGeometry read_line(TextReader& reader) {
  EpipolarGeometry pair;
  pair.i = read_image(reader);
  pair.j = read_image(reader);
  if (pair.i == pair.j) {
    reader.fail("image " + std::to_string(pair.i) + " with itself", "two images");
  }
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) pair.R_ij(r, c) = read_entry(reader, "an entry of R");
  }
  // Six digits are what such files have.
  const double off = (pair.R_ij * pair.R_ij.transpose() - Eigen::Matrix3d::Identity()).norm();
  if (off > 1e-3 || pair.R_ij.determinant() < 0) {
    reader.fail("a matrix that is off a rotation by " + std::to_string(off), "a rotation");
  }
  for (int k = 0; k < 3; ++k) pair.t[k] = read_entry(reader, "an entry of t");
  reader.skip_blanks();
  if (!reader.at_line_end()) reader.fail("the end of the line after i, j, R and t");
  return pair;
}

}  // namespace

std::vector<EpipolarGeometry> parse_epipolar_geometries(std::string_view text,
                                                        const std::string& source) {
  TextReader reader(text, source);
  std::vector<EpipolarGeometry> result;
  for (reader.skip_space(); !reader.at_end(); reader.skip_space()) {
    result.push_back(read_line(reader));
  }
  return result;
}

std::vector<EpipolarGeometry> read_epipolar_geometries(const std::filesystem::path& path) {
  const FileContent content(path);
  return parse_epipolar_geometries(content.text(), path.string());
}

}  // namespace raybundle::io
