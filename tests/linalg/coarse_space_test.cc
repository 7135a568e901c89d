// The coarse part of two levels against dense matrices.

#include <raybundle/linalg/coarse_space.h>

#include <cstdint>
#include <random>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/preconditioner.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::BlockSystem;
using test::BlockSystemOptions;

// A prepared system with modes, what a coarse space makes of it, and both in dense form.
struct Fixture {
  explicit Fixture(const BlockSystemOptions& options, int threads = 2)
      : pool(threads),
        system(options),
        reduced(make_reduced_system(system.layout, Side::leaves, pool)),
        modes(coarse_modes(system.layout.hub_size)),
        space(system.layout, pool) {
    std::mt19937_64 random(options.seed + 5);
    hub_modes.resize(index(reduced->size() * modes));
    for (double& x : hub_modes) x = test::uniform(random);
  }

  bool build(const double* inverse_scaling = nullptr) {
    at = system.linearization(pool);
    at.hub_modes = hub_modes.data();
    reduced->prepare(at, system.D.data());
    SymmetricBlocks matrix(reduced->pattern(), SymmetricBlocks::Storage::sparse);
    VectorXd v(reduced->size());
    reduced->assemble(matrix, v.data());
    A = test::dense_of(matrix);
    reduced->reduced_diagonal(diagonal, v.data());
    if (inverse_scaling != nullptr) scale_diagonal(inverse_scaling);
    return space.build(*reduced, at, diagonal, inverse_scaling);
  }

  void scale_diagonal(const double* s) {
    const int n = system.layout.hub_size;
    for (std::int64_t i = 0; i < reduced->size(); ++i) {
      for (int j = 0; j < n; ++j) {
        diagonal.runs[0].values[index(i * n + j)] *= s[i] * s[i / n * n + j];
      }
    }
  }

  MatrixXd P() const {
    const CoarseBasis& basis = space.basis();
    MatrixXd result = MatrixXd::Zero(reduced->size(), basis.pattern.order());
    for (std::int64_t i = 0; i < reduced->size(); ++i) {
      const std::int32_t g = basis.cluster[index(i / system.layout.hub_size)];
      for (int j = 0; j < modes; ++j) result(i, g * modes + j) = basis.P[index(i * modes + j)];
    }
    return result;
  }

  MatrixXd coarse() {
    const SymmetricPattern& pattern = space.basis().pattern;
    const double* values = reduced->coarse_matrix(space.basis());
    MatrixXd result = MatrixXd::Zero(pattern.order(), pattern.order());
    for (std::int64_t g = 0; g < pattern.blocks(); ++g) {
      for (std::int64_t p = pattern.row_begin[index(g)]; p < pattern.row_begin[index(g + 1)]; ++p) {
        const std::int64_t h = pattern.column[index(p)];
        for (int i = 0; i < modes; ++i) {
          for (int j = 0; j < modes; ++j) {
            const double value = values[(p * modes + i) * modes + j];
            result(g * modes + i, h * modes + j) = result(h * modes + j, g * modes + i) = value;
          }
        }
      }
    }
    return result;
  }

  ThreadPool pool;
  BlockSystem system;
  std::unique_ptr<ReducedSystem> reduced;
  int modes;
  std::vector<double> hub_modes;
  CoarseSpace space;
  Linearization at = {};
  DiagonalBlocks diagonal;
  MatrixXd A;
};

std::vector<BlockSystemOptions> systems() {
  std::vector<BlockSystemOptions> list = test::typical_systems();
  const auto anchored = test::anchored_systems();
  list.insert(list.end(), anchored.begin(), anchored.end());
  // Several clusters, and enough leaves for several pieces of work.
  for (const bool with_anchors : {false, true}) {
    list.push_back({.seed = 9,
                    .anchored = with_anchors,
                    .hubs = 40,
                    .leaves = 300,
                    .rows_per_leaf = 4,
                    .duplicates = 9,
                    .unobserved_hubs = 2,
                    .unobserved_leaves = 3,
                    .poor_leaves = 4});
  }
  return list;
}

TEST(CoarseSpace, MatrixIsThatOfTheDenseProduct) {
  for (const BlockSystemOptions& options : systems()) {
    Fixture f(options);
    ASSERT_TRUE(f.build());
    if (options.hubs == 40) {
      EXPECT_GE(f.space.clusters(), 3);
    }
    const MatrixXd expected = f.P().transpose() * f.A * f.P();
    EXPECT_LE((f.coarse() - expected).norm(), 1e-11 * (1 + expected.norm())) << test::name(options);
  }
}

// By cluster, in the norm of the diagonal blocks; what depends on other modes is zero.
TEST(CoarseSpace, ModesAreOrthonormal) {
  for (const BlockSystemOptions& options : systems()) {
    Fixture f(options);
    ASSERT_TRUE(f.build());
    const int n = f.system.layout.hub_size;
    MatrixXd N = MatrixXd::Zero(f.A.rows(), f.A.cols());
    for (Eigen::Index b = 0; b < N.rows(); b += n) N.block(b, b, n, n) = f.A.block(b, b, n, n);
    const MatrixXd P = f.P(), gram = P.transpose() * N * P;
    for (Eigen::Index i = 0; i < gram.rows(); ++i) {
      for (Eigen::Index j = 0; j < gram.rows(); ++j) {
        const bool zero = P.col(i).norm() == 0;
        EXPECT_NEAR(gram(i, j), i == j && !zero ? 1 : 0, 1e-6) << test::name(options);
      }
    }
    if (f.space.clusters() == 1 && options.hubs == 1) {
      EXPECT_EQ(f.P().colwise().norm().minCoeff(), 0) << "a hub has fewer unknowns than modes";
    }
  }
}

// z of all unit vectors, of both levels together.
MatrixXd applied(Fixture& f) {
  Preconditioner blocks;
  blocks.build(Preconditioner::Form::blocks, f.diagonal, f.pool);
  const std::int64_t n = f.reduced->size();
  MatrixXd result(n, n);
  for (std::int64_t i = 0; i < n; ++i) {
    const VectorXd r = VectorXd::Unit(n, i);
    blocks.apply(r.data(), result.col(i).data(), n, f.pool);
    f.space.add_correction(r.data(), result.col(i).data());
  }
  return result;
}

TEST(CoarseSpace, PreconditionerIsSymmetricAndDefinite) {
  for (const BlockSystemOptions& options : systems()) {
    Fixture f(options);
    VectorXd inverse_scaling(f.reduced->size());
    std::mt19937_64 random(3);
    for (double& s : inverse_scaling) s = 1 + 0.9 * test::uniform(random);
    for (const bool scaled : {false, true}) {
      ASSERT_TRUE(f.build(scaled ? inverse_scaling.data() : nullptr));
      const MatrixXd M = applied(f);
      EXPECT_LE((M - M.transpose()).norm(), 1e-9 * M.norm()) << test::name(options);
      EXPECT_EQ(Eigen::LLT<MatrixXd>(M).info(), Eigen::Success) << test::name(options);
      // On its own space the coarse part is exact: P c for r = A P c.
      const MatrixXd P = f.P();
      const VectorXd x = P * VectorXd::Ones(P.cols());
      MatrixXd A = f.A;
      if (scaled) A = inverse_scaling.asDiagonal() * f.A * inverse_scaling.asDiagonal();
      const VectorXd r = A * x;
      VectorXd z = VectorXd::Zero(r.size());
      f.space.add_correction(r.data(), z.data());
      EXPECT_LE((z - x).norm(), 1e-6 * x.norm()) << test::name(options);
    }
  }
}

TEST(CoarseSpace, WhatNoRowFeelsDoesNotMove) {
  Fixture f({.seed = 8, .hubs = 20, .leaves = 100, .rows_per_leaf = 4});
  for (std::int64_t row = 0; row < f.system.layout.rows; ++row) {
    if (f.system.row_hub[index(row)] != 7) continue;
    for (int i = 0; i < 2 * 5; ++i) f.system.J.set(Side::hubs, row, i / 5, i % 5, 0);
  }
  f.system.update_dense();
  ASSERT_TRUE(f.build());
  EXPECT_EQ(f.P().middleRows(7 * 9, 5).norm(), 0);
  EXPECT_GT(f.P().middleRows(7 * 9 + 5, 4).norm(), 0);
}

TEST(CoarseSpace, HasTheSameBitsForAnyNumberOfThreads) {
  const BlockSystemOptions options = {
      .seed = 9, .anchored = true, .hubs = 40, .leaves = 400, .rows_per_leaf = 4};
  Fixture one(options, 1), three(options, 3);
  ASSERT_TRUE(one.build());
  ASSERT_TRUE(three.build());
  EXPECT_EQ(one.space.basis().P, three.space.basis().P);
  EXPECT_EQ(one.coarse(), three.coarse());
  EXPECT_EQ(applied(one), applied(three));
}

// Pairs that share leaves with nobody else: no size of the clusters brings them together.
BlockLayout pairs(std::int32_t count) {
  std::vector<std::int32_t> leaf, hub;
  for (std::int32_t l = 0; l < 15 * count; ++l) {
    for (const std::int32_t side : {0, 1}) leaf.push_back(l), hub.push_back(l / 15 * 2 + side);
  }
  return make_layout({2, 9, 3}, 2 * count, 15 * count, leaf, hub);
}

TEST(CoarseSpace, HasAClusterForEachPartThatIsNotConnected) {
  ThreadPool pool(1);
  for (const std::int32_t count : {1, 20, 70}) {
    const BlockLayout layout = pairs(count);
    EXPECT_EQ(CoarseSpace(layout, pool).clusters(), count);
  }
}

TEST(CoarseSpace, IsRefusedWhereItWouldTakeTooMuch) {
  ThreadPool pool(1);
  const BlockLayout layout = pairs(20);
  const double needed = CoarseSpace::memory(layout, pool);
  EXPECT_NO_THROW(CoarseSpace(layout, pool, needed));
  EXPECT_THROW(CoarseSpace(layout, pool, 0.99 * needed), MemoryRefusal);
}

TEST(CoarseSpace, IsOneOfKeptHubs) {
  BlockSystem system({.hubs = 4});
  ThreadPool pool(1);
  for (const auto eliminated : {std::optional<Side>(), std::optional<Side>(Side::hubs)}) {
    EXPECT_THROW(make_reduced_system(system.layout, eliminated, pool)->coarse_matrix({}),
                 std::logic_error);
  }
}

}  // namespace
}  // namespace raybundle::linalg
