// Child processes that are held to limits.

#include <unistd.h>

#include <csignal>
#include <string>

#include <gtest/gtest.h>

#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tools/bench_process.h>

namespace raybundle::tools {
namespace {

ProcessRequest shell(const std::string& script) { return {.command = {"/bin/sh", "-c", script}}; }

TEST(BenchProcess, TellsHowAProgramEnded) {
  const ProcessResult result = run_process(shell("echo out; echo err >&2; exit 7"));
  EXPECT_EQ(result.code, 7);
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.output, "out\nerr\n");
  EXPECT_GT(result.peak_bytes, 100'000);
  EXPECT_EQ(describe(result), "exit code 7");
  EXPECT_FALSE(result.timed_out || result.interrupted);
  const ProcessResult killed = run_process(shell("kill -ABRT $$"));
  EXPECT_EQ(killed.code, -1);
  EXPECT_EQ(killed.signal, SIGABRT);
  EXPECT_EQ(run_process({.command = {"/no/such/program"}}).code, 127);
}

TEST(BenchProcess, ComplaintIsOneLine) {
  const auto said = [](const std::string& output) {
    return complaint({.code = 2, .output = output});
  };
  EXPECT_EQ(said("a warning\nthe error\n"), "the error");
  EXPECT_EQ(said("one"), "one");
  EXPECT_EQ(said("ceres_driver: no\n  --threads 1\n"), "ceres_driver: no");
  EXPECT_EQ(said("\n"), "exit code 2");
}

TEST(BenchProcess, KeepsTheEndOfALongOutput) {
  const ProcessResult result = run_process(
      shell("i=0; while [ $i -lt 2000 ]; do echo line $i; i=$((i + 1)); done; echo last"));
  EXPECT_LT(result.output.size(), 10'000u);
  EXPECT_TRUE(result.output.ends_with("line 1999\nlast\n"));
}

TEST(BenchProcess, EnvironmentAndFolderAreTheChilds) {
  const test::TemporaryFolder folder;
  ProcessRequest request = shell("echo $RAYBUNDLE_TEST; pwd -P; cat");  // no input either
  request.environment = {{"RAYBUNDLE_TEST", "a b"}};
  request.folder = folder.path();
  EXPECT_EQ(run_process(request).output,
            "a b\n" + std::filesystem::canonical(folder.path()).string() + "\n");
}

TEST(BenchProcess, TimeLimitEndsIt) {
  ProcessRequest request{.command = {"/bin/sleep", "60"}, .seconds = 0.05};
  const ProcessResult result = run_process(request);
  EXPECT_TRUE(result.timed_out);
  EXPECT_EQ(result.signal, SIGTERM);
  EXPECT_LT(result.seconds, 30);
}

TEST(BenchProcess, OneThatDoesNotListenIsKilled) {
  ProcessRequest request = shell("trap '' TERM; while :; do sleep 0.01; done");
  request.seconds = 0.2;
  request.grace = 0.1;
  const ProcessResult result = run_process(request);
  EXPECT_TRUE(result.timed_out);
  EXPECT_EQ(result.signal, SIGKILL);
}

TEST(BenchProcess, MemoryLimitIsThatOfTheChild) {
  if (!limits_memory()) GTEST_SKIP() << "not with a sanitizer";
  // `tail` holds the whole of a line of zeros, for which a small limit has no room.
  ProcessRequest request = shell("head -c 60000000 /dev/zero | tail -n 1 > /dev/null");
  EXPECT_EQ(run_process(request).code, 0);
  request.bytes = 20'000'000;
  EXPECT_NE(run_process(request).code, 0);
}

TEST(BenchProcess, AnInterruptEndsTheChildAtOnce) {
  const InterruptGuard interrupt(false);
  ProcessRequest request{.command = {"/bin/sleep", "60"}};
  request.interrupt = &interrupt;
  ::raise(SIGTERM);
  const ProcessResult result = run_process(request);
  EXPECT_TRUE(result.interrupted);
  EXPECT_FALSE(result.timed_out);
  EXPECT_EQ(result.signal, SIGTERM);
}

TEST(BenchProcess, FindsProgramsAsAShellDoes) {
  EXPECT_FALSE(find_program("sh").empty());
  EXPECT_TRUE(find_program("no-such-program-anywhere").empty());
}

}  // namespace
}  // namespace raybundle::tools
