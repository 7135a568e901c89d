#include <raybundle/linalg/block_layout.h>

#include <array>
#include <cstdint>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/linalg/kernels/kernel_table.h>
#include <raybundle/tests/support/block_system.h>

namespace raybundle::linalg {
namespace {

using Indices = std::vector<std::int64_t>;
using test::BlockSystem;

// Leaf 0: hubs 1, 1, 2; leaf 1: nobody; leaf 2: hubs 0, 2. Hub 3: nobody.
BlockLayout example() { return make_layout({2, 9, 3}, 4, 3, {0, 0, 0, 2, 2}, {1, 1, 2, 0, 2}); }

TEST(BlockLayout, CountsWhatItIsGiven) {
  const BlockLayout layout = example();
  EXPECT_EQ(layout.rows, 5);
  EXPECT_EQ(layout.residuals(), 10);
  EXPECT_EQ(layout.couplings, 4);
  EXPECT_EQ(layout.size(Side::hubs), 36);
  EXPECT_EQ(layout.size(Side::leaves), 9);
  EXPECT_EQ(layout.offset(Side::hubs), 0);
  EXPECT_EQ(layout.offset(Side::leaves), 36);
  EXPECT_EQ(layout.unknowns(), 45);
  EXPECT_EQ(layout.block_count(Side::leaves), 3);
  EXPECT_EQ(layout.block_size(Side::hubs), 9);
}

TEST(BlockLayout, RepeatedPairsShareACoupling) {
  EXPECT_EQ(example().coupling_rows, (Indices{0, 2, 3, 4, 5}));
  const BlockLayout distinct = make_layout({2, 6, 3}, 2, 2, {0, 0, 1}, {0, 1, 1});
  EXPECT_TRUE(distinct.coupling_rows.empty()) << "without repetition coupling c is row c";
  EXPECT_EQ(distinct.couplings, 3);
}

TEST(BlockLayout, EqualHubsOfNeighbouringLeavesAreNotARepetition) {
  EXPECT_EQ(make_layout({2, 9, 3}, 1, 3, {0, 1, 2}, {0, 0, 0}).couplings, 3);
}

TEST(BlockLayout, IncidenceOfBothSides) {
  const BlockLayout layout = example();
  EXPECT_EQ(layout.leaf_side.begin, (Indices{0, 2, 2, 4})) << "leaf 1 is empty";
  EXPECT_TRUE(layout.leaf_side.list.empty());
  EXPECT_TRUE(layout.leaf_side.position.empty());
  EXPECT_EQ(layout.leaf_side.block, (std::vector<std::int32_t>{0, 0, 2, 2}));
  EXPECT_EQ(layout.hub_side.block, (std::vector<std::int32_t>{1, 2, 0, 2}));
  EXPECT_EQ(layout.hub_side.begin, (Indices{0, 1, 2, 4, 4})) << "hub 3 is empty";
  EXPECT_EQ(layout.hub_side.list, (Indices{2, 0, 1, 3}));
  EXPECT_EQ(layout.hub_side.position, (Indices{1, 2, 0, 3}));
}

TEST(BlockLayout, IncidenceOfRandomSystemsIsConsistent) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const BlockSystem system({.seed = seed,
                              .anchored = seed > 10,
                              .hubs = 6,
                              .leaves = 25,
                              .duplicates = 7,
                              .unobserved_hubs = 1,
                              .unobserved_leaves = 2,
                              .poor_leaves = 2});
    const BlockLayout& layout = system.layout;
    std::set<std::pair<std::int32_t, std::int32_t>> pairs;
    for (std::size_t row = 0; row < system.row_leaf.size(); ++row) {
      pairs.emplace(system.row_leaf[row], system.row_hub[row]);
    }
    ASSERT_EQ(layout.couplings, static_cast<std::int64_t>(pairs.size()));
    std::int64_t c = 0;
    for (const auto& [leaf, hub] : pairs) {
      EXPECT_EQ(layout.leaf_side.block[index(c)], leaf);
      EXPECT_EQ(layout.hub_side.block[index(c)], hub);
      EXPECT_EQ(layout.hub_side.list[index(layout.hub_side.position[index(c)])], c);
      ++c;
    }
    for (std::int64_t hub = 0; hub < layout.hubs; ++hub) {
      std::int32_t previous = -1;
      for (std::int64_t p = layout.hub_side.begin[index(hub)];
           p < layout.hub_side.begin[index(hub + 1)]; ++p) {
        const std::int64_t coupling = layout.hub_side.list[index(p)];
        EXPECT_EQ(layout.hub_side.block[index(coupling)], hub);
        EXPECT_GT(layout.leaf_side.block[index(coupling)], previous) << "leaves must ascend";
        previous = layout.leaf_side.block[index(coupling)];
      }
    }
    EXPECT_EQ(layout.hub_side.begin.back(), layout.couplings);
    EXPECT_EQ(layout.leaf_side.begin.back(), layout.couplings);
  }
}

TEST(BlockLayout, AnchorsAreCouplings) {
  BlockLayout layout = make_layout({2, 9, 3}, 4, 3, {0, 0, 0, 2, 2}, {0, 1, 3, 1, 2});
  EXPECT_FALSE(layout.anchored());
  anchor_leaves(layout, {{3, 1}, {-1, -1}, {2, -1}});
  EXPECT_TRUE(layout.anchored());
  EXPECT_EQ(layout.anchorage.begin, (Indices{0, 2, 2, 3}));
  EXPECT_EQ(layout.anchorage.coupling, (Indices{2, 1, 4}));
  EXPECT_EQ(layout.anchorage.anchor, (Indices{-1, 1, 0, -1, 2}));
}

TEST(BlockLayout, AnchorsMustSeeTheirLeaf) {
  BlockLayout layout = make_layout({2, 9, 3}, 4, 3, {0, 0, 0, 2, 2}, {0, 1, 3, 1, 2});
  EXPECT_THROW(anchor_leaves(layout, {{2, -1}, {-1, -1}, {2, -1}}), std::invalid_argument);
  EXPECT_THROW(anchor_leaves(layout, {{0, -1}, {0, -1}, {2, -1}}), std::invalid_argument);
  EXPECT_THROW(anchor_leaves(layout, {{1, 1}, {-1, -1}, {2, -1}}), std::invalid_argument);
  EXPECT_THROW(anchor_leaves(layout, {{1, -1}, {-1, -1}}), std::invalid_argument);
}

TEST(BlockLayout, NoRowsAtAll) {
  const BlockLayout layout = make_layout({2, 9, 3}, 2, 3, {}, {});
  EXPECT_EQ(layout.couplings, 0);
  EXPECT_EQ(layout.hub_side.begin, (Indices{0, 0, 0}));
  EXPECT_EQ(layout.leaf_side.begin, (Indices{0, 0, 0, 0}));
}

TEST(KernelTable, RefusesShapesNobodyCompiled) {
  for (const Precision precision : {Precision::single_precision, Precision::double_precision}) {
    for (const bool anchored : {false, true}) {
      for (const auto [row, hub, leaf] : {std::array{2, 7, 3}, {3, 9, 3}, {2, 9, 4}, {1, 9, 3}}) {
        const KernelShape shape = {precision, anchored, row, hub, leaf};
        EXPECT_THROW(block_kernels(shape), std::invalid_argument);
        EXPECT_THROW(elimination_kernels(shape, true), std::invalid_argument);
        EXPECT_THROW(elimination_kernels(shape, false), std::invalid_argument);
      }
    }
    EXPECT_THROW(elimination_kernels({precision, true, 2, 9, 3}, false), std::invalid_argument);
  }
}

}  // namespace
}  // namespace raybundle::linalg
