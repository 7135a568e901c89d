// The full system and both Schur complements [Qu18, Eq. 3.61-3.73] against dense matrices.

#include <raybundle/linalg/reduced_system.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;
using test::BlockSystemOptions;
using Storage = SymmetricBlocks::Storage;

// What elimination gives, densely.
struct Oracle {
  Oracle(const BlockSystem& system, std::optional<Side> eliminated) {
    const MatrixXd H = system.H();
    const VectorXd g = system.gradient();
    step = -H.ldlt().solve(g);
    if (!eliminated) {
      A = kept = H;
      v = g;
      return;
    }
    const BlockLayout& layout = system.layout;
    const Side k = opposite(*eliminated);
    const std::int64_t at_k = layout.offset(k), at_e = layout.offset(*eliminated);
    const std::int64_t size_k = layout.size(k), size_e = layout.size(*eliminated);
    kept = H.block(at_k, at_k, size_k, size_k);
    const MatrixXd E = H.block(at_k, at_e, size_k, size_e);
    const Eigen::LDLT<MatrixXd> ldlt(H.block(at_e, at_e, size_e, size_e));
    A = kept - E * ldlt.solve(MatrixXd(E.transpose()));
    v = g.segment(at_k, size_k) - E * ldlt.solve(VectorXd(g.segment(at_e, size_e)));
  }
  MatrixXd A;
  MatrixXd kept;  // H + D on the kept side
  VectorXd v;
  VectorXd step;
};

using Parameter = std::tuple<BlockSystemOptions, std::optional<Side>>;

class ReducedSystems : public ::testing::TestWithParam<Parameter> {
 protected:
  ReducedSystems()
      : system_(std::get<0>(GetParam())),
        eliminated_(std::get<1>(GetParam())),
        oracle_(system_, eliminated_),
        reduced_(make_reduced_system(system_.layout, eliminated_, pool_)) {
    reduced_->prepare(system_.linearization(pool_), system_.D.data());
  }

  double A_error(const MatrixXd& A) const { return (A - oracle_.A).norm() / oracle_.kept.norm(); }

  ThreadPool pool_{2};
  BlockSystem system_;
  std::optional<Side> eliminated_;
  Oracle oracle_;
  std::unique_ptr<ReducedSystem> reduced_;
};

constexpr double tolerance = 1e-12;

TEST_P(ReducedSystems, SizeAndOffset) {
  EXPECT_EQ(reduced_->size(), oracle_.v.size());
  const bool behind = eliminated_ && *eliminated_ == Side::hubs;
  EXPECT_EQ(reduced_->offset(), behind ? system_.layout.size(Side::hubs) : 0);
}

TEST_P(ReducedSystems, Gradient) {
  VectorXd v = VectorXd::Constant(reduced_->size(), 1e300);
  reduced_->gradient(v.data());
  EXPECT_LE((v - oracle_.v).norm(), tolerance * system_.gradient().norm());
}

TEST_P(ReducedSystems, ApplyIsTheMatrix) {
  std::mt19937_64 random(5);
  const VectorXd x = VectorXd::NullaryExpr(reduced_->size(), [&] { return test::uniform(random); });
  VectorXd y = VectorXd::Constant(x.size(), 1e300);
  for (int repetition = 0; repetition < 2; ++repetition) {  // scratch of the first does not linger
    reduced_->apply(x.data(), y.data());
    EXPECT_LE((y - oracle_.A * x).norm(), tolerance * oracle_.kept.norm() * x.norm());
  }
}

TEST_P(ReducedSystems, AssembleInBothStorages) {
  for (const Storage storage : {Storage::dense, Storage::sparse}) {
    SymmetricBlocks A(reduced_->pattern(), storage);
    // What a factorisation leaves behind must not shine through.
    std::fill_n(A.values(),
                storage == Storage::dense ? A.pattern().order() * A.pattern().order()
                                          : A.pattern().scalar_nonzeros(),
                1e300);
    VectorXd v = VectorXd::Constant(reduced_->size(), 1e300);
    reduced_->assemble(A, v.data());
    EXPECT_LE(A_error(test::dense_of(A)), tolerance);
    EXPECT_LE((v - oracle_.v).norm(), tolerance * system_.gradient().norm());
    if (storage != Storage::dense) continue;
    // A dense factorisation reads the whole triangle, pattern or not.
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    const MatrixXd whole = Eigen::Map<RowMajor>(A.values(), v.size(), v.size());
    EXPECT_LE(A_error(whole.selfadjointView<Eigen::Upper>()), tolerance);
  }
}

TEST_P(ReducedSystems, PatternHoldsEveryNonzeroAndIsSorted) {
  const SymmetricPattern pattern = reduced_->pattern();
  ASSERT_EQ(pattern.order(), reduced_->size());
  MatrixXd covered = MatrixXd::Zero(pattern.order(), pattern.order());
  std::int64_t numbers = 0;
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    const std::int64_t begin = pattern.row_begin[index(a)], end = pattern.row_begin[index(a + 1)];
    ASSERT_LT(begin, end);
    EXPECT_EQ(pattern.column[index(begin)], a) << "the diagonal block comes first";
    for (std::int64_t p = begin; p < end; ++p) {
      const std::int32_t b = pattern.column[index(p)];
      EXPECT_GT(b, p > begin ? pattern.column[index(p - 1)] : -1) << "columns ascend";
      covered
          .block(pattern.offset[index(a)], pattern.offset[index(b)], pattern.block_size(a),
                 pattern.block_size(b))
          .setOnes();
      numbers += pattern.block_size(a) * pattern.block_size(b);
    }
  }
  EXPECT_EQ(pattern.scalar_nonzeros(), numbers);
  const MatrixXd upper = oracle_.A.triangularView<Eigen::Upper>();
  EXPECT_EQ((upper.array() * (1 - covered.array())).abs().maxCoeff(), 0.0);
}

TEST_P(ReducedSystems, ExpandGivesTheStepOfTheFullSystem) {
  const VectorXd x = -oracle_.A.ldlt().solve(oracle_.v);
  VectorXd step = VectorXd::Constant(system_.layout.unknowns(), 1e300);
  reduced_->expand(x.data(), step.data());
  EXPECT_LE((step - oracle_.step).norm(), 1e-9 * oracle_.step.norm());
}

// Whatever x is, the eliminated part minimises the model for it: its gradient vanishes there.
TEST_P(ReducedSystems, ExpandIsOptimalForAnyX) {
  if (!eliminated_) return;
  std::mt19937_64 random(6);
  const VectorXd x = VectorXd::NullaryExpr(reduced_->size(), [&] { return test::uniform(random); });
  VectorXd step(system_.layout.unknowns());
  const double squares = reduced_->expand(x.data(), step.data());
  EXPECT_NEAR(squares, (system_.dense * step).squaredNorm(), 1e-10 * squares);
  EXPECT_TRUE(step.segment(reduced_->offset(), reduced_->size()) == x);
  const VectorXd model_gradient = system_.H() * step + system_.gradient();
  const VectorXd rest = model_gradient.segment(system_.layout.offset(*eliminated_),
                                               system_.layout.size(*eliminated_));
  EXPECT_LE(rest.norm(), 1e-11 * (system_.H() * step).norm());
}

TEST_P(ReducedSystems, DiagonalBlocks) {
  for (const bool reduced : {false, true}) {
    DiagonalBlocks blocks;
    VectorXd v(reduced_->size());
    for (int time = 0; time < 2; ++time) {  // buffers are reused between iterations
      if (reduced) {
        reduced_->reduced_diagonal(blocks, v.data());
        EXPECT_LE((v - oracle_.v).norm(), tolerance * system_.gradient().norm());
      } else {
        reduced_->diagonal_blocks(blocks);
      }
    }
    const MatrixXd& expected = reduced ? oracle_.A : oracle_.kept;
    std::int64_t at = 0;
    for (const auto& run : blocks.runs) {
      for (std::int64_t b = 0; b < run.count; ++b, at += run.size) {
        const Eigen::Map<const MatrixXd> block(run.values.data() + b * run.size * run.size,
                                               run.size, run.size);
        EXPECT_LE((block - expected.block(at, at, run.size, run.size)).norm(),
                  tolerance * oracle_.kept.norm());
      }
    }
    EXPECT_EQ(at, reduced_->size());
  }
}

// A second linearisation and damping must leave nothing of the first behind.
TEST_P(ReducedSystems, PrepareAgain) {
  SymmetricBlocks A(reduced_->pattern(), Storage::sparse);
  VectorXd v(reduced_->size());
  reduced_->assemble(A, v.data());
  system_.D *= 10;
  system_.r *= 2;
  const Oracle again(system_, eliminated_);
  reduced_->prepare(system_.linearization(pool_), system_.D.data());
  reduced_->assemble(A, v.data());
  EXPECT_LE((test::dense_of(A) - again.A).norm(), tolerance * again.kept.norm());
  EXPECT_LE((v - again.v).norm(), tolerance * system_.gradient().norm());
}

TEST_P(ReducedSystems, SameBitsForAnyNumberOfThreads) {
  std::vector<VectorXd> results;
  for (const int threads : {1, 2, 5}) {
    ThreadPool pool(threads);
    const auto reduced = make_reduced_system(system_.layout, eliminated_, pool);
    reduced->prepare(system_.linearization(pool), system_.D.data());
    SymmetricBlocks A(reduced->pattern(), Storage::sparse);
    const std::int64_t numbers = A.pattern().scalar_nonzeros();
    VectorXd v(reduced->size()), y(reduced->size()), step(system_.layout.unknowns());
    reduced->assemble(A, v.data());
    reduced->apply(v.data(), y.data());
    const double squares = reduced->expand(y.data(), step.data());
    VectorXd all(numbers + y.size() + step.size() + 1);
    all << Eigen::Map<VectorXd>(A.values(), numbers), y, step, squares;
    results.push_back(all);
  }
  EXPECT_TRUE(results[0] == results[1]);
  EXPECT_TRUE(results[0] == results[2]);
}

// Enough leaves for the one-pass product to be cut into pieces.
TEST(ReducedSystemOfManyLeaves, PiecesMakeTheSameProductForAnyNumberOfThreads) {
  for (const bool anchored : {false, true}) {
    BlockSystem system({.seed = 8, .anchored = anchored, .leaves = 900});
    std::vector<VectorXd> products;
    for (const int threads : {1, 2, 5}) {
      ThreadPool pool(threads);
      const auto reduced = make_reduced_system(system.layout, Side::leaves, pool);
      reduced->prepare(system.linearization(pool), system.D.data());
      SymmetricBlocks A(reduced->pattern(), Storage::dense);
      VectorXd v(reduced->size()), y(reduced->size()), step(system.layout.unknowns());
      reduced->assemble(A, v.data());
      reduced->apply(v.data(), y.data());
      const MatrixXd matrix = test::dense_of(A);
      EXPECT_LE((y - matrix * v).norm(), 1e-11 * matrix.norm() * v.norm());
      const double squares = reduced->expand(y.data(), step.data());
      EXPECT_NEAR(squares, (system.dense * step).squaredNorm(), 1e-10 * squares);
      y.conservativeResize(y.size() + 1);
      y[y.size() - 1] = squares;
      products.push_back(y);
    }
    EXPECT_TRUE(products[0] == products[1]);
    EXPECT_TRUE(products[0] == products[2]);
  }
}

std::string name(const ::testing::TestParamInfo<Parameter>& test) {
  const auto& [options, eliminated] = test.param;
  const char* side = !eliminated ? "Full" : (*eliminated == Side::leaves ? "NoLeaves" : "NoHubs");
  return side + test::name(options);
}

INSTANTIATE_TEST_SUITE_P(Systems, ReducedSystems,
                         ::testing::Combine(::testing::ValuesIn(test::typical_systems()),
                                            ::testing::Values(std::optional<Side>(),
                                                              std::optional<Side>(Side::leaves),
                                                              std::optional<Side>(Side::hubs))),
                         name);
INSTANTIATE_TEST_SUITE_P(Anchored, ReducedSystems,
                         ::testing::Combine(::testing::ValuesIn(test::anchored_systems()),
                                            ::testing::Values(std::optional<Side>(),
                                                              std::optional<Side>(Side::leaves))),
                         name);

TEST(AnchoredLeaves, HubsCannotBeEliminated) {
  const BlockSystem system({.anchored = true});
  ThreadPool pool(1);
  EXPECT_THROW(make_reduced_system(system.layout, Side::hubs, pool), std::invalid_argument);
}

// Unknowns of very different units, as f and k2 of a camera with f of 1e9: judged relative to the
// entries' own scale, sqrt(H_ii H_jj).
TEST(BadlyScaled, EliminationIsAccurateInTheOwnUnitsOfEachEntry) {
  for (const int hub_size : {9, 6}) {
    for (const Side eliminated : {Side::leaves, Side::hubs}) {
      BlockSystem system({.seed = 21,
                          .hub_size = hub_size,
                          .hubs = 4,
                          .leaves = 40,
                          .hub_column_spread = 9,
                          .leaf_column_spread = 3});
      const MatrixXd H = system.H();
      const VectorXd s = H.diagonal().cwiseSqrt().cwiseInverse();
      // The oracle works in the well scaled unknowns and is carried back.
      const MatrixXd Hs = s.asDiagonal() * H * s.asDiagonal();
      const VectorXd step =
          -(s.asDiagonal() * Hs.ldlt().solve(VectorXd(s.asDiagonal() * system.gradient()))).eval();
      ThreadPool pool(2);
      const auto reduced = make_reduced_system(system.layout, eliminated, pool);
      reduced->prepare(system.linearization(pool), system.D.data());
      SymmetricBlocks A(reduced->pattern(), Storage::dense);
      VectorXd v(reduced->size());
      reduced->assemble(A, v.data());
      const VectorXd sk = s.segment(reduced->offset(), reduced->size());
      const MatrixXd As = sk.asDiagonal() * test::dense_of(A) * sk.asDiagonal();
      const VectorXd x = -(sk.asDiagonal() * As.ldlt().solve(VectorXd(sk.asDiagonal() * v))).eval();
      VectorXd found(system.layout.unknowns());
      reduced->expand(x.data(), found.data());
      const VectorXd error = (found - step).cwiseQuotient(s);
      EXPECT_LE(error.norm(), 1e-9 * step.cwiseQuotient(s).norm()) << hub_size;
    }
  }
}

}  // namespace
}  // namespace raybundle::linalg
