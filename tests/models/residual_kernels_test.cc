// The kernels of the Objective evaluate rows many at a time. A row must not notice: it has the same
// bits in every lane and in every range, whatever its neighbours are.

#include <raybundle/models/residual_kernels.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <raybundle/models/rotation.h>
#include <raybundle/tests/support/random_problem.h>

namespace raybundle {
namespace {

using Eigen::Vector3d;
using test::uniform;

constexpr std::int64_t rows = 45;
constexpr std::int64_t longest = 17;  // of the ranges: two vectors of the widest, and one row
constexpr double untouched = -7.25;

Vector3d random_vector(std::mt19937_64& random) {
  const double x = uniform(random), y = uniform(random);
  return {x, y, uniform(random)};
}

CameraFrame random_camera(std::mt19937_64& random) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  CameraFrame camera = {};
  const Vector3d phi = 0.3 * random_vector(random);
  const Vector3d t = Vector3d(0, 0, -5) + random_vector(random);
  Eigen::Map<RowMajor>(camera.R_cw) = so3::exp(phi);
  Eigen::Map<RowMajor>(camera.J_r) = so3::right_jacobian(phi);
  Eigen::Map<Vector3d>(camera.t_cw) = t;
  Eigen::Map<Vector3d>(camera.P) = -so3::exp(phi).transpose() * t;
  camera.lens[0] = 500 + 100 * uniform(random);
  camera.lens[1] = 0.1 * uniform(random);
  camera.lens[2] = 0.01 * uniform(random);
  camera.aspect = 1.25;
  return camera;
}

// Tracks of one to eight rows, each from another camera.
struct Rows {
  Rows(PointModel points_model, Sensor of) : model(points_model), sensor(of) {
    std::mt19937_64 random(11);
    for (int j = 0; j < 12; ++j) cameras.push_back(random_camera(random));
    while (static_cast<std::int64_t>(row_point.size()) < rows) add_point(random);
    row_point.resize(rows);
    row_camera.resize(rows);
    for (std::int64_t i = 0; i < rows; ++i) {
      Vector3d seen = 0.3 * random_vector(random) - Vector3d::UnitZ();
      seen.normalize();
      if (residual_size(sensor) == 2) seen *= 300;
      observed.insert(observed.end(), seen.data(), seen.data() + residual_size(sensor));
    }
  }

  ResidualInput input() const {
    return {cameras.data(),  points.data(), row_camera.data(), row_point.data(),
            observed.data(), model,         anchors.data(),    first_anchor.data()};
  }

  PointModel model;
  Sensor sensor;
  std::vector<CameraFrame> cameras;
  std::vector<double> points, observed;
  std::vector<std::int32_t> row_camera, row_point;
  std::vector<Anchors> anchors;
  std::vector<std::int64_t> first_anchor = {0};

 private:
  void add_point(std::mt19937_64& random) {
    const auto track = static_cast<std::int32_t>(1 + random() % 8);
    const auto point = static_cast<std::int32_t>(anchors.size());
    for (std::int32_t k = 0; k < track; ++k) {
      row_point.push_back(point);
      row_camera.push_back(k + point % 4);
    }
    const bool pair = track > 1 && model != PointModel::idp;
    anchors.push_back({point % 4, pair ? point % 4 + track - 1 : -1});
    first_anchor.push_back(first_anchor.back() + (pair ? 2 : 1));
    Vector3d stored = random_vector(random);
    if (stored_size(model) == 4) stored = (0.3 * stored - Vector3d::UnitZ()).normalized();
    points.insert(points.end(), stored.data(), stored.data() + 3);
    if (stored_size(model) == 4) points.push_back(0.2 + 0.05 * uniform(random));
  }
};

// What the kernels write about all rows.
struct Written {
  explicit Written(const Rows& of) : R(residual_size(of.sensor)), K(camera_unknowns(of.sensor)) {
    residual.assign(std::size_t(rows * R), untouched);
    J_hub.assign(std::size_t(rows * R * K), untouched);
    J_leaf.assign(std::size_t(rows * R * 3), untouched);
    Z.assign(std::size_t(of.first_anchor.back() * 3 * K), untouched);
  }
  ResidualOutput output() { return {residual.data(), J_hub.data(), J_leaf.data(), Z.data()}; }

  int R, K;
  std::vector<double> residual, J_hub, J_leaf, Z;
};

// Those of `all` in blocks [first, last) of `size` numbers, untouched ones elsewhere.
std::vector<double> part(const std::vector<double>& all, std::int64_t first, std::int64_t last,
                         std::int64_t size) {
  std::vector<double> result(all.size(), untouched);
  std::copy(all.begin() + first * size, all.begin() + last * size, result.begin() + first * size);
  return result;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

using Variant = std::tuple<PointModel, PoseUpdate, Sensor>;

class ObjectiveRows : public ::testing::TestWithParam<Variant> {
 protected:
  const ResidualKernels& kernels() const {
    return residual_kernels(is_anchored(of_.model), std::get<1>(GetParam()), of_.sensor);
  }
  Written linearized(std::int64_t first, std::int64_t last) {
    Written written(of_);
    cost_ = kernels().linearize(of_.input(), written.output(), first, last);
    return written;
  }
  // The anchors of points whose first row is in a range come first to last.
  std::int64_t anchor_before(std::int64_t row) const {
    std::int64_t point = 0;
    while (point < std::int64_t(of_.anchors.size()) &&
           std::lower_bound(of_.row_point.begin(), of_.row_point.end(), point) -
                   of_.row_point.begin() <
               row) {
      ++point;
    }
    return of_.first_anchor[std::size_t(point)];
  }

  Rows of_{std::get<0>(GetParam()), std::get<2>(GetParam())};
  double cost_ = 0;
};

TEST_P(ObjectiveRows, AreTheSameBitsInEveryLaneAndRange) {
  const Written all = linearized(0, rows);
  for (const std::vector<double>& each : {all.residual, all.J_hub, all.J_leaf}) {
    EXPECT_TRUE(std::all_of(each.begin(), each.end(),
                            [](double x) { return std::isfinite(x) && x != untouched; }));
  }
  const int R = all.R, K = all.K;
  for (std::int64_t size = 1; size <= longest; ++size) {
    for (std::int64_t first = 0; first + size <= rows; ++first) {
      const std::int64_t last = first + size;
      const Written some = linearized(first, last);
      ASSERT_TRUE(same_bits(some.residual, part(all.residual, first, last, R)));
      ASSERT_TRUE(same_bits(some.J_hub, part(all.J_hub, first, last, R * K)));
      ASSERT_TRUE(same_bits(some.J_leaf, part(all.J_leaf, first, last, R * 3)));
      if (is_anchored(of_.model)) {
        ASSERT_TRUE(
            same_bits(some.Z, part(all.Z, anchor_before(first), anchor_before(last), 3 * K)));
      }
    }
  }
}

TEST_P(ObjectiveRows, ResidualsAndCostsOfRangesAgreeWithThem) {
  const Written all = linearized(0, rows);
  const int R = all.R;
  for (std::int64_t size = 1; size <= longest; ++size) {
    for (std::int64_t first = 0; first + size <= rows; ++first) {
      std::vector<double> residual(std::size_t(size * R + 1), untouched);
      kernels().residuals(of_.input(), residual.data(), first, first + size);
      double expected = 0;
      for (std::int64_t i = 0; i < size * R; ++i) {
        const double r = all.residual[std::size_t(first * R + i)];
        expected += 0.5 * r * r;
        ASSERT_NEAR(residual[std::size_t(i)], r, 1e-12 * (std::abs(r) + 1));
      }
      ASSERT_EQ(residual.back(), untouched);
      linearized(first, first + size);
      ASSERT_NEAR(cost_, expected, 1e-14 * expected);
      ASSERT_NEAR(kernels().cost(of_.input(), first, first + size), expected, 1e-12 * expected);
    }
  }
}

TEST_P(ObjectiveRows, ThatCannotBeProjectedSpoilNoOthers) {
  const Written good = linearized(0, rows);
  constexpr std::int32_t spoilt = 3;
  const std::size_t size = std::size_t(stored_size(of_.model));
  std::fill_n(of_.points.begin() + std::ptrdiff_t(spoilt * size), size, std::nan(""));
  const Written all = linearized(0, rows);
  EXPECT_FALSE(std::isfinite(cost_));
  EXPECT_FALSE(std::isfinite(kernels().cost(of_.input(), 0, rows)));
  const std::size_t R = std::size_t(all.R), K = std::size_t(all.K);
  for (std::size_t row = 0; row < rows; ++row) {
    const bool finite = of_.row_point[row] != spoilt;
    const auto same = [&](const std::vector<double>& a, const std::vector<double>& b,
                          std::size_t numbers) {
      return std::memcmp(&a[row * numbers], &b[row * numbers], 8 * numbers) == 0;
    };
    EXPECT_EQ(std::isfinite(all.residual[row * R]), finite) << "row " << row;
    EXPECT_EQ(same(all.residual, good.residual, R), finite);
    EXPECT_EQ(same(all.J_hub, good.J_hub, R * K), finite);
    EXPECT_EQ(same(all.J_leaf, good.J_leaf, R * 3), finite);
  }
}

std::string name_of(const ::testing::TestParamInfo<Variant>& info) {
  constexpr const char* models[] = {"Xyz", "Idp", "Pba", "Pmba"};
  constexpr const char* updates[] = {"Global", "Local", "Se3"};
  constexpr const char* names[] = {"PixelAndLens", "Pixel", "Ray", "PixelRay"};
  return std::string(models[int(std::get<0>(info.param))]) + updates[int(std::get<1>(info.param))] +
         names[int(std::get<2>(info.param))];
}

INSTANTIATE_TEST_SUITE_P(Variants, ObjectiveRows,
                         ::testing::Combine(::testing::Values(PointModel::xyz, PointModel::idp,
                                                              PointModel::pba, PointModel::pmba),
                                            ::testing::Values(PoseUpdate::global, PoseUpdate::local,
                                                              PoseUpdate::se3),
                                            ::testing::Values(Sensor::pixel_and_lens, Sensor::pixel,
                                                              Sensor::ray, Sensor::pixel_ray)),
                         name_of);

}  // namespace
}  // namespace raybundle
