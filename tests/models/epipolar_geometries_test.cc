// Relative poses of image pairs as text: what is read, and what is refused, where.

#include <raybundle/models/io/epipolar_geometries.h>

#include <string>

#include <gtest/gtest.h>
#include <Eigen/LU>

#include <raybundle/models/error.h>

namespace raybundle::io {
namespace {

constexpr const char* pair = "663 7 0 -1 0 1 0 0 0 0 1 0.6 0 -0.8";

TEST(EpipolarGeometries, AreReadLineByLine) {
  const auto found = parse_epipolar_geometries(std::string(pair) + "\n\n" + pair + "\r\n", "EGs");
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[1].i, 663);
  EXPECT_EQ(found[1].j, 7);
  EXPECT_EQ(found[1].R_ij(0, 1), -1);
  EXPECT_EQ(found[1].t, Eigen::Vector3d(0.6, 0, -0.8));
  EXPECT_TRUE(parse_epipolar_geometries("", "EGs").empty());
}

void expect_refused(const std::string& line, const std::string& complaint) {
  try {
    parse_epipolar_geometries(std::string(pair) + "\n" + line, "EGs");
    ADD_FAILURE() << complaint;
  } catch (const InputError& error) {
    EXPECT_EQ(error.line(), 2) << error.what();
    EXPECT_NE(std::string(error.what()).find(complaint), std::string::npos) << error.what();
  }
}

TEST(EpipolarGeometries, SayWhatIsWrong) {
  expect_refused("-1 7 0 -1 0 1 0 0 0 0 1 0 0 1", "number of an image");
  expect_refused("7 7 0 -1 0 1 0 0 0 0 1 0 0 1", "two images");
  expect_refused("1 7 0 -1 0 1 0 0 0 0 1 0 0", "an entry of t");
  expect_refused("1 7 0 -1 0 1 0 0 0 0 1 0 0 1 4", "end of the line");
  expect_refused("1 7 0 1 0 1 0 0 0 0 1 0 0 1", "a rotation");
  expect_refused("1 7 0 -1 0 1 0 0 0 0 1.1 0 0 1", "a rotation");
  expect_refused("1 7 0 -1 0 nan 0 0 0 0 1 0 0 1", "an entry of R");
}

TEST(EpipolarGeometries, NameAFileThatIsNotThere) {
  EXPECT_THROW(read_epipolar_geometries("/nowhere/EGs.txt"), InputError);
}

}  // namespace
}  // namespace raybundle::io
