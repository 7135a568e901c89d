#include <raybundle/models/scenes/noise.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/sphere.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/models/scene_hash.h>

namespace raybundle::scenes {
namespace {

using test::hash;

TEST(SceneGeometry, TrigonometryMatchesTheCLibrary) {
  for (double x = -7; x <= 7; x += 0.013) {
    EXPECT_NEAR(sine(x), std::sin(x), 4e-15);
    EXPECT_NEAR(cosine(x), std::cos(x), 4e-15);
    const double s = std::abs(std::sin(x));
    EXPECT_NEAR(arctangent(s, std::cos(x)), std::atan2(s, std::cos(x)), 4e-15);
  }
}

TEST(SceneGeometry, RotationVectorsAndMatricesAreInverses) {
  Random random(5);
  for (int k = 0; k < 2000; ++k) {
    const double angle = k % 5 == 0   ? pi - 1e-6 * (k + 1)
                         : k % 7 == 0 ? 1e-9 * k
                                      : random.uniform(0, pi);
    const Vec3 phi = scaled(angle, direction_in_cone(random, pi));
    const Vec3 back = rotation_vector(rotation_matrix(phi));
    EXPECT_LT(norm(difference(back, phi)), 1e-13 + 1e-14 / (pi - angle + 1e-3));
  }
  EXPECT_EQ(norm(rotation_vector(rotation_matrix({0, 0, 0}))), 0);
}

TEST(SceneGeometry, AxesAreRightHandedAndOrthonormal) {
  Random random(6);
  for (int k = 0; k < 500; ++k) {
    const Vec3 z = k == 0 ? Vec3{0, 1, 0} : direction_in_cone(random, pi);
    const Mat3 axes = axes_about(z, random.uniform(-pi, pi));
    EXPECT_NEAR(dot(axes.x, axes.y), 0, 1e-14);
    EXPECT_NEAR(norm(axes.x), 1, 1e-14);
    EXPECT_LT(norm(difference(cross(axes.x, axes.y), z)), 1e-13);
  }
}

TEST(Noise, IsPinned) {
  const NoisyProblem noisy = add_noise(sphere_scene(), {.seed = 2, .outlier_share = 0.1});
  EXPECT_EQ(hash(noisy.problem), 0x2EA883715B223961U);
  EXPECT_EQ(hash(perturb(noisy.problem, {.seed = 3})), 0x22B37EEC65840D36U);
}

TEST(Noise, HasTheDeviationAskedFor) {
  const Scene scene = sphere_scene({.cameras = 40, .points = 2000});
  for (const double noise : {0.0, 0.5, 4.0}) {
    const Problem noisy = add_noise(scene, {.pixel_noise = noise}).problem;
    const double count = 2.0 * static_cast<double>(noisy.observation_count());
    const double rmse = reprojection_statistics(noisy).rmse / std::sqrt(2.0);
    EXPECT_NEAR(rmse, noise, 4 * noise / std::sqrt(2 * count) + 1e-9);
    EXPECT_EQ(noisy.cameras, scene.truth.cameras);
    EXPECT_EQ(noisy.points, scene.truth.points);
  }
}

TEST(Noise, OutliersAreThoseReportedAndFillTheImage) {
  const Scene scene = sphere_scene({.cameras = 40, .points = 2000});
  const NoisyProblem noisy = add_noise(scene, {.pixel_noise = 0, .outlier_share = 0.1});
  const double count = static_cast<double>(scene.truth.observation_count());
  ASSERT_EQ(noisy.outliers.size(), static_cast<std::size_t>(std::lround(0.1 * count)));
  EXPECT_TRUE(std::is_sorted(noisy.outliers.begin(), noisy.outliers.end()));
  std::size_t next = 0;
  double mean_square = 0;
  for (std::size_t k = 0; k < scene.truth.observation_camera.size(); ++k) {
    const bool same = noisy.problem.observations[2 * k] == scene.truth.observations[2 * k];
    const bool reported =
        next < noisy.outliers.size() && static_cast<std::size_t>(noisy.outliers[next]) == k;
    ASSERT_EQ(same, !reported) << "observation " << k;
    if (!reported) continue;
    ++next;
    const double x = noisy.problem.observations[2 * k] / scene.image_width;
    const double y = noisy.problem.observations[2 * k + 1] / scene.image_height;
    ASSERT_LE(std::max(std::abs(x), std::abs(y)), 0.5);
    mean_square += (x * x + y * y) / 2;
  }
  mean_square /= static_cast<double>(noisy.outliers.size());
  EXPECT_NEAR(mean_square, 1.0 / 12, 0.003);  // of a uniform number between -1/2 and 1/2
}

TEST(Noise, SeedsDiffer) {
  const Scene scene = sphere_scene();
  EXPECT_NE(hash(add_noise(scene, {.seed = 1}).problem),
            hash(add_noise(scene, {.seed = 2}).problem));
  EXPECT_NE(hash(perturb(scene.truth, {.seed = 1})), hash(perturb(scene.truth, {.seed = 2})));
  EXPECT_EQ(hash(perturb(scene.truth, {.seed = 1})), hash(perturb(scene.truth, {.seed = 1})));
}

TEST(Start, IsOffByTheDeviationsAskedFor) {
  const Problem truth = sphere_scene({.cameras = 400, .points = 3000}).truth;
  const Problem start =
      perturb(truth, {.rotation = 0.02, .position = 0.0, .focal = 0.01, .point = 0.05});
  double rotation = 0, focal = 0;
  for (std::int64_t j = 0; j < 400; ++j) {
    const Camera a = camera_of(truth, j), b = camera_of(start, j);
    const Vec3 d = difference(a.phi, b.phi);
    rotation += dot(d, d) / 1200;
    focal += (b.f / a.f - 1) * (b.f / a.f - 1) / 400;
    EXPECT_LT(norm(difference(a.centre, b.centre)), 1e-9);
    EXPECT_EQ(b.k1, 0);
    EXPECT_EQ(b.k2, 0);
  }
  EXPECT_NEAR(std::sqrt(rotation), 0.02, 4 * 0.02 / std::sqrt(2400));
  EXPECT_NEAR(std::sqrt(focal), 0.01, 0.002);
  double squares = 0;  // the nearest depth of a point is between 0.4 and 1 radius of the ball
  for (std::int64_t i = 0; i < 3000; ++i) {
    const Vec3 d = difference(point_of(truth, i), point_of(start, i));
    squares += dot(d, d) / 9000;
  }
  EXPECT_GT(std::sqrt(squares), 0.05 * 0.4 * 500);
  EXPECT_LT(std::sqrt(squares), 0.05 * 1.0 * 500);
}

TEST(Start, IsTheSameShareWhateverTheUnits) {
  // A scene a thousand times as large starts as badly, in pixels.
  Problem truth = sphere_scene().truth;
  const double small = reprojection_statistics(perturb(truth)).rmse;
  for (double& x : truth.points) x *= 1000;
  for (std::size_t j = 0; j < truth.cameras.size(); j += 9) {
    for (std::size_t k = 3; k < 6; ++k) truth.cameras[j + k] *= 1000;
  }
  EXPECT_NEAR(reprojection_statistics(perturb(truth)).rmse, small, 1e-9);
}

TEST(Start, OfZeroDeviationIsTheTruthWithoutDistortion) {
  Problem truth = sphere_scene().truth;
  const Problem start = perturb(truth, {.rotation = 0, .position = 0, .focal = 0, .point = 0});
  for (std::size_t j = 0; j < truth.cameras.size(); ++j) {
    if (j % 9 >= 7) truth.cameras[j] = 0;
    EXPECT_NEAR(start.cameras[j], truth.cameras[j], 1e-12 * (1 + std::abs(truth.cameras[j])));
  }
  EXPECT_EQ(start.points, truth.points);
  EXPECT_EQ(start.observations, truth.observations);
}

TEST(Noise, RefusesWhatIsNoDeviation) {
  const Scene scene = sphere_scene();
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_THROW(add_noise(scene, {.pixel_noise = bad}), InputError);
    EXPECT_THROW(add_noise(scene, {.outlier_share = bad}), InputError);
    EXPECT_THROW(perturb(scene.truth, {.rotation = bad}), InputError);
    EXPECT_THROW(perturb(scene.truth, {.position = bad}), InputError);
    EXPECT_THROW(perturb(scene.truth, {.focal = bad}), InputError);
    EXPECT_THROW(perturb(scene.truth, {.point = bad}), InputError);
  }
  EXPECT_THROW(add_noise(scene, {.outlier_share = 1.1}), InputError);
}

}  // namespace
}  // namespace raybundle::scenes
