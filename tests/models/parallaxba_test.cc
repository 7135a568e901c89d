// Folders in ParallaxBA's format: what is read, what is refused, and the way there and back.

#include <raybundle/models/io/parallaxba.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/error.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/rotation.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/support/small_problem.h>
#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

// Two cameras a unit apart along x, looking along +z at three points.
void write_example(const fs::path& folder) {
  write(folder / "cal1.txt", "1000 0 320\n0 900 240\n0 0 1\n");
  write(folder / "Cam2.txt", "0 0 0 0 0 0\n0 0 0 1 0 0\n");
  // (0, 0, 10), (1, 1, 5) and (0.5, -1, 10)
  write(folder / "Feature.txt",
        "2 0 320 240 1 220 240\n2 0 520 420 1 320 420\n2 1 270 150 0 370 150\n");
}

TEST(ParallaxBa, IsReadInOurConventions) {
  const test::TemporaryFolder folder;
  write_example(folder.path());
  ASSERT_TRUE(io::is_parallaxba(folder.path()));
  const Problem problem = io::read_parallaxba(folder.path());
  EXPECT_EQ(problem.camera_count(), 2);
  EXPECT_EQ(problem.point_count(), 3);
  EXPECT_DOUBLE_EQ(problem.aspect, 0.9);
  EXPECT_EQ(problem.cameras[6], 1000);
  // y and z point the other way here; every point is met exactly.
  const ReprojectionStatistics statistics = reprojection_statistics(problem);
  EXPECT_LE(statistics.largest, 1e-9);
  EXPECT_EQ(statistics.behind_camera, 0);
  const Vector3d second(&problem.points[3]);
  EXPECT_LE((second - Vector3d(1, 1, 5)).norm(), 1e-9) << "the world keeps its axes";
}

TEST(ParallaxBa, AnglesAreThoseOfTheFormat) {
  const test::TemporaryFolder folder;
  write_example(folder.path());
  write(folder.path() / "Cam2.txt", "0.3 0 0 0 0 0\n0 0.2 0 1 0 0\n");
  const Problem problem = io::read_parallaxba(folder.path());
  // R_Z(0.3): a vector along x turns towards -y; R_Y(0.2): one along x turns towards +z. Then
  // y and z are flipped.
  const Vector3d first = so3::exp(Vector3d(&problem.cameras[0])) * Vector3d::UnitX();
  EXPECT_LE((first - Vector3d(std::cos(0.3), std::sin(0.3), 0)).norm(), 1e-14);
  const Vector3d other = so3::exp(Vector3d(&problem.cameras[9])) * Vector3d::UnitX();
  EXPECT_LE((other - Vector3d(std::cos(0.2), 0, -std::sin(0.2))).norm(), 1e-14);
}

TEST(ParallaxBa, WhatIsWrittenIsReadAgain) {
  Problem problem = test::small_problem({.seed = 5, .cameras = 6, .points = 40});
  for (std::size_t c = 0; c < problem.cameras.size(); c += 9) {
    problem.cameras[c + 6] = 500;
    problem.cameras[c + 7] = problem.cameras[c + 8] = 0;
  }
  problem.aspect = 1.25;
  const test::TemporaryFolder folder;
  io::write_parallaxba(problem, folder.path() / "written");
  const Problem again = io::read_parallaxba(folder.path() / "written");
  EXPECT_EQ(again.observation_camera, problem.observation_camera);
  EXPECT_EQ(again.observation_point, problem.observation_point);
  EXPECT_EQ(again.observations, problem.observations);
  EXPECT_DOUBLE_EQ(again.aspect, problem.aspect);
  for (std::size_t c = 0; c < problem.cameras.size(); c += 9) {
    const Eigen::Matrix3d R = so3::exp(Vector3d(&problem.cameras[c]));
    EXPECT_LE((so3::exp(Vector3d(&again.cameras[c])) - R).norm(), 1e-13);
    const Vector3d t(&problem.cameras[c + 3]), t_again(&again.cameras[c + 3]);
    EXPECT_LE((t - t_again).norm(), 1e-12 * t.norm());
  }
}

// BAL knows square pixels only: the geometry stays, y is measured anew.
TEST(ParallaxBa, AsBalItIsMetAsWell) {
  const test::TemporaryFolder folder;
  write_example(folder.path());
  const Problem problem = io::read_parallaxba(folder.path());
  io::write_bal(problem, folder.path() / "bal.txt");
  EXPECT_LE(reprojection_statistics(io::read_bal(folder.path() / "bal.txt")).largest, 1e-9);
}

TEST(ParallaxBa, RefusesWhatItCannotHold) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(io::write_parallaxba(test::small_problem(), folder / "new"), InputError)
      << "lenses that differ and distort";
  EXPECT_FALSE(fs::exists(folder / "new"));
  write_example(folder.path());
  Problem problem = io::read_parallaxba(folder.path());
  EXPECT_EQ(io::lens_breach(problem), "");
  problem.points.insert(problem.points.end(), 3, 1.0);
  EXPECT_THROW(io::write_parallaxba(problem, folder / "new"), InputError) << "a point unobserved";
  problem.points.resize(9);
  problem.cameras[9 + 7] = 0.5;
  EXPECT_NE(io::lens_breach(problem).find("camera 1 with f 1000"), std::string::npos);
}

TEST(ParallaxBa, IsWrittenWholeOrNotAtAll) {
  const test::TemporaryFolder folder;
  write_example(folder.path());
  const Problem problem = io::read_parallaxba(folder.path());
  EXPECT_THROW(io::write_parallaxba(problem, folder.path()), std::system_error)
      << "a second Cam* would make it unreadable";
  EXPECT_EQ(folder.entry_count(), 3);
  EXPECT_THROW(io::write_parallaxba(problem, folder / "no" / "such"), std::system_error);
  EXPECT_THROW(io::write_parallaxba(problem, folder / "cal1.txt"), std::system_error);
  fs::create_directory(folder / "notes");
  write(folder / "notes" / "readme", "mine");
  io::write_parallaxba(problem, folder / "notes");
  EXPECT_EQ(io::read_parallaxba(folder / "notes").observation_point, problem.observation_point);
  EXPECT_TRUE(fs::exists(folder / "notes" / "readme")) << "other files stay";
}

TEST(ParallaxBa, ErrorsNameFileAndLine) {
  const auto message = [](const std::string& file, const std::string& text) -> std::string {
    const test::TemporaryFolder folder;
    write_example(folder.path());
    write(folder.path() / file, text);
    try {
      static_cast<void>(io::read_parallaxba(folder.path()));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("Feature.txt", "2 0 320 240 1 220 240\n2 0 520 420 7 320 420\n")
                .find("Feature.txt:2"),
            std::string::npos);
  EXPECT_NE(message("Feature.txt", "2 0 320 240\n").find("Feature.txt:1"), std::string::npos);
  EXPECT_NE(message("Cam2.txt", "0 0 0 0 0 0\n0 0 0 nan 0 0\n").find("Cam2.txt:2"),
            std::string::npos);
  EXPECT_NE(message("cal1.txt", "1000 1 320 0 900 240 0 0 1\n").find("cal1.txt"),
            std::string::npos);
  EXPECT_NE(message("Cam3.txt", "0 0 0 0 0 0\n").find("2 files Cam*"), std::string::npos);
}

// The figure that the format's own program prints for its start differs, for it chooses other
// anchors; what it ends with is in tests/solver.
TEST(ParallaxBa, RealFolders) {
  const fs::path data = fs::path(RAYBUNDLE_DATA_DIR) / "parallaxba";
  if (!fs::exists(data)) GTEST_SKIP() << "no data at " << data;
  const Problem malaga = io::read_parallaxba(data / "Malaga");
  EXPECT_EQ(malaga.camera_count(), 170);
  EXPECT_EQ(malaga.point_count(), 58404);
  EXPECT_EQ(malaga.observation_count(), 167285);
  const Problem pile = io::read_parallaxba(data / "fake-pile");
  EXPECT_EQ(pile.camera_count(), 47);
  EXPECT_EQ(pile.point_count(), 11318);
  EXPECT_EQ(pile.observation_count(), 26050);
  EXPECT_TRUE(std::isfinite(reprojection_statistics(pile).cost));
}

}  // namespace
}  // namespace raybundle
