// The motions of cameras that change nothing: to first order, no observation moves.

#include <raybundle/models/camera_modes.h>

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/QR>

#include <raybundle/tests/support/dense_objective.h>
#include <raybundle/tests/support/small_problem.h>

namespace raybundle {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr PoseUpdate updates[] = {PoseUpdate::global, PoseUpdate::local, PoseUpdate::se3};

// What is left of J_c times the modes when the points follow as well as they can.
TEST(CameraModes, OfASimilarityLeaveTheObservationsToThePoints) {
  const Problem problem = test::small_problem({.seed = 6, .cameras = 5, .points = 30});
  for (const PoseUpdate update : updates) {
    for (const Lens lens : {Lens::free, Lens::fixed}) {
      test::DenseObjective at(problem, update, lens);
      const int unknowns = lens == Lens::free ? 9 : 6;
      RowMajor modes(5 * unknowns, unknowns + 1);
      camera_modes(update, problem.cameras, unknowns, modes.data());
      const MatrixXd J = at.jacobian();
      const MatrixXd J_c = J.leftCols(5 * unknowns);
      const MatrixXd J_p = J.rightCols(J.cols() - 5 * unknowns);
      const MatrixXd moved = J_c * modes;
      const MatrixXd rest = moved - J_p * J_p.colPivHouseholderQr().solve(moved);
      for (int k = 0; k < modes.cols(); ++k) {
        const double share = rest.col(k).norm() / moved.col(k).norm();
        if (k < 7) {
          EXPECT_LE(share, 1e-8) << "update " << static_cast<int>(update) << ", mode " << k;
        } else {
          EXPECT_GT(share, 1e-4) << "a lens is seen";
        }
      }
      EXPECT_EQ(Eigen::ColPivHouseholderQR<MatrixXd>(modes).rank(), modes.cols());
    }
  }
}

}  // namespace
}  // namespace raybundle
