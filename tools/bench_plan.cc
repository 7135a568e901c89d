#include <raybundle/tools/bench_plan.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <set>

#include <nlohmann/json.hpp>

#include <raybundle/models/error.h>
#include <raybundle/solver/methods.h>
#include <raybundle/solver/option_table.h>
#include <raybundle/tools/report.h>

namespace raybundle::tools {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

// The one list of members, for both directions.
void visit_members(auto& a, auto&& visit) {
  visit("problems", a.problems);
  visit("scenes", a.scenes);
  visit("variants", a.variants);
  visit("ceres_variants", a.ceres_variants);
  visit("best", a.best);
  visit("common", a.common);
  visit("ceres", a.ceres);
  visit("runs", a.runs);
  visit("threads", a.threads);
  visit("time_limit", a.time_limit);
  visit("memory_limit", a.memory_limit);
}

bool may_be_in_name(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '.' || c == '_' || c == '-' ||
         c == '+';
}

/// Names become names of files and columns.
void check_name(const std::string& option, const std::string& name) {
  const bool good =
      !name.empty() && name.front() != '.' && std::all_of(name.begin(), name.end(), may_be_in_name);
  if (good) return;
  throw OptionError(option + ": '" + name + "' is no name of letters, digits and . _ + -");
}

struct Named {
  std::string name, value;
};

/// "NAME=VALUE".
Named split_named(const std::string& option, const std::string& text) {
  const std::size_t at = text.find('=');
  if (at == std::string::npos) throw OptionError(option + ": '" + text + "' is not NAME=...");
  check_name(option, text.substr(0, at));
  return {text.substr(0, at), text.substr(at + 1)};
}

std::string name_of_file(const fs::path& file) {
  const bool slash = !file.has_filename();  // of a folder
  std::string name = (slash ? file.parent_path() : file).filename().string();
  for (const char* ending : {".gz", ".bz2", ".xz", ".zst", ".txt"}) {
    if (name.ends_with(ending)) name.resize(name.size() - std::string(ending).size());
  }
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !may_be_in_name(c); }, '-');
  return name;
}

/// "FILE[:TRUTH]"; a file that is there is one whatever its name.
BenchProblem files_of(const std::string& text) {
  const std::size_t colon = text.rfind(':');
  const bool alone = fs::exists(text) || colon == std::string::npos;
  const fs::path file = text.substr(0, alone ? text.size() : colon);
  const fs::path truth = alone ? "" : text.substr(colon + 1);
  if (!alone && (file.empty() || truth.empty())) {
    throw OptionError("PROBLEM: '" + text + "' names no " + (file.empty() ? "FILE" : "TRUTH") +
                      " beside the colon");
  }
  return {name_of_file(file), file, truth, {}, std::numeric_limits<double>::infinity()};
}

/// "[NAME=]FILE[:TRUTH]".
BenchProblem given_problem(const std::string& text) {
  BenchProblem unnamed = files_of(text);
  if (fs::exists(unnamed.file) || text.find('=') == std::string::npos) return unnamed;
  const auto [name, value] = split_named("PROBLEM", text);
  BenchProblem problem = files_of(value);
  problem.name = name;
  return problem;
}

BenchProblem scene(const std::string& text, const fs::path& folder) {
  const auto [name, value] = split_named("--scene", text);
  const std::vector<std::string> words = split_words(value);
  if (words.empty()) throw OptionError("--scene: '" + text + "' does not say what to generate");
  const fs::path base = folder / "problems";
  return {name, base / (name + ".txt"), base / (name + ".truth.txt"), words,
          std::numeric_limits<double>::infinity()};
}

void set_best(std::vector<BenchProblem>& problems, const std::string& text) {
  const Named given = split_named("--best", text);
  const auto problem = std::find_if(problems.begin(), problems.end(),
                                    [&](const BenchProblem& p) { return p.name == given.name; });
  if (problem == problems.end()) throw OptionError("--best: there is no problem " + given.name);
  char* end = nullptr;
  problem->best = std::strtod(given.value.c_str(), &end);
  if (end == given.value.c_str() || *end != '\0' || !(problem->best >= 0)) {
    throw OptionError("--best: '" + given.value + "' is no cost");
  }
}

void check_unique(const char* what, const auto& list) {
  std::set<std::string> names;
  for (const auto& each : list) {
    check_name(what, each.name);
    if (!names.insert(each.name).second) {
      throw OptionError(std::string(what) + ": two of them have the name " + each.name);
    }
  }
}

/// Methods that minimise the plain squares: costs of a loss do not compare with them.
std::vector<std::string> default_variants() {
  std::vector<std::string> all;
  for (int i = 0; i < enum_count<Method>; ++i) {
    if (traits(static_cast<Method>(i)).loss != Loss::none) continue;
    const std::string method = name(static_cast<Method>(i));
    all.push_back(method + "=--method " + method);
  }
  return all;
}

std::vector<std::string> default_ceres_variants() {
  return {"ceres-dense-eigen=--linear-solver dense_schur --dense-library eigen",
          "ceres-dense-lapack=--linear-solver dense_schur --dense-library lapack",
          "ceres-sparse=--linear-solver sparse_schur"};
}

std::vector<BenchVariant> make_variants(const BenchArguments& arguments) {
  const std::vector<std::string> limits = {"--threads", std::to_string(arguments.threads),
                                           "--time-limit", exact_text(arguments.time_limit)};
  std::vector<BenchVariant> all;
  for (const std::string& text :
       arguments.variants.empty() ? default_variants() : arguments.variants) {
    const auto [name, options] = split_named("--variant", text);
    all.push_back({name, BenchSolver::raybundle,
                   merge_options({limits, split_words(arguments.common), split_words(options)})});
  }
  if (arguments.ceres.empty()) return all;
  for (const std::string& text :
       arguments.ceres_variants.empty() ? default_ceres_variants() : arguments.ceres_variants) {
    const auto [name, options] = split_named("--ceres-variant", text);
    all.push_back({name, BenchSolver::ceres, merge_options({limits, split_words(options)})});
  }
  return all;
}

}  // namespace

std::string to_json(const BenchArguments& arguments) {
  Json json;
  visit_members(arguments, [&](const char* name, const auto& value) { json[name] = value; });
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

BenchArguments bench_arguments(const std::string& text, const std::string& source) {
  BenchArguments arguments;
  try {
    const Json json = Json::parse(text);
    visit_members(arguments, [&](const char* name, auto& value) { json.at(name).get_to(value); });
  } catch (const Json::exception& error) {
    throw InputError(source, 0, error.what(), "the arguments of a bench");
  }
  return arguments;
}

fs::path BenchPlan::run_path(const BenchProblem& problem, const BenchVariant& variant,
                             int run) const {
  return folder / "runs" / problem.name / variant.name / std::to_string(run);
}

BenchPlan make_plan(const BenchArguments& arguments, const fs::path& folder) {
  if (arguments.runs < 1) throw OptionError("--runs: at least 1");
  if (!(arguments.time_limit > 0 && arguments.time_limit <= 1e9)) {
    throw OptionError("--time-limit: more than 0 and at most 1e9 seconds");
  }
  if (arguments.ceres.empty() && !arguments.ceres_variants.empty()) {
    throw OptionError("--ceres-variant has no effect: there is no Ceres driver (--ceres)");
  }
  BenchPlan plan{arguments, folder, {}, make_variants(arguments)};
  for (const std::string& text : arguments.problems) plan.problems.push_back(given_problem(text));
  for (const std::string& text : arguments.scenes) plan.problems.push_back(scene(text, folder));
  for (const std::string& text : arguments.best) set_best(plan.problems, text);
  check_unique("PROBLEM", plan.problems);
  check_unique("--variant", plan.variants);
  return plan;
}

std::vector<std::string> split_words(const std::string& text) {
  std::vector<std::string> words;
  bool inside = false;
  char quote = '\0';
  for (const char c : text) {
    if (quote == '\0' && std::isspace(static_cast<unsigned char>(c)) != 0) {
      inside = false;
      continue;
    }
    if (!inside) words.emplace_back();
    inside = true;
    if (c == quote) {
      quote = '\0';
    } else if (quote == '\0' && (c == '\'' || c == '"')) {
      quote = c;
    } else {
      words.back() += c;
    }
  }
  if (quote != '\0') throw OptionError("'" + text + "': a quote does not end");
  return words;
}

std::vector<std::string> merge_options(const std::vector<std::vector<std::string>>& lists) {
  std::vector<std::vector<std::string>> options;  // each with its values
  for (const auto& list : lists) {
    for (const std::string& word : list) {
      const std::size_t equals = word.find('=');
      if (!word.starts_with("--")) {
        if (options.empty()) throw OptionError("'" + word + "' belongs to no option");
        options.back().push_back(word);
        continue;
      }
      const std::string name = word.substr(0, equals);
      std::erase_if(options, [&](const auto& option) { return option.front() == name; });
      options.push_back({name});
      if (equals != std::string::npos) options.back().push_back(word.substr(equals + 1));
    }
  }
  std::vector<std::string> words;
  for (const auto& option : options) words.insert(words.end(), option.begin(), option.end());
  return words;
}

}  // namespace raybundle::tools
