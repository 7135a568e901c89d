// Control groups that are laid out as files: of both versions, nested, unlimited, absent, damaged.

#include <raybundle/linalg/control_group.h>

#include <filesystem>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/tests/support/temporary_folder.h>

namespace raybundle::linalg {
namespace {

constexpr double no_limit = std::numeric_limits<double>::max();

class ControlGroup : public testing::Test {
 protected:
  /// The group that this process is in.
  void join(const std::string& lines) { put("proc/self/cgroup", lines); }

  /// A figure of a group, beneath the mount.
  void tell(const std::string& file, const std::string& text) {
    put("sys/fs/cgroup/" + file, text);
  }

  double memory() const { return control_group_memory(folder_.path().string()); }
  double processors() const { return control_group_processors(folder_.path().string()); }

 private:
  void put(const std::string& file, const std::string& text) {
    const std::filesystem::path path = folder_ / file;
    std::filesystem::create_directories(path.parent_path());
    test::write_text(path, text);
  }

  test::TemporaryFolder folder_;
};

TEST_F(ControlGroup, MemoryIsLeftByTheTightestOfAllAbove) {
  join("0::/batch/job/step\n");
  tell("batch/memory.max", "1000\n");
  tell("batch/memory.current", "950\n");
  tell("batch/memory.stat", "anon 600\nfile 350\ninactive_file 150\nactive_file 200\n");
  tell("batch/job/memory.max", "500\n");
  tell("batch/job/memory.current", "100\n");
  tell("batch/job/step/memory.max", "max\n");
  tell("batch/job/step/memory.current", "90\n");
  EXPECT_EQ(memory(), 200);  // of batch, for what nobody has read lately is dropped at need
  tell("batch/job/memory.current", "450\n");
  EXPECT_EQ(memory(), 50);
  tell("batch/job/step/memory.max", "95\n");
  EXPECT_EQ(memory(), 5);
}

TEST_F(ControlGroup, MemoryIsNeverNegativeNorMoreThanTheLimit) {
  join("0::/\n");
  tell("memory.max", "1000\n");
  EXPECT_EQ(memory(), 1000);
  tell("memory.current", "1200\n");
  EXPECT_EQ(memory(), 0);
  tell("memory.stat", "inactive_file 5000\n");
  EXPECT_EQ(memory(), 1000);
}

TEST_F(ControlGroup, WithoutALimitAllIsLeft) {
  EXPECT_EQ(memory(), no_limit);  // no groups at all
  EXPECT_EQ(processors(), no_limit);
  join("0::/job\n");
  EXPECT_EQ(memory(), no_limit);  // not mounted
  EXPECT_EQ(processors(), no_limit);
  tell("job/memory.max", "max\n");
  tell("job/memory.current", "12345\n");
  tell("job/cpu.max", "max 100000\n");
  EXPECT_EQ(memory(), no_limit);
  EXPECT_EQ(processors(), no_limit);
}

TEST_F(ControlGroup, ProcessorsAreTheLeastQuotaOfAllAbove) {
  join("0::/batch/job\n");
  tell("batch/cpu.max", "400000 100000\n");
  tell("batch/job/cpu.max", "max 100000\n");
  EXPECT_EQ(processors(), 4);
  tell("batch/job/cpu.max", "75000 50000\n");
  EXPECT_EQ(processors(), 1.5);
}

TEST_F(ControlGroup, OfVersionOneEachControllerHasItsOwnGroup) {
  join("12:cpuset:/other\n9:cpu,cpuacct:/shares\n4:memory:/box/inner\n1:name=systemd:/x\n0::/\n");
  tell("memory/memory.limit_in_bytes", "9223372036854771712\n");
  tell("memory/memory.usage_in_bytes", "123456789\n");
  tell("cpu/cpu.cfs_quota_us", "-1\n");
  tell("cpu/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(memory(), no_limit);
  EXPECT_EQ(processors(), no_limit);
  tell("memory/box/memory.limit_in_bytes", "5000\n");
  tell("memory/box/memory.usage_in_bytes", "4000\n");
  tell("memory/box/memory.stat", "inactive_file 1\ntotal_inactive_file 300\n");
  tell("memory/other/memory.limit_in_bytes", "7\n");
  tell("cpu/shares/cpu.cfs_quota_us", "250000\n");
  tell("cpu/shares/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(memory(), 1300);
  EXPECT_EQ(processors(), 2.5);
}

// Such as a container without a name space of its own for groups.
TEST_F(ControlGroup, ThePathMayBeThatOfTheHost) {
  join("4:memory:/docker/0123abcd\n0::/docker/0123abcd\n");
  tell("memory/memory.limit_in_bytes", "800\n");
  tell("memory/memory.usage_in_bytes", "200\n");
  tell("cpu.max", "50000 100000\n");
  EXPECT_EQ(memory(), 600);
  EXPECT_EQ(processors(), 0.5);
}

TEST_F(ControlGroup, WhatMakesNoSenseLimitsNothing) {
  for (const char* lines : {"", "\n", "0\n", "0:\n", "::\n", "0::job", "0::///", "a:b:c:d"}) {
    join(lines);
    EXPECT_EQ(memory(), no_limit) << lines;
    EXPECT_EQ(processors(), no_limit) << lines;
  }
  join("garbage\n5:pids:/job\n0::/job\n");
  for (const char* text : {"", "\n", "none", "-5", "- 5"}) {
    tell("job/memory.max", text);
    tell("job/cpu.max", text);
    EXPECT_EQ(memory(), no_limit) << text;
    EXPECT_EQ(processors(), no_limit) << text;
  }
  tell("job/cpu.max", "100000 0\n");
  EXPECT_EQ(processors(), no_limit);
  tell("job/memory.max", "1000\n");
  tell("job/memory.current", "much\n");
  tell("job/memory.stat", "inactive_file\nactive_file lots\n");
  EXPECT_EQ(memory(), 1000);
}

TEST(OwnControlGroup, LeavesSomething) {
  EXPECT_GT(control_group_memory(), 0);
  EXPECT_GT(control_group_processors(), 0);
}

}  // namespace
}  // namespace raybundle::linalg
