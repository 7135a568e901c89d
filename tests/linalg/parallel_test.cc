#include <raybundle/linalg/parallel.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace raybundle::linalg {
namespace {

std::size_t at(std::int64_t i) { return static_cast<std::size_t>(i); }

/// Counts how often each chunk of a run was called.
std::vector<int> calls_per_chunk(ThreadPool& pool, std::int64_t count) {
  std::vector<std::atomic<int>> calls(at(count));
  pool.run(count, [&](std::int64_t i) { calls[at(i)].fetch_add(1); });
  return {calls.begin(), calls.end()};
}

TEST(ThreadPool, CallsEveryChunkExactlyOnce) {
  for (const int threads : {1, 2, 3, 5}) {
    ThreadPool pool(threads);
    EXPECT_EQ(pool.threads(), threads);
    for (const std::int64_t count : {0, 1, 2, 3, 64, 1000}) {
      EXPECT_EQ(calls_per_chunk(pool, count), std::vector<int>(at(count), 1));
    }
  }
}

TEST(ThreadPool, FewerThanOneThreadCountsAsOne) {
  ThreadPool pool(0);
  EXPECT_EQ(pool.threads(), 1);
  EXPECT_EQ(calls_per_chunk(pool, 5), std::vector<int>(5, 1));
}

// Many short jobs in a row, so that late workers meet the next job; plain memory written by one job
// and read by the next shows missing synchronisation to the thread sanitizer.
TEST(ThreadPool, ShortJobsInQuickSuccessionSeeEachOthersWrites) {
  ThreadPool pool(3);
  constexpr int jobs = 5000;
  std::vector<std::int64_t> value(7, 0);
  for (int job = 0; job < jobs; ++job) {
    const std::int64_t count = 1 + job % 7;
    pool.run(count, [&](std::int64_t i) { value[at((i + 1) % 7)] += i + 1; });
  }
  std::vector<std::int64_t> expected(7, 0);
  for (int job = 0; job < jobs; ++job) {
    for (std::int64_t i = 0; i < 1 + job % 7; ++i) expected[at((i + 1) % 7)] += i + 1;
  }
  EXPECT_EQ(value, expected);
}

TEST(ThreadPool, WakesWorkersThatFellAsleep) {
  ThreadPool pool(2);
  for (int round = 0; round < 5; ++round) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    std::atomic<int> arrived{0};
    // Each of the two chunks waits for the other: it ends only if two threads take part.
    pool.run(2, [&](std::int64_t) {
      arrived.fetch_add(1);
      while (arrived.load() < 2) std::this_thread::yield();
    });
    EXPECT_EQ(arrived.load(), 2);
  }
}

TEST(ThreadPool, ChunksStartInAscendingOrder) {
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    std::vector<std::atomic<bool>> done(200);
    pool.run(200, [&](std::int64_t i) {
      if (i > 0) {
        while (!done[at(i - 1)].load()) std::this_thread::yield();
      }
      done[at(i)].store(true);
    });
    EXPECT_TRUE(done.back().load());
  }
}

TEST(ThreadPool, RethrowsAndStaysUsable) {
  for (const int threads : {1, 2, 3}) {
    ThreadPool pool(threads);
    for (int round = 0; round < 20; ++round) {
      std::atomic<int> calls{0};
      EXPECT_THROW(pool.run(50,
                            [&](std::int64_t i) {
                              calls.fetch_add(1);
                              if (i == 3) throw std::runtime_error("three");
                            }),
                   std::runtime_error);
      EXPECT_GE(calls.load(), 1);
      EXPECT_LE(calls.load(), 50);
      EXPECT_EQ(calls_per_chunk(pool, 10), std::vector<int>(10, 1));
    }
  }
}

TEST(ThreadPool, NestedRunsWorkInline) {
  ThreadPool pool(3);
  std::atomic<int> inner{0};
  std::atomic<int> strayed{0};
  pool.run(8, [&](std::int64_t) {
    const auto outer_thread = std::this_thread::get_id();
    pool.run(4, [&](std::int64_t) {
      inner.fetch_add(1);
      if (std::this_thread::get_id() != outer_thread) strayed.fetch_add(1);
    });
  });
  EXPECT_EQ(inner.load(), 32);
  EXPECT_EQ(strayed.load(), 0);
}

TEST(ThreadPool, MayBeSharedByTwoCallers) {
  ThreadPool pool(2);
  std::atomic<int> calls{0};
  const auto work = [&] {
    for (int i = 0; i < 500; ++i) pool.run(6, [&](std::int64_t) { calls.fetch_add(1); });
  };
  std::thread other(work);
  work();
  other.join();
  EXPECT_EQ(calls.load(), 2 * 500 * 6);
}

TEST(Chunks, CoverTheRangeWithPiecesOfTheGrain) {
  for (const std::int64_t count : {1, 2, 63, 64, 65, 100, 1000, 123457}) {
    for (const std::int64_t grain : {0, 1, 7, 64, 5000}) {
      const Chunks split = chunks(count, grain);
      ASSERT_GE(split.pieces, 1);
      ASSERT_LE(split.pieces, max_chunks);
      std::int64_t next = 0;
      for (std::int64_t i = 0; i < split.pieces; ++i) {
        EXPECT_EQ(split.begin(i), next);
        next = split.end(i);
        EXPECT_GE(next - split.begin(i), std::min(count, std::max<std::int64_t>(grain, 1)));
      }
      EXPECT_EQ(next, count);
    }
  }
  EXPECT_EQ(chunks(0, 10).pieces, 0);
  EXPECT_EQ(chunks(1000, 10, 5).pieces, 5);
}

TEST(ParallelFor, VisitsEveryItemOnce) {
  ThreadPool pool(3);
  std::vector<int> visits(1003, 0);
  parallel_for(pool, 1003, 10, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) ++visits[at(i)];
  });
  EXPECT_EQ(visits, std::vector<int>(1003, 1));
  parallel_for(pool, 0, 10, [](std::int64_t, std::int64_t) { ADD_FAILURE() << "no items"; });
}

TEST(ParallelSum, SameBitsForAnyNumberOfThreads) {
  const auto sum = [](int threads) {
    ThreadPool pool(threads);
    return parallel_sum(pool, 100003, 100, [](std::int64_t begin, std::int64_t end) {
      double partial = 0.0;
      for (std::int64_t i = begin; i < end; ++i) partial += std::sin(static_cast<double>(i)) * 1e3;
      return partial;
    });
  };
  const double one = sum(1);
  for (int repeat = 0; repeat < 10; ++repeat) {
    EXPECT_EQ(sum(2), one);
    EXPECT_EQ(sum(3), one);
  }
  ThreadPool pool(2);
  EXPECT_EQ(parallel_sum(pool, 0, 1, [](std::int64_t, std::int64_t) { return 1.0; }), 0.0);
}

TEST(AvailableThreads, IsAtLeastOne) { EXPECT_GE(available_threads(), 1); }

}  // namespace
}  // namespace raybundle::linalg
