#include <raybundle/tools/bench_runner.h>

#include <algorithm>
#include <cstdio>
#include <optional>
#include <system_error>

#include <raybundle/models/io/atomic_file.h>
#include <raybundle/tools/bench_machine.h>
#include <raybundle/tools/bench_prepare.h>
#include <raybundle/tools/bench_process.h>
#include <raybundle/tools/bench_results.h>
#include <raybundle/tools/bench_stamp.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

namespace fs = std::filesystem;

void say(const std::string& line) { std::fputs((line + "\n").c_str(), stderr); }

fs::path with(const fs::path& base, const char* ending) { return base.string() + ending; }

struct Job {
  const BenchProblem* problem;
  const BenchVariant* variant;
  int run;
  std::string stamp;
};

class Runner {
 public:
  Runner(const BenchPlan& plan, const InterruptGuard& interrupt)
      : plan_(plan),
        interrupt_(interrupt),
        ours_(bench_program(fs::read_symlink("/proc/self/exe"))),
        machine_(this_machine()) {
    if (!plan.arguments.ceres.empty()) ceres_ = bench_program(plan.arguments.ceres);
    for (const BenchProblem& problem : plan.problems) {
      problem_width_ = std::max(problem_width_, static_cast<int>(problem.name.size()));
    }
    for (const BenchVariant& variant : plan.variants) {
      variant_width_ = std::max(variant_width_, static_cast<int>(variant.name.size()));
    }
  }

  RunCounts run(const std::function<void()>& accept) {
    check();
    NewScenes scenes(plan_);
    scenes.make(ours_.path, interrupt_);
    if (interrupted()) return finished();
    fs::create_directories(plan_.folder);
    accept();
    scenes.put_in_place();
    counts_.accepted = true;
    const std::vector<Job> jobs = open_jobs();
    io::write_file_atomically(plan_.folder / "machine.json", to_json(machine_));
    if (counts_.kept > 0) {
      say(count_text(counts_.kept, "run") + " of an earlier call kept, " +
          std::to_string(jobs.size()) + " to be done");
    }
    for (const Job& job : jobs) {
      if (interrupted()) break;
      const RunOutcome outcome = run_one(job);
      if (outcome.status == RunStatus::interrupted) break;
      ++counts_.done;
      const bool refused =
          outcome.status == RunStatus::refused || outcome.status == RunStatus::error;
      if (refused) ++counts_.refused;
      tell(job, outcome, jobs.size());
    }
    return finished();
  }

 private:
  bool interrupted() const { return interrupt_.signal() != nullptr; }
  RunCounts finished() {
    counts_.interrupted = interrupted();
    return counts_;
  }

  /// Finds out whatever is wrong with the plan. Of files that would be read by no run only whether
  /// they are there matters.
  void check() const {
    check_variants(plan_);
    check_files_exist(plan_);
    for (const BenchProblem& problem : plan_.problems) {
      if (interrupted()) return;
      if (problem.generate.empty() && has_open_runs(problem)) check_content(problem);
    }
  }

  bool has_open_runs(const BenchProblem& problem) const {
    for (const BenchVariant& variant : plan_.variants) {
      const std::string stamp = stamp_of(problem, variant);
      for (int run = 1; run <= plan_.arguments.runs; ++run) {
        if (!is_done(problem, variant, run, stamp)) return true;
      }
    }
    return false;
  }

  std::string stamp_of(const BenchProblem& problem, const BenchVariant& variant) const {
    return run_stamp(problem, variant, plan_.arguments, program(variant), machine_.processor);
  }

  bool is_done(const BenchProblem& problem, const BenchVariant& variant, int run,
               const std::string& stamp) const {
    const fs::path base = plan_.run_path(problem, variant, run);
    const auto outcome = load_outcome(with(base, ".run.json"));
    return outcome && stands(*outcome, stamp, fs::exists(with(base, ".json")));
  }

  /// All runs that no earlier call has done, in order.
  std::vector<Job> open_jobs() {
    std::vector<Job> jobs;
    for (int run = 1; run <= plan_.arguments.runs; ++run) {
      for (const BenchProblem& problem : plan_.problems) {
        for (const BenchVariant& variant : plan_.variants) {
          Job job{&problem, &variant, run, stamp_of(problem, variant)};
          if (is_done(problem, variant, run, job.stamp)) {
            ++counts_.kept;
          } else {
            jobs.push_back(std::move(job));
          }
        }
      }
    }
    return jobs;
  }

  const BenchProgram& program(const BenchVariant& variant) const {
    return variant.solver == BenchSolver::ceres ? ceres_ : ours_;
  }

  ProcessRequest request(const Job& job, const fs::path& base) const {
    const std::string log = with(base, ".json").string();
    const std::string file = job.problem->file.string();
    ProcessRequest request{.command = {program(*job.variant).path.string()}};
    if (job.variant->solver == BenchSolver::ceres) {
      request.command.insert(request.command.end(), {file, "--output", log});
    } else {
      request.command.insert(request.command.end(), {"solve", file, "-q", "--log", log});
      if (!job.problem->truth.empty()) {
        request.command.insert(request.command.end(), {"-o", with(base, ".solution").string()});
      }
    }
    const auto& options = job.variant->options;
    request.command.insert(request.command.end(), options.begin(), options.end());
    // Both solvers thread by themselves; a BLAS that threads beneath them only gets in their way.
    request.environment = {{"OPENBLAS_NUM_THREADS", "1"}};
    // The solver stops by itself; reading and one long iteration come on top.
    request.seconds = 1.25 * plan_.arguments.time_limit + 10;
    request.grace = 10;
    request.bytes = plan_.arguments.memory_limit > 0 ? plan_.arguments.memory_limit
                                                     : static_cast<std::uint64_t>(machine_.memory);
    request.interrupt = &interrupt_;
    return request;
  }

  RunOutcome run_one(const Job& job) {
    const fs::path base = plan_.run_path(*job.problem, *job.variant, job.run);
    fs::create_directories(base.parent_path());
    for (const char* ending : {".run.json", ".json", ".eval.json"}) fs::remove(with(base, ending));
    const ProcessResult result = run_process(request(job, base));
    const fs::path log = with(base, ".json");
    RunOutcome outcome = judge(result, job.variant->solver, fs::exists(log), job.stamp);
    compare_with_truth(job, base);
    if (outcome.status == RunStatus::interrupted) {
      fs::remove(log);
    } else {
      save_outcome(with(base, ".run.json"), outcome);
    }
    return outcome;
  }

  void compare_with_truth(const Job& job, const fs::path& base) {
    const fs::path solution = with(base, ".solution");
    if (!fs::exists(solution)) return;
    ProcessRequest request{.command = {ours_.path.string(), "eval", solution.string(), "--truth",
                                       job.problem->truth.string(), "--log",
                                       with(base, ".eval.json").string()}};
    request.interrupt = &interrupt_;
    const ProcessResult result = run_process(request);
    fs::remove(solution);
    if (result.code == 0 || result.interrupted || told_of_truth_) return;
    told_of_truth_ = true;
    say("no comparison with the truth of " + job.problem->name + ": " + complaint(result));
  }

  void tell(const Job& job, const RunOutcome& outcome, std::size_t jobs) const {
    const int digits = static_cast<int>(std::to_string(jobs).size());
    std::string line =
        format("[%*d/%zu] %-*s  %-*s  run %d  ", digits, counts_.done, jobs, problem_width_,
               job.problem->name.c_str(), variant_width_, job.variant->name.c_str(), job.run);
    const RunResult result = read_run(plan_, *job.problem, *job.variant, job.run);
    if (!result.trace.empty()) line += format("%.6g  %.3g s", result.final_cost, result.seconds);
    if (outcome.status != RunStatus::ok) {
      line += (result.trace.empty() ? "" : "  ") + std::string(name(outcome.status));
    }
    if (!outcome.message.empty()) line += ": " + outcome.message;
    say(line);
  }

  const BenchPlan& plan_;
  const InterruptGuard& interrupt_;
  BenchProgram ours_;
  BenchProgram ceres_;
  Machine machine_;
  RunCounts counts_;
  int problem_width_ = 0;
  int variant_width_ = 0;
  bool told_of_truth_ = false;
};

}  // namespace

RunCounts run_plan(const BenchPlan& plan, const InterruptGuard& interrupt,
                   const std::function<void()>& accept) {
  return Runner(plan, interrupt).run(accept);
}

}  // namespace raybundle::tools
