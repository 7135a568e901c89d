#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/normal_equations.h>
#include <raybundle/linalg/reduced_system.h>
#include <raybundle/linalg/symmetric_blocks.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <raybundle/tests/support/random_problem.h>

namespace raybundle::test {

/// What a random block-sparse least squares problem is made of.
struct BlockSystemOptions {
  std::uint64_t seed = 1;
  int row_size = 2;
  int hub_size = 9;
  /// Leaves are anchored by their first two hubs, every third by the first alone, every fifth by
  /// none.
  bool anchored = false;
  int hubs = 5;             ///< unobserved ones included
  int leaves = 17;          ///< unobserved and poor ones included
  int rows_per_leaf = 3;    ///< distinct hubs of an ordinary leaf
  int duplicates = 0;       ///< extra rows of a pair that is there already
  int unobserved_hubs = 0;  ///< the last hubs
  int unobserved_leaves = 0;
  int poor_leaves = 0;            ///< the first leaves: a single row, so their block has rank 2
  double hub_column_spread = 0;   ///< hub unknowns are scaled by 10^-spread .. 10^spread
  double leaf_column_spread = 0;  ///< the same for leaf unknowns
  double damping = 0.01;          ///< D is damping * uniform(0.5, 1.5) * diag(H)
  linalg::Precision precision = linalg::Precision::double_precision;
};

/// The normal equations of rows that J holds already.
inline void form(linalg::NormalEquations& normal, linalg::BlockJacobian& J, const double* r,
                 linalg::ThreadPool& pool) {
  const linalg::BlockLayout& layout = J.layout();
  normal.form(J, pool, [&](const linalg::RowTile& tile) {
    const int rows = layout.row_size;
    for (std::int64_t i = 0; i < (tile.last - tile.first) * rows; ++i) {
      const std::int64_t row = tile.first + i / rows;
      const auto residual = static_cast<int>(i % rows);
      tile.residual[i] = r[tile.first * rows + i];
      for (int k = 0; k < layout.hub_size; ++k) {
        tile.J_hub[i * layout.hub_size + k] = J.at(linalg::Side::hubs, row, residual, k);
      }
      for (int k = 0; k < layout.leaf_size; ++k) {
        tile.J_leaf[i * layout.leaf_size + k] = J.at(linalg::Side::leaves, row, residual, k);
      }
    }
    return 0.0;
  });
}

/// The block of a row of J, as it is stored.
inline Eigen::MatrixXd row_block(const linalg::BlockJacobian& J, linalg::Side side,
                                 std::int64_t row) {
  Eigen::MatrixXd block(J.layout().row_size, J.layout().block_size(side));
  for (int r = 0; r < block.rows(); ++r) {
    for (int k = 0; k < block.cols(); ++k) block(r, k) = J.at(side, row, r, k);
  }
  return block;
}

/// A random Jacobian in blocks, and the same in dense form: the oracle of every linear path. The
/// dense matrix is filled from the block values with nothing but their definition.
class BlockSystem {
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

 public:
  explicit BlockSystem(const BlockSystemOptions& options)
      : layout(compile(options)),
        J(layout, options.precision),
        normal(layout),
        r(Eigen::VectorXd::Zero(layout.residuals())) {
    std::mt19937_64 random(options.seed + 1000);
    const auto scale_of = [&](int size, double spread) {
      Eigen::VectorXd scale(size);
      for (double& s : scale) s = std::pow(10.0, spread * uniform(random));
      return scale;
    };
    const auto fill = [&](linalg::Side side, double spread) {
      const Eigen::VectorXd scale = scale_of(layout.block_size(side), spread);
      for (std::int64_t i = 0; i < layout.residuals(); ++i) {
        for (int k = 0; k < scale.size(); ++k) {
          J.set(side, i / layout.row_size, static_cast<int>(i % layout.row_size), k,
                uniform(random) * scale[k]);
        }
      }
    };
    fill(linalg::Side::hubs, options.hub_column_spread);
    fill(linalg::Side::leaves, options.leaf_column_spread);
    for (double& z : J.anchor_blocks) z = uniform(random);
    for (double& x : r) x = uniform(random);
    update_dense();
    D = Eigen::VectorXd::Zero(layout.unknowns());
    const Eigen::VectorXd diagonal = dense.colwise().squaredNorm();
    for (Eigen::Index i = 0; i < D.size(); ++i) {
      const double base = diagonal[i] > 0 ? diagonal[i] : 1.0;
      D[i] = options.damping * (1 + 0.5 * uniform(random)) * base;
    }
  }
  BlockSystem(const BlockSystem&) = delete;
  BlockSystem& operator=(const BlockSystem&) = delete;

  /// Writes the block values into the dense matrix; needed after changing them by hand.
  void update_dense() {
    dense = Eigen::MatrixXd::Zero(layout.residuals(), layout.unknowns());
    const Eigen::Index R = layout.row_size, K = layout.hub_size, E = layout.leaf_size;
    for (std::size_t i = 0; i < row_hub.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i);
      const Eigen::Index leaf = row_leaf[i];
      const Eigen::MatrixXd J_leaf = row_block(J, linalg::Side::leaves, row);
      dense.block(R * row, layout.hubs * K + leaf * E, R, E) = J_leaf;
      dense.block(R * row, row_hub[i] * K, R, K) += row_block(J, linalg::Side::hubs, row);
      if (!layout.anchored()) continue;
      const linalg::Anchorage& anchorage = layout.anchorage;
      const std::int64_t end = anchorage.begin[linalg::index(leaf + 1)];
      for (std::int64_t k = anchorage.begin[linalg::index(leaf)]; k < end; ++k) {
        const std::int64_t coupling = anchorage.coupling[linalg::index(k)];
        const Eigen::Index hub = layout.hub_side.block[linalg::index(coupling)];
        dense.block(R * row, hub * K, R, K) +=
            J_leaf * Eigen::Map<const RowMajor>(J.anchor_blocks.data() + k * E * K, E, K);
      }
    }
  }

  /// The normal equations and all a reduced system asks for.
  linalg::Linearization linearization(linalg::ThreadPool& pool) {
    form(normal, J, r.data(), pool);
    return {&J, &normal};
  }

  /// J^T J + diag(D), J^T r.
  Eigen::MatrixXd H() const {
    Eigen::MatrixXd H = dense.transpose() * dense;
    H.diagonal() += D;
    return H;
  }
  Eigen::VectorXd gradient() const { return dense.transpose() * r; }

  std::vector<std::int32_t> row_leaf;  // before the layout, which is made from them
  std::vector<std::int32_t> row_hub;
  linalg::BlockLayout layout;
  linalg::BlockJacobian J;
  linalg::NormalEquations normal;
  Eigen::VectorXd r;
  Eigen::VectorXd D;
  Eigen::MatrixXd dense;

 private:
  linalg::BlockLayout compile(const BlockSystemOptions& options) {
    std::mt19937_64 random(options.seed);
    const int hubs = options.hubs - options.unobserved_hubs;
    std::vector<std::pair<std::int32_t, std::int32_t>> rows;  // (leaf, hub)
    std::vector<std::int32_t> order(static_cast<std::size_t>(hubs));
    std::iota(order.begin(), order.end(), 0);
    for (int leaf = 0; leaf < options.leaves - options.unobserved_leaves; ++leaf) {
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[random() % i]);
      const int count = leaf < options.poor_leaves ? 1 : std::min(options.rows_per_leaf, hubs);
      for (int k = 0; k < count; ++k) rows.emplace_back(leaf, order[static_cast<std::size_t>(k)]);
    }
    const std::size_t distinct = rows.size();
    for (int k = 0; k < options.duplicates; ++k) rows.push_back(rows[random() % distinct]);
    std::sort(rows.begin(), rows.end());
    for (const auto& [leaf, hub] : rows) {
      row_leaf.push_back(leaf);
      row_hub.push_back(hub);
    }
    linalg::BlockLayout result = linalg::make_layout(
        {options.row_size, options.hub_size, 3}, options.hubs, options.leaves, row_leaf, row_hub);
    if (options.anchored) linalg::anchor_leaves(result, anchors_of(result));
    return result;
  }

  static std::vector<linalg::LeafAnchors> anchors_of(const linalg::BlockLayout& layout) {
    std::vector<linalg::LeafAnchors> anchors;
    for (std::size_t l = 0; l + 1 < layout.leaf_side.begin.size(); ++l) {
      const std::int64_t first = layout.leaf_side.begin[l], last = layout.leaf_side.begin[l + 1];
      const std::int64_t count =
          std::min<std::int64_t>(l % 5 == 4 ? 0 : (l % 3 == 2 ? 1 : 2), last - first);
      linalg::LeafAnchors of_leaf = {-1, -1};
      // The second hub comes first: anchors stand in no order.
      for (std::int64_t k = 0; k < count; ++k) {
        of_leaf[static_cast<std::size_t>(count - 1 - k)] =
            layout.hub_side.block[linalg::index(first + k)];
      }
      anchors.push_back(of_leaf);
    }
    return anchors;
  }
};

/// The whole symmetric matrix that the stored upper block triangle stands for. Only what a
/// factorisation reads is read: from each diagonal block its upper triangle.
inline Eigen::MatrixXd dense_of(linalg::SymmetricBlocks& A) {
  using linalg::index;
  const linalg::SymmetricPattern& pattern = A.pattern();
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(pattern.order(), pattern.order());
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t i = 0; i < pattern.block_size(a); ++i) {
      const double* row = A.row(a) + i * A.stride(a);
      const Eigen::Index from = pattern.offset[index(a)] + i;
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        const std::int64_t b = pattern.column[index(p)];
        for (std::int64_t k = 0; k < pattern.block_size(b); ++k) {
          const Eigen::Index to = pattern.offset[index(b)] + k;
          if (to < from) continue;
          result(from, to) = result(to, from) = row[A.block_shift(p) + k];
        }
      }
    }
  }
  return result;
}

/// Writes a dense symmetric matrix into the pattern of A; entries outside of it must be zero.
inline void write_dense(const Eigen::MatrixXd& values, linalg::SymmetricBlocks& A) {
  using linalg::index;
  const linalg::SymmetricPattern& pattern = A.pattern();
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    A.set_zero(a);
    for (std::int64_t i = 0; i < pattern.block_size(a); ++i) {
      double* row = A.row(a) + i * A.stride(a);
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        const std::int64_t b = pattern.column[index(p)];
        for (std::int64_t k = 0; k < pattern.block_size(b); ++k) {
          row[A.block_shift(p) + k] =
              values(pattern.offset[index(a)] + i, pattern.offset[index(b)] + k);
        }
      }
    }
  }
}

/// Systems of all shapes: ordinary, smallest, with duplicates, with unobserved and deficient
/// blocks, and with enough leaves for several pieces of work.
inline std::vector<BlockSystemOptions> typical_systems() {
  std::vector<BlockSystemOptions> list;
  for (const int hub_size : {9, 6}) {
    list.push_back({.seed = 1, .hub_size = hub_size});
    list.push_back({.seed = 2, .hub_size = hub_size, .hubs = 1, .leaves = 1, .rows_per_leaf = 1});
    list.push_back({.seed = 3, .hub_size = hub_size, .duplicates = 11});
    list.push_back({.seed = 4,
                    .hub_size = hub_size,
                    .hubs = 7,
                    .duplicates = 2,
                    .unobserved_hubs = 2,
                    .unobserved_leaves = 3,
                    .poor_leaves = 2});
    list.push_back({.seed = 5, .hub_size = hub_size, .hubs = 3, .leaves = 150, .duplicates = 5});
    list.push_back({.seed = 6, .hub_size = hub_size, .hubs = 12, .rows_per_leaf = 9});
  }
  list.push_back({.seed = 7, .row_size = 3, .hub_size = 6, .hubs = 7, .duplicates = 3});
  // A leaf with more rows than a tile has.
  list.push_back({.seed = 8, .hubs = 67, .leaves = 3, .rows_per_leaf = 66, .duplicates = 9});
  // What is a matter of shape, in single precision too.
  const std::vector<BlockSystemOptions> all = list;
  for (const BlockSystemOptions& each : all) {
    if (each.seed == 1 || each.seed == 2 || each.seed == 5 || each.seed == 6) continue;
    list.push_back(each);
    list.back().precision = linalg::Precision::single_precision;
  }
  return list;
}

inline std::string name(const BlockSystemOptions& options) {
  return "Rows" + std::to_string(options.row_size) + "Hub" + std::to_string(options.hub_size) +
         "Seed" + std::to_string(options.seed) +
         (options.precision == linalg::Precision::single_precision ? "Singles" : "");
}

/// Systems with anchored leaves.
inline std::vector<BlockSystemOptions> anchored_systems() {
  std::vector<BlockSystemOptions> list = typical_systems();
  for (BlockSystemOptions& each : list) each.anchored = true;
  return list;
}

}  // namespace raybundle::test
