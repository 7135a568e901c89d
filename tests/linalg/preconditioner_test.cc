// What the preconditioners apply, and that the conjugate gradients converge with each.

#include <raybundle/linalg/preconditioner.h>

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/linalg/pcg.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

// The five of [Qu18, 3.3.5] on a real reduced system: what each applies, and that it helps.
class Preconditioners : public ::testing::TestWithParam<std::optional<Side>> {
 protected:
  Preconditioners()
      : system_({.seed = 51, .hubs = 12, .leaves = 80, .duplicates = 3, .hub_column_spread = 2}),
        reduced_(make_reduced_system(system_.layout, GetParam(), pool_)) {
    reduced_->prepare(system_.linearization(pool_), system_.D.data());
    SymmetricBlocks matrix(reduced_->pattern(), SymmetricBlocks::Storage::sparse);
    v_.resize(reduced_->size());
    reduced_->assemble(matrix, v_.data());
    A_ = test::dense_of(matrix);
    const std::int64_t at = reduced_->offset(), size = reduced_->size();
    kept_ = system_.H().block(at, at, size, size);
  }

  // The dense matrix whose inverse the preconditioner should apply.
  MatrixXd expected(Preconditioner::Form form, const MatrixXd& from) const {
    if (form == Preconditioner::Form::identity) return MatrixXd::Identity(from.rows(), from.cols());
    if (form == Preconditioner::Form::diagonal) return from.diagonal().asDiagonal();
    MatrixXd blocks = MatrixXd::Zero(from.rows(), from.cols());
    const SymmetricPattern pattern = reduced_->pattern();
    for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
      const std::int64_t o = pattern.offset[index(a)], n = pattern.block_size(a);
      blocks.block(o, o, n, n) = from.block(o, o, n, n);
    }
    return blocks;
  }

  ThreadPool pool_{2};
  BlockSystem system_;
  std::unique_ptr<ReducedSystem> reduced_;
  MatrixXd A_;
  MatrixXd kept_;
  VectorXd v_;
};

TEST_P(Preconditioners, ApplyTheInverseAndPcgConvergesWithEach) {
  using Form = Preconditioner::Form;
  const VectorXd solution = A_.ldlt().solve(v_);
  Preconditioner preconditioner;
  for (const bool reduced : {false, true}) {
    for (const Form form : {Form::identity, Form::diagonal, Form::blocks}) {
      DiagonalBlocks blocks;
      VectorXd v(v_.size());
      if (reduced) {
        reduced_->reduced_diagonal(blocks, v.data());
      } else {
        reduced_->diagonal_blocks(blocks);
      }
      preconditioner.build(form, blocks, pool_);
      const MatrixXd N = expected(form, reduced ? A_ : kept_);
      VectorXd z = VectorXd::Constant(v_.size(), 1e300);
      preconditioner.apply(v_.data(), z.data(), v_.size(), pool_);
      const VectorXd exact = N.ldlt().solve(v_);
      EXPECT_LE((z - exact).norm(), 1e-9 * exact.norm());

      Pcg pcg(v_.size(), pool_);
      VectorXd x(v_.size());
      const auto result = pcg.solve(
          [&](const double* in, double* out) { reduced_->apply(in, out); },
          [&](const double* in, double* out) { preconditioner.apply(in, out, v_.size(), pool_); },
          v_.data(), {.residual = 1e-12 * v_.norm(), .max_iterations = 20000}, x.data());
      EXPECT_LE((A_ * x - v_).norm(), 1e-10 * v_.norm());
      if (form != Form::identity) {
        const VectorXd s = A_.diagonal().cwiseSqrt();
        EXPECT_LE((x - solution).cwiseProduct(s).norm(), 1e-8 * solution.cwiseProduct(s).norm());
      }
      EXPECT_LT(result.iterations, 20000);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Eliminated, Preconditioners,
                         ::testing::Values(std::optional<Side>(), std::optional<Side>(Side::leaves),
                                           std::optional<Side>(Side::hubs)),
                         [](const auto& test) {
                           if (!test.param) return "Nothing";
                           return *test.param == Side::leaves ? "Leaves" : "Hubs";
                         });

TEST(Preconditioner, IndefiniteAndEmptyEntriesAct) {
  DiagonalBlocks blocks;
  blocks.runs.push_back({3, 2, {4, 0, 0, 0, 0, 0, 0, 0, 1, /**/ 2, 1, 0, 1, 2, 0, 0, 0, nan}});
  ThreadPool pool(1);
  const VectorXd r = VectorXd::Ones(6);
  VectorXd z(6);
  Preconditioner preconditioner;
  preconditioner.build(Preconditioner::Form::diagonal, blocks, pool);
  preconditioner.apply(r.data(), z.data(), 6, pool);
  EXPECT_TRUE(z.isApprox((VectorXd(6) << 0.25, 0, 1, 0.5, 0.5, 0).finished()));
  preconditioner.build(Preconditioner::Form::blocks, blocks, pool);
  preconditioner.apply(r.data(), z.data(), 6, pool);
  EXPECT_TRUE(z.isApprox((VectorXd(6) << 0.25, 0, 1, 0, 0, 0).finished())) << z.transpose();
}

}  // namespace
}  // namespace raybundle::linalg
