#include <raybundle/solver/damping.h>

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace raybundle {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

double after(double rho) {
  Damping damping(1.0, 0.0);
  damping.update(rho);
  return damping.mu();
}

// [Qu18, Alg. 6], worked by hand: mu max(1/3, 1 - (2 rho - 1)^3).
TEST(Damping, FollowsTheTable) {
  EXPECT_DOUBLE_EQ(after(1.0), 1.0 / 3);
  EXPECT_DOUBLE_EQ(after(0.95), 1.0 / 3);
  EXPECT_DOUBLE_EQ(after(0.9), 1 - 0.8 * 0.8 * 0.8);
  EXPECT_DOUBLE_EQ(after(0.75), 0.875);
  EXPECT_DOUBLE_EQ(after(0.5), 1.0) << "neither good nor bad";
  EXPECT_DOUBLE_EQ(after(0.25), 1.125);
  EXPECT_NEAR(after(1e-9), 2.0, 1e-7) << "accepted, but the model was poor";
  EXPECT_DOUBLE_EQ(after(3.0), 1.0 / 3) << "never shrinks faster";
  EXPECT_DOUBLE_EQ(after(inf), 1.0 / 3);
  EXPECT_DOUBLE_EQ(after(0.0), 2.0);
  EXPECT_DOUBLE_EQ(after(-4.0), 2.0);
  EXPECT_DOUBLE_EQ(after(-inf), 2.0);
  EXPECT_DOUBLE_EQ(after(nan), 2.0) << "a step that could not be judged is a failure";
}

TEST(Damping, FailuresInARowGrowFaster) {
  Damping damping(1.0, 0.0);
  double expected = 1;
  for (const double factor : {2.0, 4.0, 8.0, 16.0}) {
    damping.update(-1);
    expected *= factor;
    EXPECT_DOUBLE_EQ(damping.mu(), expected);
  }
  damping.update(0.5);  // success: mu stays, and the next failure starts with 2 again
  EXPECT_DOUBLE_EQ(damping.mu(), expected);
  damping.update(nan);
  EXPECT_DOUBLE_EQ(damping.mu(), 2 * expected);
}

TEST(Damping, StaysAboveItsFloor) {
  Damping damping(1.0, 0.2);
  damping.update(1);
  EXPECT_DOUBLE_EQ(damping.mu(), 1.0 / 3);
  damping.update(1);
  EXPECT_DOUBLE_EQ(damping.mu(), 0.2);
  damping.update(1);
  EXPECT_DOUBLE_EQ(damping.mu(), 0.2);
  EXPECT_DOUBLE_EQ(Damping(0.01, 0.2).mu(), 0.2) << "at the start as well";
}

// A failed factorisation must raise the damping, whatever it was; from zero, doubling does not.
TEST(Damping, FailuresRaiseItFromZero) {
  Damping damping(0.0, 0.0);
  damping.update(-1);
  EXPECT_GT(damping.mu(), 0);
}

}  // namespace
}  // namespace raybundle
