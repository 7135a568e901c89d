#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <type_traits>

/// Threads and deterministic loops over them.
namespace raybundle::linalg {

/// Cores of this process: those that the scheduler's affinity mask allows, or as many as control
/// groups give time for, rounded up, if these are fewer; at least 1.
int available_threads();

/// A fixed crew of worker threads; the calling thread works too. Idle workers spin for some
/// microseconds, so that calls in quick succession start fast, and then sleep.
class ThreadPool {
 public:
  /// `threads` >= 1, the caller included (smaller values count as 1). With 1 everything runs inline
  /// and no thread is started. Throws std::system_error when the system refuses a thread.
  explicit ThreadPool(int threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const { return threads_; }

  /// Calls task(chunk) for every chunk in [0, chunks), each exactly once and from any thread, and
  /// returns when all are done. Chunks are *started* in ascending order, so a task may wait for a
  /// lower chunk without deadlock. After an exception no further chunk is started, and the first
  /// exception is rethrown here. A call from inside a task, or while another thread's call is
  /// under way, runs inline. Nothing is allocated.
  template <class Task>
  void run(std::int64_t chunks, Task&& task) {
    using Plain = std::remove_reference_t<Task>;
    run_erased(
        chunks, [](void* context, std::int64_t chunk) { (*static_cast<Plain*>(context))(chunk); },
        const_cast<void*>(static_cast<const void*>(std::addressof(task))));
  }

 private:
  using Call = void (*)(void* context, std::int64_t chunk);
  struct Crew;

  void run_erased(std::int64_t chunks, Call call, void* context);

  int threads_;
  std::unique_ptr<Crew> crew_;  ///< empty when threads_ == 1
};

/// The range [0, count) cut into nearly equal pieces.
struct Chunks {
  std::int64_t count = 0;
  std::int64_t pieces = 0;

  std::int64_t begin(std::int64_t i) const {
    return count / pieces * i + std::min(i, count % pieces);
  }
  std::int64_t end(std::int64_t i) const { return begin(i + 1); }
};

/// The largest number of pieces a loop is cut into.
inline constexpr std::int64_t max_chunks = 64;

/// Splits [0, count) into at most `max_pieces` pieces of at least `grain` items (one piece when
/// there are fewer; none when count is 0). The pieces depend on the arguments only, never on the
/// number of threads: sums over pieces in order have the same bits for any number of threads.
inline Chunks chunks(std::int64_t count, std::int64_t grain, std::int64_t max_pieces = max_chunks) {
  if (count <= 0) return {};
  const std::int64_t wanted = count / std::max<std::int64_t>(grain, 1);
  return {count, std::clamp<std::int64_t>(wanted, 1, std::max<std::int64_t>(max_pieces, 1))};
}

/// Calls body(begin, end) for the pieces of [0, count), in any order and from any thread.
template <class Body>
void parallel_for(ThreadPool& pool, std::int64_t count, std::int64_t grain, Body&& body) {
  const Chunks split = chunks(count, grain);
  pool.run(split.pieces, [&](std::int64_t i) { body(split.begin(i), split.end(i)); });
}

/// The sum of body(begin, end) over the pieces of [0, count), added in the order of the pieces.
template <class Body>
double parallel_sum(ThreadPool& pool, std::int64_t count, std::int64_t grain, Body&& body) {
  const Chunks split = chunks(count, grain);
  std::array<double, max_chunks> partial;
  pool.run(split.pieces, [&](std::int64_t i) {
    partial[static_cast<std::size_t>(i)] = body(split.begin(i), split.end(i));
  });
  double sum = 0.0;
  for (std::int64_t i = 0; i < split.pieces; ++i) sum += partial[static_cast<std::size_t>(i)];
  return sum;
}

}  // namespace raybundle::linalg
