// Derivatives of all parameterisations and objectives at a thousand random states each, those
// included where a parameterisation is nearly singular.

#include <raybundle/models/objective.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include <raybundle/models/random.h>
#include <raybundle/models/rotation.h>
#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/numeric_jacobian.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::DenseObjective;

Vector3d direction(Random& random) {
  const Vector3d x(random.normal(), random.normal(), random.normal());
  return x.norm() > 1e-3 ? Vector3d(x.normalized()) : Vector3d::UnitX();
}

enum class Place { anywhere, far, collinear, near_an_anchor, above };
constexpr std::array places = {Place::anywhere, Place::far, Place::collinear, Place::near_an_anchor,
                               Place::above};

double magnitude(Random& random, double low, double high) {
  return std::pow(10.0, random.uniform(low, high));
}

// A point seen from the first of two cameras, a unit vector apart.
Vector3d place_point(Place place, const Vector3d& baseline, Random& random) {
  const Vector3d w = direction(random);
  switch (place) {
    case Place::far:
      return magnitude(random, 3, 8) * w;
    case Place::collinear: {
      const double side = random.uniform(0, 1) < 0.5 ? -1 : 1;
      return side * magnitude(random, 0, 2) * (baseline + magnitude(random, -4, -1) * w);
    }
    case Place::near_an_anchor:
      return magnitude(random, -4, -1) * w;
    case Place::above:  // where the azimuth of pba means nothing
      return magnitude(random, 0, 1) * (Vector3d::UnitY() + magnitude(random, -4, -1) * w);
    case Place::anywhere:
      break;
  }
  return magnitude(random, 0, 1) * w;
}

// Three cameras in any attitude, the first two a unit apart, and a point; half of all views are of
// a point behind the camera. No view is so oblique that nothing could be computed in pixels.
Problem random_state(Place place, Random& random) {
  const Vector3d first = 3 * direction(random), baseline = direction(random);
  const Vector3d X = first + place_point(place, baseline, random);
  Problem problem;
  problem.points = {X[0], X[1], X[2]};
  for (const Vector3d& P :
       {first, Vector3d(first + baseline), Vector3d(first + 0.5 * direction(random))}) {
    Vector3d phi, X_c;
    do {
      phi = 3 * random.uniform(0, 1) * direction(random);
      X_c = so3::exp(phi) * (X - P);
    } while (std::abs(X_c.z()) < 0.4 * X_c.norm());
    const Vector3d t = -(so3::exp(phi) * P);
    problem.cameras.insert(problem.cameras.end(), {phi[0], phi[1], phi[2], t[0], t[1], t[2]});
    problem.cameras.insert(problem.cameras.end(), {1, 0.01, -0.002});
    problem.observation_camera.push_back(
        static_cast<std::int32_t>(problem.observation_camera.size()));
    problem.observation_point.push_back(0);
    problem.observations.insert(problem.observations.end(),
                                {random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5)});
  }
  return problem;
}

// The disagreement of the worst column, relative to its length. How far one may go for a
// difference depends on the state, from the distance of a far point down to the last digits of
// an angle: each column counts with the stride that fits it best.
double disagreement(const Problem& problem, const Formulation& formulation) {
  DenseObjective dense(problem, formulation, 1);
  const MatrixXd analytic = dense.jacobian();
  const auto residual = [&](const VectorXd& step) { return dense.residual_after(step); };
  VectorXd best = VectorXd::Constant(analytic.cols(), std::numeric_limits<double>::infinity());
  for (const double scale : {1e-3, 1e-1, 1e1, 1e2, 1e4, 1e7}) {
    const MatrixXd numeric =
        test::numeric_jacobian(residual, VectorXd::Zero(analytic.cols()), scale);
    for (Eigen::Index i = 0; i < best.size(); ++i) {
      const double off = (analytic.col(i) - numeric.col(i)).norm();
      if (off < best[i]) best[i] = off;  // never a NaN
    }
  }
  double worst = 0;
  for (Eigen::Index i = 0; i < best.size(); ++i) {
    worst = std::max(worst, best[i] / (analytic.col(i).norm() + 1e-10));
  }
  return worst;
}

class StatesOf : public testing::TestWithParam<std::tuple<PointModel, ObjectiveKind>> {};

TEST_P(StatesOf, DerivativesAgreeWithDifferences) {
  const auto [points, objective] = GetParam();
  const Formulation formulation = {.lens = Lens::fixed, .points = points, .objective = objective};
  Random random(11);
  for (const Place place : places) {
    double worst = 0;
    for (int state = 0; state < 200; ++state) {
      worst = std::max(worst, disagreement(random_state(place, random), formulation));
    }
    EXPECT_LE(worst, 3e-5) << "place " << static_cast<int>(place);
  }
}

std::string name_of(const testing::TestParamInfo<StatesOf::ParamType>& each) {
  constexpr std::array models = {"Xyz", "Idp", "Pba", "Pmba"};
  const bool ray = std::get<1>(each.param) == ObjectiveKind::ray;
  return std::string(models[static_cast<std::size_t>(std::get<0>(each.param))]) +
         (ray ? "Ray" : "Pixel");
}

INSTANTIATE_TEST_SUITE_P(All, StatesOf,
                         testing::Combine(testing::Values(PointModel::xyz, PointModel::idp,
                                                          PointModel::pba, PointModel::pmba),
                                          testing::Values(ObjectiveKind::pixel,
                                                          ObjectiveKind::ray)),
                         name_of);

}  // namespace
}  // namespace raybundle
