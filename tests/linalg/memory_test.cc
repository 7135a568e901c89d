// What is available is no more than the limits of the process leave.

#include <raybundle/linalg/memory.h>
#include <raybundle/linalg/system_file.h>

#include <sys/resource.h>

#include <utility>

#include <gtest/gtest.h>

namespace raybundle::linalg {
namespace {

using Resource = decltype(RLIMIT_DATA);

constexpr double mebi = 1024.0 * 1024.0;

/// A limit of this process, for as long as this lives.
class Limit {
 public:
  Limit(Resource resource, double bytes) : resource_(resource) {
    ::getrlimit(resource_, &before_);
    rlimit limit = before_;
    limit.rlim_cur = static_cast<rlim_t>(bytes);
    set_ = ::setrlimit(resource_, &limit) == 0;
  }
  ~Limit() { ::setrlimit(resource_, &before_); }
  Limit(const Limit&) = delete;
  Limit& operator=(const Limit&) = delete;

  bool set() const { return set_; }

 private:
  Resource resource_;
  rlimit before_ = {};
  bool set_ = false;
};

TEST(AvailableMemory, IsBoundedByTheLimitsOfTheProcess) {
  constexpr double room = 256 * mebi, slack = 64 * mebi;
  if (available_memory() < 2 * room) GTEST_SKIP() << "the machine has too little for this";
  using Pair = std::pair<Resource, const char*>;
  for (const auto& [resource, key] : {Pair{RLIMIT_DATA, "VmData:"}, Pair{RLIMIT_AS, "VmSize:"}}) {
    const double used = 1024 * number_in("/proc/self/status", key).value_or(0);
    ASSERT_GT(used, 0);
    {
      const Limit limit(resource, used + room);
      ASSERT_TRUE(limit.set());
      EXPECT_NEAR(available_memory(), room, slack) << key;
      EXPECT_THROW(require_memory(room + slack, "a test"), MemoryRefusal) << key;
    }
    EXPECT_GT(available_memory(), room + slack) << key;
  }
}

TEST(AvailableMemory, IsMoreThanNothingAndSoIsWhatIsTaken) {
  EXPECT_GT(available_memory(), mebi);
  EXPECT_GT(resident_memory(), mebi / 4);
}

}  // namespace
}  // namespace raybundle::linalg
