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
using Begins = LargeVector<std::int64_t>;
using List = LargeVector<std::int32_t>;
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
  EXPECT_EQ(layout.leaf_side.begin, (Begins{0, 2, 2, 4})) << "leaf 1 is empty";
  EXPECT_TRUE(layout.leaf_side.list.empty());
  EXPECT_TRUE(positions(layout.leaf_side).empty());
  EXPECT_EQ(layout.leaf_side.block, (List{0, 0, 2, 2}));
  EXPECT_EQ(layout.hub_side.block, (List{1, 2, 0, 2}));
  EXPECT_EQ(layout.hub_side.begin, (Begins{0, 1, 2, 4, 4})) << "hub 3 is empty";
  EXPECT_EQ(layout.hub_side.list, (List{2, 0, 1, 3}));
  EXPECT_EQ(positions(layout.hub_side), (List{1, 2, 0, 3}));
}

TEST(BlockLayout, RowsKnowTheirBlocksWithAndWithoutRepetition) {
  const auto list = [](auto span) { return std::vector(span.begin(), span.end()); };
  const BlockLayout repeated = example();
  EXPECT_EQ(list(repeated.row_leaf()), (std::vector<std::int32_t>{0, 0, 0, 2, 2}));
  EXPECT_EQ(list(repeated.row_hub()), (std::vector<std::int32_t>{1, 1, 2, 0, 2}));
  EXPECT_EQ(list(repeated.leaf_rows()), (Indices{0, 3, 3, 5}));
  const BlockLayout distinct = make_layout({2, 6, 3}, 2, 2, {0, 0, 1}, {0, 1, 1});
  EXPECT_EQ(distinct.row_leaf().data(), distinct.leaf_side.block.data()) << "not twice";
  EXPECT_EQ(list(distinct.row_hub()), (std::vector<std::int32_t>{0, 1, 1}));
  EXPECT_EQ(list(distinct.leaf_rows()), (Indices{0, 2, 3}));
}

// Long enough to be cut into pieces.
TEST(BlockLayout, IsTheSameForAnyNumberOfThreads) {
  constexpr std::int64_t hubs = 7, leaves = 60000;
  RowBlocks rows;
  rows.begin.push_back(0);
  for (std::int32_t l = 0; l < leaves; ++l) {
    for (std::int32_t h = l % 3; h < hubs; h += 1 + l % 2) {
      rows.leaf.push_back(l), rows.hub.push_back(h);
    }
    rows.begin.push_back(static_cast<std::int64_t>(rows.leaf.size()));
  }
  ThreadPool one(1), three(3);
  const BlockLayout expected = make_layout({2, 9, 3}, hubs, leaves, rows, one);
  const BlockLayout layout = make_layout({2, 9, 3}, hubs, leaves, rows, three);
  EXPECT_EQ(layout.hub_side.list, expected.hub_side.list);
  EXPECT_EQ(layout.hub_side.begin, expected.hub_side.begin);
  std::int64_t next = 0;
  for (std::int64_t h = 0; h < hubs; ++h) {
    for (std::int64_t c = 0; c < layout.couplings; ++c) {
      if (layout.hub_side.block[index(c)] != h) continue;
      ASSERT_EQ(layout.hub_side.list[index(next++)], c) << "in order of the leaves";
    }
    EXPECT_EQ(layout.hub_side.begin[index(h + 1)], next);
  }
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
    const List position = positions(layout.hub_side);
    std::set<std::pair<std::int32_t, std::int32_t>> pairs;
    for (std::size_t row = 0; row < system.row_leaf.size(); ++row) {
      pairs.emplace(system.row_leaf[row], system.row_hub[row]);
    }
    ASSERT_EQ(layout.couplings, static_cast<std::int64_t>(pairs.size()));
    std::int64_t c = 0;
    for (const auto& [leaf, hub] : pairs) {
      EXPECT_EQ(layout.leaf_side.block[index(c)], leaf);
      EXPECT_EQ(layout.hub_side.block[index(c)], hub);
      EXPECT_EQ(layout.hub_side.list[index(position[index(c)])], c);
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
  EXPECT_EQ(layout.anchorage.coupling, (std::vector<std::int32_t>{2, 1, 4}));
  EXPECT_EQ(layout.anchorage.anchor, (std::vector<std::int32_t>{-1, 1, 0, -1, 2}));
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
  EXPECT_EQ(layout.hub_side.begin, (Begins{0, 0, 0}));
  EXPECT_EQ(layout.leaf_side.begin, (Begins{0, 0, 0, 0}));
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
