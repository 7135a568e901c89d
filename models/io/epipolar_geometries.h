#pragma once

#include <Eigen/Core>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

/// Relative poses of image pairs as the data sets of 1DSfM have them, EGs.txt [Wilson14]: a line
/// "i j R t" per pair, R row by row, with R = R_i R_j^T for rotations R_i from world to camera i,
/// and t the direction from the centre of i to that of j in the frame of i.
namespace raybundle::io {

struct EpipolarGeometry {
  std::int32_t i = 0, j = 0;
  Eigen::Matrix3d R_ij;
  Eigen::Vector3d t;
};

/// Throws InputError (file, line, found, expected), also for a matrix that is no rotation.
std::vector<EpipolarGeometry> read_epipolar_geometries(const std::filesystem::path& path);

/// The same from memory; `source` names the text in errors.
std::vector<EpipolarGeometry> parse_epipolar_geometries(std::string_view text,
                                                        const std::string& source);

}  // namespace raybundle::io
