#pragma once

#include <raybundle/linalg/large_vector.h>
#include <raybundle/linalg/parallel.h>

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

/// Linear algebra on blocks. The words used here (docs/notation.md):
///   row       a few residuals that belong together (one observation)
///   leaf      a small block of unknowns; its rows are stored together (a point)
///   hub       a block of unknowns that many leaves share (a camera)
///   coupling  a (leaf, hub) pair that shares at least one row; it has one block of E
///   anchor    a coupling by which the hub also moves the whole leaf: all rows of the leaf feel a
///             step x of the hub as if the leaf itself had taken the step Z x (a point that is
///             described from a camera)
/// A row of leaf l and hub h is J_hub x_h + J_leaf (x_l + sum of Z x over the anchors of l). The
/// normal equations are H = [B E; E^T C] with B the hubs and C the leaves [Qu18, Eq. 3.45]. C is
/// block diagonal; so is B, unless there are anchors.
/// Vectors of unknowns hold all hubs, then all leaves.
namespace raybundle::linalg {

enum class Side { hubs, leaves };

constexpr Side opposite(Side side) { return side == Side::hubs ? Side::leaves : Side::hubs; }
constexpr std::size_t index(std::int64_t i) { return static_cast<std::size_t>(i); }

/// The couplings as one side sees them: block b owns positions begin[b] .. begin[b + 1], and
/// position p stands for coupling list[p]. Couplings are numbered leaf by leaf, so the leaves'
/// list is the identity and left empty. Lists by coupling have 4 bytes an entry, since they are as
/// long as the observations; make_layout() refuses what they could not number.
struct Incidence {
  LargeVector<std::int64_t> begin;
  LargeVector<std::int32_t> list;
  LargeVector<std::int32_t> block;  ///< of a coupling
};

/// The position of every coupling: the inverse of the list.
LargeVector<std::int32_t> positions(const Incidence& side);

/// The anchors of leaves, numbered leaf by leaf.
struct Anchorage {
  std::vector<std::int64_t> begin;     ///< anchors of leaf l: [l] .. [l + 1]; empty: none at all
  std::vector<std::int32_t> coupling;  ///< of an anchor
  std::vector<std::int32_t> anchor;    ///< of a coupling; -1: it is none
};

/// Leaf and hub of every row, sorted by leaf, then hub. Equal pairs are legal and share a coupling.
struct RowBlocks {
  LargeVector<std::int32_t> leaf, hub;
  LargeVector<std::int64_t> begin;  ///< rows of leaf l: [l] .. [l + 1]
};

/// Sizes of the three kinds of block.
struct BlockSizes {
  int row = 2;
  int hub = 9;
  int leaf = 3;
};

/// What is known of a layout before it is there. Whoever allocates by it says how much it will be,
/// in a function called memory() beside the constructor, so that what does not fit can be refused
/// before.
struct LayoutSize {
  BlockSizes block;
  std::int64_t hubs = 0;
  std::int64_t leaves = 0;
  std::int64_t rows = 0;
  int anchors = 0;  ///< of a leaf, at most

  bool anchored() const { return anchors > 0; }
  int block_size(Side side) const { return side == Side::hubs ? block.hub : block.leaf; }
  std::int64_t block_count(Side side) const { return side == Side::hubs ? hubs : leaves; }
  std::int64_t size(Side side) const { return block_count(side) * block_size(side); }
  std::int64_t unknowns() const { return size(Side::hubs) + size(Side::leaves); }
  std::int64_t residuals() const { return rows * block.row; }
};

/// Sizes and sparsity of a block-sparse Jacobian; built once per problem.
struct BlockLayout {
  int row_size = 0;   ///< residuals per row
  int hub_size = 0;   ///< unknowns per hub
  int leaf_size = 0;  ///< unknowns per leaf
  std::int64_t rows = 0;
  std::int64_t hubs = 0;
  std::int64_t leaves = 0;
  std::int64_t couplings = 0;

  /// Rows of coupling c: [c] .. [c + 1]; empty: row c.
  std::vector<std::int64_t> coupling_rows;
  RowBlocks repeated;  ///< where some couplings have several rows, else empty
  Anchorage anchorage;
  Incidence hub_side;
  Incidence leaf_side;

  const Incidence& incidence(Side side) const { return side == Side::hubs ? hub_side : leaf_side; }
  int block_size(Side side) const { return side == Side::hubs ? hub_size : leaf_size; }
  std::int64_t block_count(Side side) const { return side == Side::hubs ? hubs : leaves; }
  std::int64_t size(Side side) const { return block_count(side) * block_size(side); }
  std::int64_t offset(Side side) const { return side == Side::hubs ? 0 : size(Side::hubs); }
  std::int64_t unknowns() const { return size(Side::hubs) + size(Side::leaves); }
  std::int64_t residuals() const { return rows * row_size; }
  std::span<const std::int32_t> row_leaf() const {
    return coupling_rows.empty() ? leaf_side.block : repeated.leaf;
  }
  std::span<const std::int32_t> row_hub() const {
    return coupling_rows.empty() ? hub_side.block : repeated.hub;
  }
  /// Rows of leaf l: [l] .. [l + 1].
  std::span<const std::int64_t> leaf_rows() const {
    return coupling_rows.empty() ? leaf_side.begin : repeated.begin;
  }
  /// Bytes of a layout without repeated rows.
  static double memory(const LayoutSize& n);

  bool anchored() const { return !anchorage.begin.empty(); }
  std::int64_t anchors() const { return static_cast<std::int64_t>(anchorage.coupling.size()); }
};

/// The most rows, and blocks of a side, that a layout can number.
inline constexpr std::int64_t most_numbered = std::numeric_limits<std::int32_t>::max();

/// Compiles the sparsity. Throws std::length_error beyond most_numbered.
BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves, RowBlocks rows,
                        ThreadPool& pool);

/// The same from plain lists, by the calling thread.
BlockLayout make_layout(BlockSizes sizes, std::int64_t hubs, std::int64_t leaves,
                        const std::vector<std::int32_t>& row_leaf,
                        const std::vector<std::int32_t>& row_hub);

/// Hubs that anchor a leaf, each once; -1: none.
using LeafAnchors = std::array<std::int32_t, 2>;

/// Makes the given couplings of every leaf anchors. Throws std::invalid_argument where a leaf has
/// no row of its anchor or one anchor twice, or the list is not as long as there are leaves.
void anchor_leaves(BlockLayout& layout, const std::vector<LeafAnchors>& anchors);

}  // namespace raybundle::linalg
