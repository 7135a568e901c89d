// raybundle convert, and what the other subcommands make of folders in ParallaxBA's format.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <raybundle/models/alignment.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/models/rays.h>
#include <raybundle/models/scenes/street.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tests/tools/process.h>

namespace raybundle::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::contains;
using test::read_text;
using test::Result;
using test::run;
using test::TemporaryFolder;
using test::Words;
using test::write_text;

class Folders : public testing::Test {
 protected:
  Folders() {
    io::write_bal(street_, bal_);
    Problem plain = with_one_focal_length(undistorted(street_));
    plain.aspect = 1.01;
    for (std::size_t k = 1; k < plain.observations.size(); k += 2) plain.observations[k] *= 1.01;
    io::write_parallaxba(plain, parallaxba_);
  }
  std::string path(const char* name) const { return (folder_ / name).string(); }
  json option(Words words, const char* name) const {
    words.insert(words.begin(), {"solve", "-q", "--max-iterations", "2", "--log", path("log")});
    const Result result = run(words);
    EXPECT_EQ(result.code, 0) << result.errors;
    return json::parse(read_text(path("log")))["options"][name];
  }
  void expect_refused(const Words& words, int code, const std::string& complaint) const {
    const Result result = run(words);
    EXPECT_EQ(result.code, code) << complaint << ": " << result.errors;
    EXPECT_TRUE(contains(result.errors, complaint)) << complaint << ": " << result.errors;
  }

  TemporaryFolder folder_;
  Problem street_ = scenes::street({.seed = 3, .cameras = 6, .points = 60});
  std::string bal_ = path("bal.txt");
  std::string parallaxba_ = path("parallaxba");
};

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

// The same cameras, and the same pixels once they are square and centred.
void expect_same(const Problem& a, const Problem& b) {
  EXPECT_EQ(a.observation_camera, b.observation_camera);
  EXPECT_EQ(a.observation_point, b.observation_point);
  EXPECT_LE(largest_difference(observed_rays(a), observed_rays(b)), 1e-14);
  EXPECT_LE(largest_difference(a.cameras, b.cameras), 1e-12);
}

TEST_F(Folders, ThereAndBackAllStays) {
  ASSERT_EQ(run({"convert", parallaxba_, path("there.txt")}).code, 0);
  ASSERT_EQ(run({"convert", path("there.txt"), path("back/")}).code, 0);
  const Problem before = io::read_parallaxba(parallaxba_);
  expect_same(io::read_bal(path("there.txt")), before);
  expect_same(io::read_parallaxba(path("back")), before);
  EXPECT_EQ(io::read_bal(path("there.txt")).points, before.points);
}

TEST_F(Folders, RealDataThereAndBack) {
  const fs::path pile = fs::path(RAYBUNDLE_DATA_DIR) / "parallaxba" / "fake-pile";
  if (!fs::exists(pile)) GTEST_SKIP() << "no data at " << pile;
  ASSERT_EQ(run({"convert", pile.string(), path("pile.txt")}).code, 0);
  ASSERT_EQ(run({"convert", path("pile.txt"), path("pile"), "--to", "parallaxba"}).code, 0);
  expect_same(io::read_parallaxba(path("pile")), io::read_parallaxba(pile));
}

TEST_F(Folders, TheFormatFollowsFromTheOutput) {
  const Result standard = run({"convert", parallaxba_, "-"});
  ASSERT_EQ(standard.code, 0) << standard.errors;
  EXPECT_EQ(io::parse_bal(standard.output, "output").camera_count(), 6);
  fs::create_directory(path("empty"));
  ASSERT_EQ(run({"convert", parallaxba_, path("empty")}).code, 0);
  EXPECT_TRUE(io::holds_parallaxba(path("empty")));
  EXPECT_EQ(run({"convert", "-", path("copy.txt")}, bal_).code, 0);
  EXPECT_EQ(read_text(path("copy.txt")), read_text(bal_));
}

TEST_F(Folders, LensesThatDifferNeedUndistort) {
  street_.cameras[6] *= 1.5;
  street_.cameras[7] = 0.01;
  io::write_bal(street_, bal_);
  expect_refused({"convert", bal_, path("new/")}, 3, "see --undistort");
  EXPECT_FALSE(fs::exists(path("new")));
  ASSERT_EQ(run({"convert", bal_, path("new/"), "--undistort"}).code, 0);
  const Problem folder = io::read_parallaxba(path("new"));
  EXPECT_EQ(io::lens_breach(folder), "");
  const double size = *std::max_element(street_.observations.begin(), street_.observations.end());
  ASSERT_EQ(run({"convert", bal_, path("plain.txt"), "--undistort"}).code, 0);
  const Problem plain = io::read_bal(path("plain.txt"));
  EXPECT_EQ(plain.cameras[6], street_.cameras[6]) << "BAL has room for every f";
  EXPECT_EQ(plain.cameras[7], 0);
  EXPECT_LE(largest_difference(observed_rays(plain), observed_rays(street_)), 1e-14 * size);
  expect_same(folder, with_one_focal_length(plain));
}

TEST_F(Folders, ConvertRefusesWhatWouldDestroyOrCannotBe) {
  expect_refused({"convert", bal_, bal_}, 2, "is the input");
  expect_refused({"convert", parallaxba_, parallaxba_ + "/"}, 2, "is the input");
  expect_refused({"convert", parallaxba_, parallaxba_ + "/Cam.txt"}, 2, "a part of the input");
  ASSERT_EQ(run({"convert", parallaxba_, path("other/")}).code, 0);
  expect_refused({"convert", parallaxba_, path("other")}, 2, "holds a problem already");
  expect_refused({"convert", parallaxba_, path("other"), "--to", "bal"}, 2, "is a folder");
  expect_refused({"convert", parallaxba_, bal_, "--to", "parallaxba"}, 2, "is a file");
  expect_refused({"convert", parallaxba_, "-", "--to", "parallaxba"}, 2, "standard output");
  expect_refused({"convert", parallaxba_, "x", "--to", "ply"}, 2, "none of bal, parallaxba");
  expect_refused({"convert", parallaxba_, "x", "--undistort"}, 2, "--undistort has no effect");
  expect_refused({"convert", parallaxba_, path("no/such/")}, 1, "cannot be written");
  expect_refused({"convert", path("none.txt"), path("x.txt")}, 3, "none.txt");
}

TEST_F(Folders, PointsStartFromTheirRaysUnlessToldOtherwise) {
  EXPECT_EQ(option({parallaxba_, "--points", "pmba"}, "point-start"), "rays");
  EXPECT_EQ(option({parallaxba_, "--point-start", "auto"}, "point-start"), "rays");
  EXPECT_EQ(option({parallaxba_, "--point-start", "problem"}, "point-start"), "problem");
  EXPECT_EQ(option({bal_}, "point-start"), "problem");
  EXPECT_EQ(option({bal_, "--point-start", "rays"}, "point-start"), "rays");
}

TEST_F(Folders, TheirLensStaysUnlessToldOtherwise) {
  EXPECT_EQ(option({parallaxba_}, "lens"), "fixed");
  EXPECT_EQ(option({parallaxba_, "--lens", "free"}, "lens"), "free");
  EXPECT_EQ(option({bal_}, "lens"), "free");
}

TEST_F(Folders, FiguresOfTheStartAreOfPointsFromRays) {
  std::fill(street_.points.begin(), street_.points.end(), 100.0);
  io::write_bal(street_, bal_);
  for (const char* points : {"xyz", "idp", "pba", "pmba"}) {
    const Result result = run({"solve", bal_, "-q", "--points", points, "--point-start", "rays",
                               "--max-iterations", "1", "--log", path("log")});
    ASSERT_EQ(result.code, 0) << result.errors;
    const json log = json::parse(read_text(path("log")));
    const double expected = log["iterations"][0]["cost"];
    EXPECT_NEAR(log["summary"]["initial_pixel_cost"].get<double>(), expected, 1e-9 * expected);
  }
}

TEST_F(Folders, WhatAFormatDoesNotHoldIsSaid) {
  EXPECT_TRUE(contains(run({"convert", bal_, path("a/"), "--undistort"}).errors, "has no points"));
  EXPECT_TRUE(contains(run({"convert", parallaxba_, path("b.txt")}).errors, "square pixels"));
  EXPECT_FALSE(contains(run({"convert", bal_, path("c.txt")}).errors, "square pixels"));
  const Words solve = {"solve", parallaxba_, "-q", "-o", path("d.txt"), "--log", path("log")};
  EXPECT_TRUE(contains(run(solve).errors, "square pixels"));
  EXPECT_EQ(json::parse(read_text(path("log")))["summary"]["warnings"].size(), 1U);
}

TEST_F(Folders, MistakesNameTheirFile) {
  street_.cameras[7] = -0.5;  // folds back at |p| = 0.816, where u = 0.544 f
  street_.observations[0] = 0.9 * street_.cameras[6];
  street_.observation_camera[0] = 0;
  io::write_bal(street_, bal_);
  expect_refused({"convert", bal_, path("x.txt"), "--undistort"}, 3, bal_ + ": found");
  expect_refused({"solve", bal_, "--objective", "ray"}, 3, bal_ + ": found");
  fs::copy(parallaxba_, path("two"));
  fs::remove(path("two/Cam.txt"));
  fs::remove(path("two/cal.txt"));
  expect_refused({"eval", path("two")}, 3, "0 files cal* or intrinsic*, 0 files Cam*");
  write_text(parallaxba_ + "/Feature.txt", "\x1F\x8B\x08 and so on");
  expect_refused({"eval", parallaxba_}, 3, "files of a folder are plain text");
}

TEST_F(Folders, ASolutionMayBeAFolder) {
  const Words solve = {"solve", "-q", parallaxba_, "-o", path("solved/")};
  Words free = solve;
  free.insert(free.end(), {"--lens", "free"});
  expect_refused(free, 2, "--lens fixed");
  expect_refused({"solve", "-q", bal_, "-o", path("solved/")}, 2, "raybundle convert");
  expect_refused({"solve", parallaxba_, "-o", parallaxba_ + "/Cam.txt"}, 2, "part of the input");
  const Result result = run(solve);
  ASSERT_EQ(result.code, 0) << result.errors;
  EXPECT_TRUE(contains(result.errors, "has no points")) << result.errors;
  const Problem solved = io::read_parallaxba(path("solved"));
  const Problem before = io::read_parallaxba(parallaxba_);
  EXPECT_EQ(solved.observations.size(), before.observations.size());
  EXPECT_GT(largest_difference(solved.cameras, before.cameras), 1e-3);
  expect_refused(solve, 2, "holds a problem already");
}

TEST_F(Folders, ATruthOfCamerasAlone) {
  const auto truth = [&](const Words& words) {
    Words all = {"eval", bal_, "--log", path("log"), "--truth"};
    all.insert(all.end(), words.begin(), words.end());
    const Result result = run(all);
    EXPECT_EQ(result.code, 0) << result.errors;
    EXPECT_FALSE(contains(result.output, "of points")) << result.output;
    return json::parse(read_text(path("log")))["truth"];
  };
  Problem other = street_;
  for (std::size_t c = 3; c < other.cameras.size(); c += 18) other.cameras[c] += 0.1;
  other = with_one_focal_length(undistorted(std::move(other)));
  io::write_parallaxba(other, path("truth"));
  const double expected = compare_with_truth(street_, other).camera_rmse;
  ASSERT_GT(expected, 1e-3);
  for (const std::string& name : {path("truth"), path("truth/Cam.txt")}) {
    const json found = truth({name, "--points-csv", path("points.csv")});
    EXPECT_NEAR(found["camera_rmse"].get<double>(), expected, 1e-9) << name;
    EXPECT_EQ(found["cameras"], 6);
    EXPECT_EQ(found["points"], 0);
    for (const char* key : {"point_rmse", "point_median", "point_scale", "point_median_own"}) {
      EXPECT_TRUE(found[key].is_null()) << key;
    }
    EXPECT_FALSE(contains(read_text(path("points.csv")), "error"));
  }
  EXPECT_EQ(run({"eval", parallaxba_, "--truth", path("truth/Cam.txt")}).code, 0);
}

TEST_F(Folders, ATruthThatIsNoneIsToldSo) {
  const auto refused = [&](const std::string& text, const std::string& complaint) {
    write_text(path("truth.txt"), text);
    expect_refused({"eval", bal_, "--truth", path("truth.txt")}, 3, complaint);
  };
  refused("0 0 0 0 0 0\n", "truth.txt: found 1 cameras, expected 6");
  refused("1 2 3 4\n", "found 4 words in the first line, expected the header of a BAL file");
  refused("", "found 0 words");
  refused("0 0 0 0 0 0\n0 0 0 nan 0 0\n", "truth.txt:2");
  refused("1 1 1\n", "a header that promises");
}

TEST_F(Folders, BenchTakesThem) {
  const Words words = {"bench",     parallaxba_ + "/:" + parallaxba_ + "/Cam.txt",
                       "--ceres",   "none",
                       "--runs",    "1",
                       "--common",  "--max-iterations 3",
                       "--variant", "chol=--method lm-cholesky",
                       "--best",    "parallaxba=1",
                       "-o",        path("out")};
  const Result first = run(words);
  ASSERT_EQ(first.code, 0) << first.errors;
  const json results = json::parse(read_text(path("out/results.json")));
  EXPECT_EQ(results["runs"][0]["problem"], "parallaxba");
  EXPECT_EQ(results["runs"][0]["status"], "ok");
  EXPECT_TRUE(results["runs"][0]["camera_rmse"].is_number());
  const json log = json::parse(read_text(path("out/runs/parallaxba/chol/1.json")));
  EXPECT_EQ(log["options"]["point-start"], "rays");
  EXPECT_TRUE(contains(run(words).errors, "1 run of an earlier call kept"));
  write_text(path("parallaxba/Cam.txt"), read_text(path("parallaxba/Cam.txt")) + " ");
  EXPECT_FALSE(contains(run(words).errors, "kept")) << "one of its files is another";
  Words with_ceres = words;
  with_ceres[3] = "/bin/true";
  expect_refused(with_ceres, 2, "which the Ceres driver does not read");
  fs::remove(path("parallaxba/cal.txt"));
  expect_refused(words, 3, "0 files cal* or intrinsic*");
}

}  // namespace
}  // namespace raybundle::tools
