#include <raybundle/linalg/parallel.h>

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#if defined(__linux__)
#include <sched.h>
#endif

#include <raybundle/linalg/control_group.h>
#include <raybundle/linalg/cpu.h>

namespace raybundle::linalg {
namespace {

/// Pauses before a waiting thread goes to sleep: some ten microseconds.
constexpr int spins = 400;

/// A ticket is the number of the job (high half) and how many of its chunks are yet to be started
/// (low half).
constexpr std::int64_t max_job_chunks = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint64_t job_of(std::uint64_t ticket) { return ticket >> 32U; }
constexpr std::uint64_t remaining_in(std::uint64_t ticket) { return ticket & 0xffffffffU; }

int allowed_cores() {
#if defined(__linux__)
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof set, &set) == 0) return CPU_COUNT(&set);
#endif
  return static_cast<int>(std::thread::hardware_concurrency());
}

}  // namespace

int available_threads() {
  const double quota = std::ceil(control_group_processors());
  return std::max(1, static_cast<int>(std::min<double>(allowed_cores(), quota)));
}

/// How a job runs. The caller writes the job's fields, then publishes a ticket with a new job
/// number. Everyone starts a chunk by counting the ticket down with a compare-exchange. The fields
/// change only when every chunk of the old job was started and finished, so a compare-exchange that
/// succeeds proves that the fields read before it belong to that job; a thread that was late fails
/// and forgets what it read. Hence the fields are relaxed atomics without a lock, and the caller
/// never waits for threads that got no work.
struct ThreadPool::Crew {
  std::atomic<std::uint64_t> ticket{0};
  std::atomic<Call> call{nullptr};
  std::atomic<void*> context{nullptr};
  std::atomic<std::uint64_t> chunks{0};
  std::atomic<std::uint64_t> unfinished{0};
  std::atomic<bool> failed{false};
  std::atomic<bool> busy{false};  ///< a run() is under way

  // Sequentially consistent pairs: a sleeper announces itself and then looks again, a waker
  // changes the state and then looks for sleepers. One of the two sees the other.
  std::atomic<int> sleeping_workers{0};
  std::atomic<bool> sleeping_caller{false};
  std::atomic<bool> stop{false};
  std::mutex mutex;  ///< guards the two conditions and `error`
  std::condition_variable work_arrived;
  std::condition_variable work_done;
  std::exception_ptr error;
  std::vector<std::thread> threads;

  ~Crew() {
    stop.store(true);
    {
      const std::lock_guard lock(mutex);
      work_arrived.notify_all();
    }
    for (std::thread& thread : threads) thread.join();
  }

  bool has_work() const { return remaining_in(ticket.load()) > 0; }

  void work_on_current_job() {
    std::uint64_t now = ticket.load(std::memory_order_acquire);
    const std::uint64_t job = job_of(now);
    const Call job_call = call.load(std::memory_order_relaxed);
    void* const job_context = context.load(std::memory_order_relaxed);
    const std::uint64_t job_chunks = chunks.load(std::memory_order_relaxed);
    std::uint64_t finished = 0;
    while (job_of(now) == job && remaining_in(now) > 0) {
      if (!ticket.compare_exchange_weak(now, now - 1, std::memory_order_acq_rel,
                                        std::memory_order_acquire)) {
        continue;
      }
      execute(job_call, job_context, static_cast<std::int64_t>(job_chunks - remaining_in(now)));
      ++finished;
      now = ticket.load(std::memory_order_acquire);
    }
    if (finished > 0 && unfinished.fetch_sub(finished) == finished && sleeping_caller.load()) {
      const std::lock_guard lock(mutex);
      work_done.notify_one();
    }
  }

  void execute(Call job_call, void* job_context, std::int64_t chunk) {
    if (failed.load(std::memory_order_relaxed)) return;
    try {
      job_call(job_context, chunk);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!error) error = std::current_exception();
      failed.store(true, std::memory_order_relaxed);
    }
  }

  void worker() {
    while (wait_for_work()) work_on_current_job();
  }

  /// False when the crew is dismissed.
  bool wait_for_work() {
    for (int i = 0; i < spins; ++i) {
      if (stop.load(std::memory_order_relaxed)) return false;
      if (has_work()) return true;
      spin_pause();
    }
    std::unique_lock lock(mutex);
    sleeping_workers.fetch_add(1);
    work_arrived.wait(lock, [this] { return stop.load() || has_work(); });
    sleeping_workers.fetch_sub(1);
    return !stop.load();
  }

  void publish(std::int64_t job_chunks, Call job_call, void* job_context) {
    call.store(job_call, std::memory_order_relaxed);
    context.store(job_context, std::memory_order_relaxed);
    chunks.store(static_cast<std::uint64_t>(job_chunks), std::memory_order_relaxed);
    unfinished.store(static_cast<std::uint64_t>(job_chunks), std::memory_order_relaxed);
    failed.store(false, std::memory_order_relaxed);
    const std::uint64_t job = job_of(ticket.load(std::memory_order_relaxed)) + 1;
    ticket.store(job << 32U | static_cast<std::uint64_t>(job_chunks));
    const int asleep = sleeping_workers.load();
    if (asleep == 0) return;
    const std::lock_guard lock(mutex);
    for (std::int64_t i = 0; i < std::min<std::int64_t>(asleep, job_chunks - 1); ++i) {
      work_arrived.notify_one();
    }
  }

  void wait_until_done() {
    for (int i = 0; i < spins; ++i) {
      if (unfinished.load() == 0) return;
      spin_pause();
    }
    std::unique_lock lock(mutex);
    sleeping_caller.store(true);
    work_done.wait(lock, [this] { return unfinished.load() == 0; });
    sleeping_caller.store(false);
  }

  void run(std::int64_t job_chunks, Call job_call, void* job_context) {
    publish(job_chunks, job_call, job_context);
    work_on_current_job();
    wait_until_done();
    std::exception_ptr first;
    if (failed.load(std::memory_order_relaxed)) {
      const std::lock_guard lock(mutex);
      first = std::exchange(error, nullptr);
    }
    busy.store(false, std::memory_order_release);
    if (first) std::rethrow_exception(first);
  }
};

ThreadPool::ThreadPool(int threads) : threads_(std::max(1, threads)) {
  if (threads_ == 1) return;
  crew_ = std::make_unique<Crew>();
  crew_->threads.reserve(static_cast<std::size_t>(threads_ - 1));
  for (int i = 1; i < threads_; ++i) {
    crew_->threads.emplace_back([crew = crew_.get()] { crew->worker(); });
  }
}

ThreadPool::~ThreadPool() = default;

void ThreadPool::run_erased(std::int64_t chunks, Call call, void* context) {
  const bool alone = crew_ == nullptr || chunks <= 1 || chunks > max_job_chunks;
  if (alone || crew_->busy.exchange(true, std::memory_order_acq_rel)) {
    for (std::int64_t chunk = 0; chunk < chunks; ++chunk) call(context, chunk);
    return;
  }
  crew_->run(chunks, call, context);
}

}  // namespace raybundle::linalg
