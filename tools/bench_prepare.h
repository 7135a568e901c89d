#pragma once

#include <filesystem>
#include <vector>

#include <raybundle/tools/bench_plan.h>
#include <raybundle/tools/interrupt.h>

/// Whatever of a plan can be refused, found out before anything of an earlier bench is touched.
namespace raybundle::tools {

/// Throws OptionError naming the first variant whose options `raybundle solve` would not take.
/// Those of the Ceres driver only it can judge.
void check_variants(const BenchPlan& plan);

/// Throws InputError when a file of a problem that is not generated is not there, OptionError when
/// it is a folder and the Ceres driver is to read it.
void check_files_exist(const BenchPlan& plan);

/// Reads problem and truth. Throws InputError when one is no problem, or they do not fit.
void check_content(const BenchProblem& problem);

/// The scenes of a plan that are not there yet. They are made beside their places, so that those
/// of an earlier bench stay until the whole plan has been found good.
class NewScenes {
 public:
  explicit NewScenes(const BenchPlan& plan);
  ~NewScenes();  ///< removes what was not put in place
  NewScenes(const NewScenes&) = delete;
  NewScenes& operator=(const NewScenes&) = delete;

  /// Generates them with this program. Returns early after an interruption. Throws OptionError for
  /// arguments that `raybundle generate` does not take, std::runtime_error when it fails.
  void make(const std::filesystem::path& program, const InterruptGuard& interrupt);

  /// To where the plan has them. Runs on a scene of the same name that was another are removed.
  void put_in_place();

 private:
  const BenchPlan& plan_;
  std::filesystem::path folder_;
  std::vector<const BenchProblem*> scenes_;
};

}  // namespace raybundle::tools
