#include <raybundle/tools/bench_prepare.h>

#include <cstdio>
#include <stdexcept>
#include <string>
#include <system_error>

#include <raybundle/models/error.h>
#include <raybundle/models/io/atomic_file.h>
#include <raybundle/models/io/parallaxba.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/bench_process.h>
#include <raybundle/tools/bench_stamp.h>
#include <raybundle/tools/commands.h>
#include <raybundle/tools/input.h>
#include <raybundle/tools/options_cli.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

namespace fs = std::filesystem;

/// Beside a scene: what it was made from.
fs::path recipe_file(const BenchProblem& scene) { return scene.file.string() + ".scene"; }

std::string recipe(const BenchProblem& scene) {
  std::string words;
  for (const std::string& word : scene.generate) words += word + "\n";
  return words;
}

bool is_there(const BenchProblem& scene) {
  return fs::exists(scene.file) && fs::exists(scene.truth) &&
         file_text(recipe_file(scene)) == recipe(scene);
}

void check_file(const fs::path& file, const std::string& expected) {
  if (fs::is_regular_file(file)) return;
  if (io::is_parallaxba(file)) {
    static_cast<void>(io::parallaxba_files(file));
    return;
  }
  throw InputError(file.string(), 0, fs::exists(file) ? "no regular file" : "no file", expected);
}

/// The Ceres driver reads BAL alone.
void check_ceres_reads(const BenchPlan& plan, const BenchProblem& problem) {
  if (plan.arguments.ceres.empty() || !io::is_parallaxba(problem.file)) return;
  throw OptionError("PROBLEM " + problem.name +
                    " is a folder, which the Ceres driver does not read; add --ceres none, or make "
                    "a BAL file of it by raybundle convert");
}

/// Without the points where the truth has none.
std::string counts_text(const Problem& problem, bool with_points) {
  const std::string cameras = count_text(problem.camera_count(), "camera");
  return with_points ? cameras + " and " + count_text(problem.point_count(), "point") : cameras;
}

[[noreturn]] void refuse_scene(const BenchProblem& scene, const ProcessResult& result) {
  std::string why = complaint(result);
  if (const std::string own = "raybundle: "; why.starts_with(own)) why.erase(0, own.size());
  why = "--scene " + scene.name + ": " + why;
  if (result.code == static_cast<int>(ExitCode::usage)) throw OptionError(why);
  throw std::runtime_error(why);
}

}  // namespace

void check_variants(const BenchPlan& plan) {
  for (const BenchVariant& variant : plan.variants) {
    if (variant.solver != BenchSolver::raybundle) continue;
    try {
      static_cast<void>(resolve(parse_solver_options(variant.options)));
    } catch (const OptionError& error) {
      throw OptionError("variant " + variant.name + ": " + error.what());
    }
  }
}

void check_files_exist(const BenchPlan& plan) {
  for (const BenchProblem& problem : plan.problems) {
    if (!problem.generate.empty()) continue;
    check_file(problem.file, "the problem " + problem.name);
    check_ceres_reads(plan, problem);
    if (!problem.truth.empty()) check_file(problem.truth, "the truth of " + problem.name);
  }
}

void check_content(const BenchProblem& problem) {
  const Problem content = read_input(problem.file.string());
  if (problem.truth.empty()) return;
  const Problem truth = read_truth(problem.truth.string());
  const bool with_points = !truth.points.empty();
  const std::string found = counts_text(content, with_points);
  const std::string of_truth = counts_text(truth, with_points);
  if (of_truth == found) return;
  throw InputError(problem.truth.string(), 1, of_truth,
                   found + ", as in " + problem.file.string() + ", whose truth it is to be");
}

NewScenes::NewScenes(const BenchPlan& plan) : plan_(plan), folder_(plan.folder / "problems/new") {
  for (const BenchProblem& problem : plan.problems) {
    if (!problem.generate.empty() && !is_there(problem)) scenes_.push_back(&problem);
  }
}

NewScenes::~NewScenes() {
  std::error_code ignored;  // what stays is overwritten by the next call
  fs::remove_all(folder_, ignored);
}

void NewScenes::make(const fs::path& program, const InterruptGuard& interrupt) {
  if (!scenes_.empty()) fs::create_directories(folder_);
  for (const BenchProblem* scene : scenes_) {
    if (interrupt.signal() != nullptr) return;
    std::fputs(("generating " + scene->name + "\n").c_str(), stderr);
    ProcessRequest request{.command = {program.string(), "generate"}};
    request.interrupt = &interrupt;
    auto& command = request.command;
    command.insert(command.end(), scene->generate.begin(), scene->generate.end());
    command.insert(command.end(), {"-o", (folder_ / scene->file.filename()).string(), "--truth",
                                   (folder_ / scene->truth.filename()).string()});
    const ProcessResult result = run_process(request);
    if (result.interrupted) return;
    if (result.code != 0) refuse_scene(*scene, result);
  }
}

void NewScenes::put_in_place() {
  for (const BenchProblem* scene : scenes_) {
    fs::remove(recipe_file(*scene));  // first: without it the files count as not there
    fs::remove_all(plan_.folder / "runs" / scene->name);
    fs::rename(folder_ / scene->file.filename(), scene->file);
    fs::rename(folder_ / scene->truth.filename(), scene->truth);
    io::write_file_atomically(recipe_file(*scene), recipe(*scene));
  }
}

}  // namespace raybundle::tools
