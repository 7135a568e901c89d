#pragma once

#include <raybundle/models/problem.h>

#include <filesystem>
#include <string>
#include <string_view>

/// Problems in the format of ParallaxBA [Zhao15]: a folder with
///   Cam*.txt              a line "alpha beta gamma tx ty tz" per camera: R = R_X(gamma) R_Y(beta)
///                         R_Z(alpha) from world to camera, t the camera's centre
///   Feature*              a line per point: the number n of its observations, then n times
///                         "camera u v", cameras from 0, pixels from the image's corner
///   cal*.txt, intrinsic*  the matrix K of all cameras, 3 x 3
/// Its cameras look along +z with y down: (x, y, z) there is (x, -y, -z) here, and an observation
/// (u - c_x, c_y - v). There are no points, and no distortion.
namespace raybundle::io {

/// Whether it is a folder, and therefore to be read as one of these.
bool is_parallaxba(const std::filesystem::path& path);

/// Whether its name begins like one of these files.
bool is_parallaxba_file(const std::filesystem::path& file);

/// Whether such a file is in the folder; false where there is none.
bool holds_parallaxba(const std::filesystem::path& folder);

/// What a problem is read from. Throws InputError when one is missing or there are several.
struct ParallaxBaFiles {
  std::filesystem::path calibration, cameras, features;
};
ParallaxBaFiles parallaxba_files(const std::filesystem::path& folder);

/// Reads such a folder; points are placed by the two of their rays with the best parallax. Throws
/// InputError (file, line, found, expected), also when a file is missing or there are several.
Problem read_parallaxba(const std::filesystem::path& folder);

/// Cameras alone, of a file like Cam*.txt; their lenses have f = 1. Throws InputError.
Problem read_parallaxba_cameras(const std::filesystem::path& file);
/// The same from memory; `source` names the text in errors.
Problem parse_parallaxba_cameras(std::string_view text, const std::string& source);

/// The first camera whose lens the format has no place for, in words: its f is not that of camera
/// 0, or not above 0, or it distorts. Empty where there is none.
std::string lens_breach(const Problem& problem);

/// Writes Cam.txt, Feature.txt and cal.txt into the folder, all or none; it is made if need be,
/// and one that holds such files already is refused. The image's centre is put at (0, 0). Points
/// are not part of the format, nor is what is fixed. Throws InputError for a problem that is not
/// valid, whose lenses differ or distort, or with a point that nobody observes; std::system_error
/// (naming the file) on failure.
void write_parallaxba(const Problem& problem, const std::filesystem::path& folder);

}  // namespace raybundle::io
