// The supernodal factorisation: its symbolic part against the definition, its numbers against
// CHOLMOD, and the same bits for any number of threads.

#include <raybundle/linalg/supernodal_cholesky.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/linalg/cholmod_cholesky.h>
#include <raybundle/linalg/ordering.h>
#include <raybundle/tests/support/random_problem.h>

namespace raybundle::linalg {
namespace {

// A plane of blocks, each beside those within `reach`; every third of another size.
SymmetricPattern plane(int side, int reach, int size, int other) {
  SymmetricPattern pattern;
  pattern.offset = {0};
  pattern.row_begin = {0};
  for (int a = 0; a < side * side; ++a) {
    pattern.offset.push_back(pattern.offset.back() + (a % 3 == 0 ? other : size));
    const int x = a % side, y = a / side;
    for (int b = a; b < side * side; ++b) {
      if (std::abs(b % side - x) <= reach && b / side - y <= reach) pattern.column.push_back(b);
    }
    pattern.row_begin.push_back(static_cast<std::int64_t>(pattern.column.size()));
  }
  return pattern;
}

// Random blocks, definite by the diagonal.
SymmetricBlocks random_blocks(const SymmetricPattern& pattern, std::uint64_t seed) {
  SymmetricBlocks A(pattern, SymmetricBlocks::Storage::sparse);
  std::mt19937_64 random(seed);
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t i = 0; i < pattern.block_size(a); ++i) {
      double* row = A.row(a) + i * A.stride(a);
      for (std::int64_t k = 0; k < A.stride(a); ++k) row[k] = test::uniform(random);
      row[i] = 300;
    }
  }
  return A;
}

Supernodes supernodes_of(const SymmetricPattern& pattern) {
  return find_supernodes(pattern, find_ordering(pattern).permutation);
}

std::vector<double> right_side(const SymmetricPattern& pattern) {
  std::vector<double> b(index(pattern.order()));
  for (std::size_t i = 0; i < b.size(); ++i) b[i] = std::sin(static_cast<double>(i));
  return b;
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, norm = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    norm += b[i] * b[i];
  }
  return std::sqrt(difference / norm);
}

// Whole elimination, place by place: what the rows below of every supernode must contain.
std::vector<std::set<std::int32_t>> filled(const SymmetricPattern& pattern, const Supernodes& s) {
  std::vector<std::set<std::int32_t>> below(s.order.size());
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
      const auto [i, j] = std::minmax(s.place[index(a)], s.place[index(pattern.column[index(p)])]);
      if (i != j) below[index(i)].insert(j);
    }
  }
  for (const std::set<std::int32_t>& rows : below) {
    if (rows.empty()) continue;
    below[index(*rows.begin())].insert(std::next(rows.begin()), rows.end());
  }
  return below;
}

TEST(Supernodes, HoldTheFillAndFormATree) {
  for (const SymmetricPattern& pattern : {plane(9, 1, 9, 3), plane(12, 2, 6, 6)}) {
    const Supernodes s = supernodes_of(pattern);
    EXPECT_LT(s.count(), pattern.blocks()) << "something was merged";
    for (std::size_t k = 0; k < s.order.size(); ++k) {
      EXPECT_EQ(s.place[index(s.order[k])], static_cast<std::int32_t>(k));
    }
    const auto below = filled(pattern, s);
    for (std::int32_t f = 0; f < s.count(); ++f) {
      const std::int32_t last = s.first[index(f + 1)];
      const std::set<std::int32_t> rows(s.row.begin() + s.row_begin[index(f)],
                                        s.row.begin() + s.row_begin[index(f + 1)]);
      for (std::int32_t k = s.first[index(f)]; k < last; ++k) {
        for (const std::int32_t i : below[index(k)]) {
          EXPECT_TRUE(i < last || rows.contains(i)) << "row " << i << " of column " << k;
        }
      }
      const std::int32_t parent = s.parent[index(f)];
      EXPECT_EQ(parent < 0, rows.empty());
      if (parent < 0) continue;
      EXPECT_GT(parent, f);
      const std::set<std::int32_t> above(s.row.begin() + s.row_begin[index(parent)],
                                         s.row.begin() + s.row_begin[index(parent + 1)]);
      for (const std::int32_t i : rows) {
        const bool own = s.first[index(parent)] <= i && i < s.first[index(parent + 1)];
        EXPECT_TRUE(own || above.contains(i)) << "row " << i << " of a child of " << parent;
      }
    }
  }
}

TEST(SupernodalCholesky, AgreesWithCholmodInEveryInstructionSet) {
  for (const SymmetricPattern& pattern :
       {plane(9, 1, 9, 3), plane(14, 2, 6, 6), plane(30, 1, 3, 9)}) {
    const SymmetricBlocks A = random_blocks(pattern, 3);
    const std::vector<double> b = right_side(pattern);
    CholmodCholesky oracle(pattern, find_ordering(pattern));
    ASSERT_TRUE(oracle.factor(A));
    std::vector<double> expected = b;
    oracle.solve(expected.data());
    for (const auto set :
         {InstructionSet::baseline, InstructionSet::avx2, InstructionSet::avx512}) {
      if (set > detected_instruction_set()) continue;
      ThreadPool pool(2);
      SupernodalCholesky cholesky(pattern, supernodes_of(pattern), pool, set);
      for (int repetition = 0; repetition < 2; ++repetition) {
        ASSERT_TRUE(cholesky.factor(A));
        std::vector<double> x = b;
        cholesky.solve(x.data());
        EXPECT_LE(distance(x, expected), 1e-13) << name(set);
      }
    }
  }
}

TEST(SupernodalCholesky, SameBitsForAnyNumberOfThreads) {
  const SymmetricPattern pattern = plane(40, 2, 6, 9);
  const SymmetricBlocks A = random_blocks(pattern, 4);
  std::vector<double> first;
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    SupernodalCholesky cholesky(pattern, supernodes_of(pattern), pool);
    ASSERT_TRUE(cholesky.factor(A));
    std::vector<double> x = right_side(pattern);
    cholesky.solve(x.data());
    if (first.empty()) first = x;
    EXPECT_EQ(x, first) << threads;
  }
}

// Pivots fail in subtrees and above them, whoever is at work, and the next matrix is fine.
TEST(SupernodalCholesky, RefusesIndefiniteMatricesWithManyThreads) {
  const SymmetricPattern pattern = plane(20, 1, 6, 6);
  SymmetricBlocks A = random_blocks(pattern, 5);
  ThreadPool pool(3);
  SupernodalCholesky cholesky(pattern, supernodes_of(pattern), pool);
  for (std::int64_t a = 0; a < pattern.blocks(); a += 7) {
    double& entry = A.row(a)[3 * (A.stride(a) + 1)];
    const double before = std::exchange(entry, -1.0);
    EXPECT_FALSE(cholesky.factor(A)) << a;
    entry = before;
  }
  EXPECT_TRUE(cholesky.factor(A));
}

TEST(SupernodalCholesky, MemoryIsNearWhatALayoutTakes) {
  const SymmetricPattern pattern = plane(40, 2, 9, 9);
  const Supernodes supernodes = supernodes_of(pattern);
  const FrontLayout layout(supernodes, 24, 8, 1);
  const double factor = 8.0 * static_cast<double>(layout.factor_size);
  const double matrix = 8.0 * static_cast<double>(pattern.scalar_nonzeros());
  EXPECT_TRUE(layout.subtrees.empty()) << "one lane needs no arena of its own";
  const double memory = SupernodalCholesky::memory(pattern, supernodes, 1);
  EXPECT_GT(memory, factor + matrix);
  EXPECT_LT(memory, 1.5 * factor + 1.1 * matrix) << "what waits is less than the factor";
}

TEST(FrontWork, IsThatOfADenseFactorisationForLargeFronts) {
  EXPECT_NEAR(front_work(6000, 0), 6000.0 * 6000 * 6000 / 6, 0.02 * 6000.0 * 6000 * 6000 / 6);
  const double whole = front_work(2400, 0), parts = front_work(1200, 1200) + front_work(1200, 0);
  EXPECT_LT(whole, parts);
  EXPECT_GT(1.3 * whole, parts);
}

}  // namespace
}  // namespace raybundle::linalg
