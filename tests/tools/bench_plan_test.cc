// What a bench is to run, and which of it has been run.

#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tests/support/temporary_folder.h>
#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/bench_stamp.h>
#include <raybundle/tools/commands.h>

namespace raybundle::tools {
namespace {

using test::TemporaryFolder;
using test::write_text;
using Words = std::vector<std::string>;

TEST(BenchPlan, WordsOfACommandLine) {
  EXPECT_EQ(split_words("  a\tb  c "), (Words{"a", "b", "c"}));
  EXPECT_EQ(split_words("a 'b  c' \"d'e\" f'g'"), (Words{"a", "b  c", "d'e", "fg"}));
  EXPECT_EQ(split_words("''"), Words{""});
  EXPECT_TRUE(split_words(" ").empty());
  EXPECT_THROW(split_words("a 'b"), OptionError);
}

TEST(BenchPlan, TheLastOptionOfANameCounts) {
  const Words merged = merge_options({{"--a", "1", "--b", "2"}, {"--c"}, {"--a=3"}});
  EXPECT_EQ(merged, (Words{"--b", "2", "--c", "--a", "3"}));
  EXPECT_THROW(merge_options({{"1"}}), OptionError);
}

TEST(BenchPlan, ProblemsVariantsAndTheirNames) {
  const TemporaryFolder folder;
  const std::string odd = (folder / "a=b:c.txt").string();
  write_text(odd, "");
  BenchArguments arguments;
  arguments.problems = {"data/problem 49.txt.bz2", "p=x.txt:t.txt", odd, "q=" + odd};
  arguments.scenes = {"s=sphere --cameras 10"};
  arguments.variants = {"lm=--method lm-cholesky --max-iterations 7"};
  arguments.common = "--max-iterations 9 --lens fixed";
  arguments.best = {"p=12.5"};
  const BenchPlan plan = make_plan(arguments, "out");
  ASSERT_EQ(plan.problems.size(), 5u);
  EXPECT_EQ(plan.problems[0].name, "problem-49");
  EXPECT_EQ(plan.problems[1].file, "x.txt");
  EXPECT_EQ(plan.problems[1].truth, "t.txt");
  EXPECT_EQ(plan.problems[1].best, 12.5);
  EXPECT_EQ(plan.problems[2].file, odd);
  EXPECT_EQ(plan.problems[3].name, "q");
  EXPECT_EQ(plan.problems[3].file, odd);
  EXPECT_EQ(plan.problems[4].generate, (Words{"sphere", "--cameras", "10"}));
  EXPECT_EQ(plan.problems[4].file, "out/problems/s.txt");
  ASSERT_EQ(plan.variants.size(), 1u);
  EXPECT_EQ(plan.variants[0].options,
            (Words{"--threads", "1", "--time-limit", "300", "--lens", "fixed", "--method",
                   "lm-cholesky", "--max-iterations", "7"}));
  EXPECT_EQ(plan.run_path(plan.problems[4], plan.variants[0], 2), "out/runs/s/lm/2");
}

TEST(BenchPlan, ATruthNeedsNoName) {
  const TemporaryFolder folder;
  const std::string file = (folder / "a.txt").string();
  BenchArguments arguments;
  arguments.problems = {"b.txt:t=1/b.truth.txt"};
  EXPECT_THROW(make_plan(arguments, "out"), OptionError) << "'b.txt:t' is no name";
  write_text(file, "");
  arguments.problems = {"d/b.txt:bt.txt", file + ":t=1/a.txt"};
  const BenchPlan plan = make_plan(arguments, "out");
  EXPECT_EQ(plan.problems[0].name, "b");
  EXPECT_EQ(plan.problems[0].file, "d/b.txt");
  EXPECT_EQ(plan.problems[0].truth, "bt.txt");
  EXPECT_EQ(plan.problems[1].name, "a");
  EXPECT_EQ(plan.problems[1].file, file);
  EXPECT_EQ(plan.problems[1].truth, "t=1/a.txt");
}

// Costs of a loss do not compare with the others'.
TEST(BenchPlan, EveryMethodOfPlainSquaresWhenNoneIsNamed) {
  const BenchPlan plan = make_plan({}, "out");
  std::size_t at = 0;
  for (int i = 0; i < enum_count<Method>; ++i) {
    const auto method = static_cast<Method>(i);
    if (resolve({.method = method}).loss != Loss::none) continue;
    ASSERT_LT(at, plan.variants.size());
    EXPECT_EQ(plan.variants[at++].name, name(method));
  }
  EXPECT_EQ(at, plan.variants.size());
}

TEST(BenchPlan, RefusesWhatMakesNoSense) {
  const auto refused = [](auto&& change) {
    BenchArguments arguments;
    arguments.problems = {"p=x"};
    change(arguments);
    EXPECT_THROW(make_plan(arguments, "out"), OptionError);
  };
  refused([](auto& a) { a.problems.push_back("p=y"); });
  refused([](auto& a) { a.problems = {"../p=y"}; });
  refused([](auto& a) { a.problems = {"=y"}; });
  refused([](auto& a) { a.problems = {"p=y:"}; });
  refused([](auto& a) { a.problems = {":t"}; });
  refused([](auto& a) { a.scenes = {"s"}; });
  refused([](auto& a) { a.scenes = {"s= "}; });
  refused([](auto& a) { a.variants = {"v=", "v="}; });
  refused([](auto& a) { a.ceres_variants = {"v="}; });
  refused([](auto& a) { a.best = {"q=1"}; });
  refused([](auto& a) { a.best = {"p=1x"}; });
  refused([](auto& a) { a.runs = 0; });
  refused([](auto& a) { a.time_limit = 0; });
}

TEST(BenchPlan, ArgumentsSurviveTheFile) {
  BenchArguments arguments;
  arguments.scenes = {"s=a 'b c'"};
  arguments.time_limit = 0.1;
  arguments.memory_limit = 1ull << 40;
  const std::string text = to_json(arguments);
  EXPECT_EQ(to_json(bench_arguments(text, "x")), text);
  EXPECT_EQ(bench_arguments(text, "x").memory_limit, 1ull << 40);
  EXPECT_THROW(bench_arguments("{}", "x"), InputError);
  EXPECT_THROW(bench_arguments("", "x"), InputError);
}

class BenchStamp : public testing::Test {
 protected:
  BenchStamp() { write_text(problem_.file, "content"); }
  std::string stamp() const {
    return run_stamp(problem_, variant_, arguments_, program_, "processor");
  }

  TemporaryFolder folder_;
  BenchProblem problem_{"p", folder_ / "p.txt", {}, {}, 0};
  BenchVariant variant_{"v", BenchSolver::raybundle, {"--a", "1"}};
  BenchArguments arguments_;
  BenchProgram program_{"program", "0123"};
};

TEST_F(BenchStamp, ChangesWithEverythingThatARunDependsOn) {
  const std::string before = stamp();
  EXPECT_EQ(stamp(), before);
  variant_.options = {"--a", "2"};
  EXPECT_NE(stamp(), before);
  variant_.options = {"--a 1"};  // other words, though the same letters
  EXPECT_NE(stamp(), before);
  variant_.options = {"--a", "1"};
  program_.hash = "0124";
  EXPECT_NE(stamp(), before);
  program_.hash = "0123";
  arguments_.memory_limit = 1;
  EXPECT_NE(stamp(), before);
  arguments_.memory_limit = 0;
  EXPECT_EQ(stamp(), before);
  write_text(problem_.file, "other content");
  EXPECT_NE(stamp(), before);
  write_text(problem_.file, "content");
  const std::string again = stamp();  // at another time
  problem_.truth = problem_.file;
  EXPECT_NE(stamp(), again);
  problem_.truth = folder_ / "none";
  EXPECT_THROW(stamp(), std::system_error);
}

TEST_F(BenchStamp, DoesNotDependOnTheFolder) {
  const std::string before = stamp();
  std::filesystem::rename(problem_.file, folder_ / "moved.txt");
  problem_.file = folder_ / "moved.txt";
  EXPECT_EQ(stamp(), before);
}

TEST_F(BenchStamp, ProgramsAreToldApartByContent) {
  write_text(folder_ / "a", "one");
  write_text(folder_ / "b", "two");
  write_text(folder_ / "c", "one");
  EXPECT_EQ(bench_program(folder_ / "a").hash, bench_program(folder_ / "c").hash);
  EXPECT_NE(bench_program(folder_ / "a").hash, bench_program(folder_ / "b").hash);
  EXPECT_THROW(bench_program(folder_ / "none"), std::system_error);
}

TEST_F(BenchStamp, AnOutcomeSurvivesItsFileAndATornOneIsNone) {
  RunOutcome outcome{"stamp", RunStatus::crashed, -1, 11, 1.5, 1 << 20, "line \"x\""};
  save_outcome(folder_ / "o", outcome);
  const auto read = load_outcome(folder_ / "o");
  ASSERT_TRUE(read);
  EXPECT_EQ(read->stamp, "stamp");
  EXPECT_EQ(read->status, RunStatus::crashed);
  EXPECT_EQ(read->signal, 11);
  EXPECT_EQ(read->message, outcome.message);
  const std::string text = test::read_text(folder_ / "o");
  for (std::size_t size = 0; size + 3 < text.size(); ++size) {
    write_text(folder_ / "torn", text.substr(0, size));
    EXPECT_FALSE(load_outcome(folder_ / "torn"));
  }
  EXPECT_FALSE(load_outcome(folder_ / "none"));
}

TEST(BenchOutcome, JudgedByHowTheProgramEnded) {
  const auto status = [](const ProcessResult& result, bool has_log = true,
                         BenchSolver solver = BenchSolver::raybundle) {
    return judge(result, solver, has_log, "s").status;
  };
  const auto code = [](ExitCode exit) { return ProcessResult{.code = static_cast<int>(exit)}; };
  EXPECT_EQ(status(code(ExitCode::usable)), RunStatus::ok);
  EXPECT_EQ(status(code(ExitCode::usable), false), RunStatus::error);
  EXPECT_EQ(status(code(ExitCode::numerical_failure)), RunStatus::failed);
  EXPECT_EQ(status(code(ExitCode::no_memory), false), RunStatus::no_memory);
  EXPECT_EQ(status(code(ExitCode::usage), false), RunStatus::refused);
  EXPECT_EQ(status(code(ExitCode::bad_input), false), RunStatus::refused);
  EXPECT_EQ(status(code(ExitCode::interrupted)), RunStatus::interrupted);
  EXPECT_EQ(status({.signal = 11}), RunStatus::crashed);
  EXPECT_EQ(status({.signal = 6, .output = "what(): std::bad_alloc"}), RunStatus::no_memory);
  EXPECT_EQ(status({.signal = 15, .timed_out = true}), RunStatus::time_limit);
  EXPECT_EQ(status({.code = 0, .interrupted = true}), RunStatus::interrupted);
  EXPECT_EQ(status({.code = 2}, false, BenchSolver::ceres), RunStatus::refused);
}

TEST(BenchOutcome, OnlyWhatCameToAnEndOfItsOwnStands) {
  const auto standing = [](RunStatus status, bool has_log) {
    RunOutcome outcome;
    outcome.stamp = "s";
    outcome.status = status;
    EXPECT_FALSE(stands(outcome, "t", has_log));
    return stands(outcome, "s", has_log);
  };
  EXPECT_TRUE(standing(RunStatus::ok, true));
  EXPECT_FALSE(standing(RunStatus::ok, false));
  EXPECT_TRUE(standing(RunStatus::failed, true));
  EXPECT_TRUE(standing(RunStatus::time_limit, false));
  EXPECT_TRUE(standing(RunStatus::no_memory, false));
  for (const auto status : {RunStatus::refused, RunStatus::error, RunStatus::interrupted}) {
    EXPECT_FALSE(standing(status, true));
  }
}

}  // namespace
}  // namespace raybundle::tools
