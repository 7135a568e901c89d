#include <raybundle/models/pose.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <raybundle/models/rotation.h>
#include <raybundle/tests/support/random_problem.h>

namespace raybundle {
namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using Pose = std::array<double, 6>;

constexpr double pi = 3.14159265358979323846;
constexpr std::array updates = {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3};

Vector3d rotation_vector(const Pose& pose) { return {pose[0], pose[1], pose[2]}; }
Vector3d translation(const Pose& pose) { return {pose[3], pose[4], pose[5]}; }

Matrix4d motion(const Pose& pose) {
  Matrix4d T = Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = so3::exp(rotation_vector(pose));
  T.topRightCorner<3, 1>() = translation(pose);
  return T;
}

// The exponential of a twist by scaling and squaring of its series: no formula of SO(3) in it.
Matrix4d exp_twist(const Pose& twist) {
  Matrix4d X = Matrix4d::Zero();
  X.topLeftCorner<3, 3>() = so3::hat(rotation_vector(twist));
  X.topRightCorner<3, 1>() = translation(twist);
  X /= 1024;
  Matrix4d sum = Matrix4d::Identity(), term = Matrix4d::Identity();
  for (int k = 1; k < 20; ++k) {
    term = term * X / k;
    sum += term;
  }
  for (int k = 0; k < 10; ++k) sum = sum * sum;
  return sum;
}

Pose moved(PoseUpdate update, const Pose& pose, const Pose& step) {
  Pose next;
  next.fill(1e300);
  retract_pose(update, pose.data(), step.data(), next.data());
  return next;
}

// Poses with angles near 0, ordinary, near pi and beyond.
std::vector<Pose> poses() {
  std::mt19937_64 random(1);
  std::vector<Pose> list;
  for (const double angle : {0.0, 1e-12, 1e-6, 0.3, 2.0, pi - 1e-7, pi, pi + 1e-7, 5.0}) {
    for (int k = 0; k < 3; ++k) {
      Vector3d axis;
      for (double& x : axis) x = test::uniform(random);
      const Vector3d phi = angle * axis.normalized();
      list.push_back({phi.x(), phi.y(), phi.z(), 4 * test::uniform(random),
                      4 * test::uniform(random), 4 * test::uniform(random)});
    }
  }
  return list;
}

Pose random_step(std::mt19937_64& random, double scale) {
  Pose step;
  for (double& x : step) x = scale * test::uniform(random);
  return step;
}

TEST(Pose, GlobalAddsNumbers) {
  std::mt19937_64 random(2);
  for (const Pose& pose : poses()) {
    const Pose step = random_step(random, 0.5);
    const Pose next = moved(PoseUpdate::global, pose, step);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(next[i], pose[i] + step[i]);
  }
}

TEST(Pose, LocalComposesOnTheRight) {
  std::mt19937_64 random(3);
  for (const Pose& pose : poses()) {
    const Pose step = random_step(random, 0.5);
    const Matrix4d T = motion(moved(PoseUpdate::local, pose, step));
    const Matrix3d R = so3::exp(rotation_vector(pose));
    const Matrix3d expected = R * so3::exp(rotation_vector(step));
    EXPECT_LE((T.topLeftCorner<3, 3>() - expected).norm(), 1e-14);
    const Vector3d t = translation(pose) + R * translation(step);
    EXPECT_LE((T.topRightCorner<3, 1>() - t).norm(), 1e-14 * (1 + t.norm()));
  }
}

TEST(Pose, Se3ComposesTheTwistOnTheLeft) {
  std::mt19937_64 random(4);
  for (const Pose& pose : poses()) {
    for (const double scale : {1e-9, 1e-3, 0.5, 2.0}) {
      const Pose step = random_step(random, scale);
      const Matrix4d T = motion(moved(PoseUpdate::se3, pose, step));
      EXPECT_LE((T - exp_twist(step) * motion(pose)).norm(), 1e-13 * (1 + T.norm()));
    }
  }
}

TEST(Pose, ZeroStepsStay) {
  for (const PoseUpdate update : updates) {
    for (const Pose& pose : poses()) {
      EXPECT_LE((motion(moved(update, pose, Pose{})) - motion(pose)).norm(), 1e-14 * 10);
    }
  }
}

TEST(Pose, MayBeMovedInPlace) {
  std::mt19937_64 random(5);
  for (const PoseUpdate update : updates) {
    for (const Pose& pose : poses()) {
      const Pose step = random_step(random, 0.7);
      Pose in_place = pose;
      retract_pose(update, in_place.data(), step.data(), in_place.data());
      EXPECT_EQ(in_place, moved(update, pose, step));
    }
  }
}

// A solve may run for long: the rotation vector must not wind up.
TEST(Pose, LocalAndSe3KeepTheRotationVectorShort) {
  std::mt19937_64 random(6);
  for (const PoseUpdate update : {PoseUpdate::local, PoseUpdate::se3}) {
    Pose pose = {0.1, 0.2, 0.3, 1, 2, 3};
    for (int k = 0; k < 200; ++k) {
      pose = moved(update, pose, random_step(random, 1.0));
      EXPECT_LE(rotation_vector(pose).norm(), pi * (1 + 1e-15));
    }
  }
}

}  // namespace
}  // namespace raybundle
