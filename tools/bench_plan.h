#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

/// What `raybundle bench` is to run: problems x variants, each several times.
namespace raybundle::tools {

/// The command line, as it was given. Kept in the folder, so that a bench can be resumed, and its
/// report be made again, without it.
struct BenchArguments {
  std::vector<std::string> problems;        ///< [NAME=]FILE[:TRUTH]
  std::vector<std::string> scenes;          ///< NAME=arguments of `raybundle generate`
  std::vector<std::string> variants;        ///< NAME=options of `raybundle solve`
  std::vector<std::string> ceres_variants;  ///< NAME=options of the Ceres driver
  std::vector<std::string> best;            ///< NAME=COST
  std::string common;                       ///< options of all our variants that say nothing else
  std::string ceres;                        ///< the Ceres driver; empty: without
  int runs = 3;
  int threads = 1;
  double time_limit = 300;         ///< seconds, of the solve
  std::uint64_t memory_limit = 0;  ///< bytes; 0: what the machine has
};

std::string to_json(const BenchArguments& arguments);
/// Throws InputError naming `source` when the text is something else.
BenchArguments bench_arguments(const std::string& text, const std::string& source);

struct BenchProblem {
  std::string name;
  std::filesystem::path file;
  std::filesystem::path truth;        ///< empty: not known
  std::vector<std::string> generate;  ///< arguments that make it; empty: the file is somebody's
  double best;                        ///< best cost known beforehand; infinite: none
};

enum class BenchSolver { raybundle, ceres };

struct BenchVariant {
  std::string name;
  BenchSolver solver;
  std::vector<std::string> options;  ///< complete, threads and limits included
};

struct BenchPlan {
  BenchArguments arguments;
  std::filesystem::path folder;
  std::vector<BenchProblem> problems;
  std::vector<BenchVariant> variants;

  /// Without an ending: .json is the log, .run.json the stamp, .eval.json the comparison with the
  /// truth. `run` counts from 1.
  std::filesystem::path run_path(const BenchProblem& problem, const BenchVariant& variant,
                                 int run) const;
};

/// Throws OptionError for a name that is used twice or cannot be a file's, and for values that make
/// no sense. Looks at no file beyond whether one of a name exists.
BenchPlan make_plan(const BenchArguments& arguments, const std::filesystem::path& folder);

/// Words of a command line: white space separates, '...' and "..." hold together. Throws
/// OptionError for a quote that does not end.
std::vector<std::string> split_words(const std::string& text);

/// `--name value...` options put one after the other, where of each name the last counts.
std::vector<std::string> merge_options(const std::vector<std::vector<std::string>>& lists);

}  // namespace raybundle::tools
