// Ranges in huge pages: never the same memory twice, joined when free, given back when whole.

#include <raybundle/linalg/huge_pages.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <new>
#include <random>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace raybundle::linalg {
namespace {

constexpr std::size_t page = HugePages::page;

std::uintptr_t address(const void* memory) { return reinterpret_cast<std::uintptr_t>(memory); }

struct Taken {
  unsigned char* memory;
  std::size_t bytes;
  unsigned char mark;
};

// Takes and gives at random; what is written into a range must be there until it is given.
void churn(HugePages& pages, unsigned seed, int steps) {
  std::mt19937 random(seed);
  std::vector<Taken> taken;
  const auto give = [&](std::size_t i) {
    const Taken each = taken[i];
    for (const std::size_t at : {std::size_t{0}, each.bytes / 2, each.bytes - 1}) {
      ASSERT_EQ(each.memory[at], each.mark);
    }
    pages.give(each.memory, each.bytes);
    taken[i] = taken.back();
    taken.pop_back();
  };
  for (int step = 0; step < steps; ++step) {
    if (taken.size() > 12 || (!taken.empty() && random() % 3 == 0)) {
      give(random() % taken.size());
    } else {
      const std::size_t bytes = 1 + random() % (random() % 4 == 0 ? 3 * page : page / 20);
      auto* const memory = static_cast<unsigned char*>(pages.take(bytes));
      ASSERT_EQ(address(memory) % HugePages::granularity, 0U);
      const auto mark = static_cast<unsigned char>(random());
      std::memset(memory, mark, bytes);
      taken.push_back({memory, bytes, mark});
    }
  }
  while (!taken.empty()) give(0);
}

TEST(HugePages, KeepWhatIsWrittenUntilItIsGiven) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    HugePages pages;
    churn(pages, seed, 1000);
    EXPECT_EQ(pages.held(), 0U) << "everything goes back to the system in the end";
  }
}

TEST(HugePages, ServeThreads) {
  HugePages pages;
  std::vector<std::thread> threads;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    threads.emplace_back([&pages, seed] { churn(pages, seed, 300); });
  }
  for (std::thread& each : threads) each.join();
  EXPECT_EQ(pages.held(), 0U);
}

TEST(HugePages, ArraysShareAPage) {
  HugePages pages;
  void* const a = pages.take(page / 2);
  void* const b = pages.take(page / 4);
  EXPECT_EQ(address(a) % page, page / 2);
  EXPECT_EQ(address(b), address(a) - page / 4);
  EXPECT_EQ(pages.held(), page / 4);
  pages.give(a, page / 2);
  EXPECT_EQ(pages.held(), page - page / 4);
  EXPECT_EQ(pages.take(page / 4), static_cast<char*>(b) - page / 4) << "the first that fits";
  pages.give(static_cast<char*>(b) - page / 4, page / 4);
  pages.give(b, page / 4);
  EXPECT_EQ(pages.held(), 0U);
}

TEST(HugePages, TheRestOfALargeArrayIsUsed) {
  HugePages pages;
  void* const large = pages.take(5 * page / 2);
  void* const small = pages.take(page / 2);
  EXPECT_EQ(address(small), address(large) - page / 2);
  EXPECT_EQ(pages.held(), 0U);
  pages.give(large, 5 * page / 2);
  EXPECT_EQ(pages.held(), page / 2) << "two whole pages have gone";
  pages.give(small, page / 2);
}

// Whether something else is mapped in the two pages below.
bool occupied_below(const void* memory) {
  char* const below =
      static_cast<char*>(const_cast<void*>(memory)) - address(memory) % page - 2 * page;
  constexpr int kind = MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE;
  void* const mapping = ::mmap(below, 2 * page, PROT_NONE, kind, -1, 0);
  if (mapping == MAP_FAILED) return errno == EEXIST;
  ::munmap(mapping, 2 * page);
  return mapping != below;
}

TEST(HugePages, ManyLargeArraysAdjoinUnlessAnotherMappingIsInTheWay) {
  HugePages pages;
  constexpr std::size_t bytes = 5 * page / 3 / HugePages::granularity * HugePages::granularity;
  std::vector<void*> taken = {pages.take(bytes)};
  std::size_t ranges = 1;
  while (taken.size() < 30) {
    const void* const last = taken.back();
    const bool room = !occupied_below(last);
    taken.push_back(pages.take(bytes));
    const bool adjoins = address(taken.back()) + bytes == address(last);
    EXPECT_TRUE(adjoins || !room) << taken.size();
    if (!adjoins) ++ranges;
  }
  EXPECT_LE(pages.held(), ranges * page);
  for (void* each : taken) pages.give(each, bytes);
  EXPECT_EQ(pages.held(), 0U);
}

// Pages in memory of a range of whole pages.
std::ptrdiff_t resident(void* begin, std::size_t bytes) {
  const auto small = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  std::vector<unsigned char> in(bytes / small, 0);
  EXPECT_EQ(::mincore(begin, bytes, in.data()), 0);
  return std::count_if(in.begin(), in.end(), [](unsigned char each) { return (each & 1U) != 0; });
}

TEST(HugePages, AreFirstTouchedByWhoFillsThem) {
  HugePages pages;
  const std::size_t bytes = 3 * page + page / 2;
  auto* const memory = static_cast<char*>(pages.take(bytes));
  EXPECT_EQ(resident(memory - page / 2, 4 * page), 0);
  pages.give(memory, bytes);
}

TEST(HugePages, RefuseWhatDoesNotExist) {
  HugePages pages;
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  for (const std::size_t bytes : {most, most - page, most / 2}) {
    EXPECT_THROW(pages.take(bytes), std::bad_alloc);
  }
  EXPECT_EQ(pages.held(), 0U);
}

}  // namespace
}  // namespace raybundle::linalg
