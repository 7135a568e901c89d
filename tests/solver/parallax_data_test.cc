// Anchored points on real data, against what the authors' ParallaxBA reaches on the same files.

#include <raybundle/solver/solve.h>

#include <filesystem>

#include <gtest/gtest.h>

#include <raybundle/models/io/parallaxba.h>

namespace raybundle {
namespace {

class FakePile : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = std::filesystem::path(RAYBUNDLE_DATA_DIR) / "parallaxba" / "fake-pile";
    if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no data at " << folder;
    problem_ = io::read_parallaxba(folder);
  }
  // Mean squared error per observation, pixels^2, as ParallaxBA prints it.
  double error(double pixel_cost) const {
    return 2 * pixel_cost / static_cast<double>(problem_.observation_count());
  }

  Problem problem_;
};

TEST_F(FakePile, PbaReachesTheErrorOfItsAuthors) {
  const Summary summary = solve(problem_, {.lens = Lens::fixed,
                                           .points = PointModel::pba,
                                           .point_start = PointStart::rays,
                                           .max_iterations = 60,
                                           .function_tolerance = 1e-9});
  EXPECT_EQ(outcome(summary.termination), Outcome::converged);
  EXPECT_NEAR(error(summary.final_cost), 0.01321183, 1e-7);
}

TEST_F(FakePile, PmbaWithDoglegOnRaysIsThereInEightIterations) {
  const Summary summary = solve(problem_, {.method = Method::dogleg,
                                           .points = PointModel::pmba,
                                           .point_start = PointStart::rays,
                                           .objective = ObjectiveKind::ray,
                                           .max_iterations = 8,
                                           .function_tolerance = 1e-9});
  EXPECT_LE(error(summary.iterations.back().pixel_cost), 0.01322);
  EXPECT_EQ(summary.regularised, 0);
}

}  // namespace
}  // namespace raybundle
