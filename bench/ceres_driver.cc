/// Solves a BAL file with Ceres and reports, as JSON, the cost over time: the rival in the
/// comparison of solvers. Same cost as `raybundle solve`: 1/2 sum |u - observed|^2 in pixels, nine
/// parameters per camera as one block, no loss, nothing fixed.

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <limits>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <raybundle/bench/loaded_blas.h>
#include <raybundle/models/io/bal.h>
#include <raybundle/models/problem.h>
#include <raybundle/tools/memory.h>

namespace {

using raybundle::Problem;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Every option with its default; the command line is `FILE --name value ...`.
std::map<std::string, std::string> default_arguments() {
  return {{"linear-solver", "dense_schur"},    // dense_schur, sparse_schur, iterative_schur
          {"preconditioner", "schur_jacobi"},  // of iterative_schur; or jacobi, cluster_jacobi, ...
          {"clustering", "single_linkage"},    // canonical_views, single_linkage; of cluster_...
          {"explicit", "0"},                   // 1: iterative_schur stores the Schur complement
          {"dense-library", "eigen"},          // eigen, lapack
          {"sparse-library", "suite_sparse"},  // suite_sparse, cx_sparse, eigen_sparse
          {"ordering", "points"},              // points (eliminated first), auto
          {"threads", "1"},
          {"max-iterations", "500"},
          {"function-tolerance", "1e-16"},
          {"gradient-tolerance", "1e-16"},
          {"parameter-tolerance", "1e-16"},
          {"initial-radius", "1e4"},  // of the trust region; 1 / damping
          {"stop-cost", "0"},         // end once cost <= this
          {"time-limit", "1e9"},      // seconds
          {"output", "-"}};
}

/// Residual of one observation, in pixels, for the BAL camera.
struct BalResidual {
  double observed_x;
  double observed_y;

  template <typename T>
  bool operator()(const T* camera, const T* point, T* residual) const {
    T X_c[3];
    ceres::AngleAxisRotatePoint(camera, point, X_c);
    for (int i = 0; i < 3; ++i) X_c[i] += camera[3 + i];
    const T minus_inverse_depth = T(-1.0) / X_c[2];
    const T p_x = X_c[0] * minus_inverse_depth;
    const T p_y = X_c[1] * minus_inverse_depth;
    const T radius2 = p_x * p_x + p_y * p_y;
    const T scale = camera[6] * (T(1.0) + radius2 * (camera[7] + camera[8] * radius2));
    residual[0] = scale * p_x - observed_x;
    residual[1] = scale * p_y - observed_y;
    return true;
  }
};

struct Iterate {
  int iteration;
  double cost;  // of the state kept
  double seconds;
  bool accepted;
  double gradient_norm;
  int inner_iterations;
};

/// Records every iteration and ends the solve at the stop cost. The clock runs from the call of
/// ceres::Solve, so what Ceres does before it iterates is included.
class Recorder : public ceres::IterationCallback {
 public:
  explicit Recorder(double stop_cost) : stop_cost_(stop_cost) {}

  void start() { start_ = Clock::now(); }

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    const double now = seconds_since(start_);
    const bool accepted = summary.iteration == 0 || summary.step_is_successful;
    if (accepted) cost_ = summary.cost;  // a rejected iteration reports its candidate's cost
    iterates_.push_back({summary.iteration, cost_, now, accepted, summary.gradient_norm,
                         summary.linear_solver_iterations});
    if (cost_ > stop_cost_) return ceres::SOLVER_CONTINUE;
    seconds_to_stop_ = now;
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }

  const std::vector<Iterate>& iterates() const { return iterates_; }
  double seconds_to_stop() const { return seconds_to_stop_; }  ///< NaN when not reached

 private:
  double stop_cost_;
  Clock::time_point start_;
  double cost_ = std::numeric_limits<double>::infinity();
  double seconds_to_stop_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<Iterate> iterates_;
};

std::string upper(std::string text) {
  for (char& c : text) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return text;
}

ceres::Solver::Options solver_options(const std::map<std::string, std::string>& arguments) {
  const auto number = [&](const char* name) { return std::stod(arguments.at(name)); };
  const auto choose = [&](auto parse, const char* name, auto* value) {
    if (parse(upper(arguments.at(name)), value)) return;
    throw std::invalid_argument("unknown value of --" + std::string(name));
  };
  ceres::Solver::Options options;
  choose(ceres::StringToLinearSolverType, "linear-solver", &options.linear_solver_type);
  choose(ceres::StringToPreconditionerType, "preconditioner", &options.preconditioner_type);
  choose(ceres::StringToVisibilityClusteringType, "clustering",
         &options.visibility_clustering_type);
  options.use_explicit_schur_complement = number("explicit") != 0;
  choose(ceres::StringToDenseLinearAlgebraLibraryType, "dense-library",
         &options.dense_linear_algebra_library_type);
  choose(ceres::StringToSparseLinearAlgebraLibraryType, "sparse-library",
         &options.sparse_linear_algebra_library_type);
  options.num_threads = static_cast<int>(number("threads"));
  options.max_num_iterations = static_cast<int>(number("max-iterations"));
  options.function_tolerance = number("function-tolerance");
  options.gradient_tolerance = number("gradient-tolerance");
  options.parameter_tolerance = number("parameter-tolerance");
  options.initial_trust_region_radius = number("initial-radius");
  options.max_solver_time_in_seconds = number("time-limit");
  options.use_nonmonotonic_steps = false;
  options.logging_type = ceres::SILENT;
  std::string error;
  if (!options.IsValid(&error)) throw std::invalid_argument(error);
  return options;
}

/// Fills `problem`, which keeps pointers into `data`; with `groups`, points are eliminated first.
void build(Problem& data, ceres::Problem& problem, ceres::ParameterBlockOrdering* groups) {
  for (std::size_t k = 0; k < data.observation_camera.size(); ++k) {
    double* camera = data.cameras.data() + 9 * std::int64_t{data.observation_camera[k]};
    double* point = data.points.data() + 3 * std::int64_t{data.observation_point[k]};
    auto* residual = new BalResidual{data.observations[2 * k], data.observations[2 * k + 1]};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<BalResidual, 2, 9, 3>(residual),
                             nullptr, camera, point);
    if (groups == nullptr) continue;
    groups->AddElementToGroup(point, 0);
    groups->AddElementToGroup(camera, 1);
  }
}

std::string quote(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c == '\n' ? ' ' : c;
  }
  return quoted + '"';
}

/// The texts of a range between commas.
template <typename Range, typename Text>
std::string joined(const Range& range, const char* comma, Text text) {
  std::string all;
  for (const auto& element : range) all += (all.empty() ? "" : comma) + text(element);
  return all;
}

std::string json(double value) {
  char buffer[40];
  std::snprintf(buffer, sizeof buffer, "%.17g", value);
  return std::isfinite(value) ? buffer : "null";
}

/// A JSON object of numbers.
std::string object(const std::vector<std::pair<const char*, double>>& numbers) {
  const auto member = [](const auto& n) { return quote(n.first) + ": " + json(n.second); };
  return "{" + joined(numbers, ", ", member) + "}";
}

struct Times {
  double read, construct, solve;
};

void write(std::ostream& out, const std::map<std::string, std::string>& arguments,
           const Recorder& recorder, const ceres::Solver::Summary& summary, const Times& times) {
  const auto option = [](const auto& o) { return quote(o.first) + ": " + quote(o.second); };
  const auto iterate = [](const Iterate& i) {
    return "{\"iteration\": " + std::to_string(i.iteration) + ", \"cost\": " + json(i.cost) +
           ", \"seconds\": " + json(i.seconds) + ", \"gradient_norm\": " + json(i.gradient_norm) +
           ", \"inner_iterations\": " + std::to_string(i.inner_iterations) +
           ", \"accepted\": " + (i.accepted ? "true}" : "false}");
  };
  const double before = summary.preprocessor_time_in_seconds;
  out << "{\n\"solver\": \"ceres\",\n\"version\": " << quote(CERES_VERSION_STRING)
      << ",\n\"options\": {" << joined(arguments, ", ", option)
      << "},\n\"blas\": {\"dgemm\": " << quote(raybundle::bench::library_of("dgemm_"))
      << ", \"dpotrf\": " << quote(raybundle::bench::library_of("dpotrf_"))
      << ", \"openblas_core\": " << quote(raybundle::bench::openblas_core()) << ", \"loaded\": ["
      << joined(raybundle::bench::loaded_blas(), ", ", quote) << "]},\n\"iterations\": [\n"
      << joined(recorder.iterates(), ",\n", iterate) << "\n],\n\"seconds_to\": "
      << object({{"solve", recorder.seconds_to_stop()},
                 {"minimizer", recorder.seconds_to_stop() - before}})
      << ",\n\"summary\": {\"initial_cost\": " << json(summary.initial_cost)
      << ", \"final_cost\": " << json(summary.final_cost)
      << ", \"termination\": " << quote(summary.message) << ",\n\"linear_solver_used\": "
      << quote(ceres::LinearSolverTypeToString(summary.linear_solver_type_used))
      << ", \"schur_structure\": " << quote(summary.schur_structure_used)
      << ", \"threads\": " << summary.num_threads_used << ",\n\"seconds\": "
      << object({{"read", times.read},
                 {"construct", times.construct},
                 {"total", times.solve},
                 {"preprocessor", before},
                 {"minimizer", summary.minimizer_time_in_seconds},
                 {"residual", summary.residual_evaluation_time_in_seconds},
                 {"jacobian", summary.jacobian_evaluation_time_in_seconds},
                 {"linear", summary.linear_solver_time_in_seconds}})
      << ",\n\"peak_rss_bytes\": " << raybundle::tools::peak_memory() << "}\n}\n";
}

int run(int argc, char** argv) {
  auto arguments = default_arguments();
  if (argc < 2 || argc % 2 != 0) throw std::invalid_argument("usage: FILE [--option value]...");
  for (int i = 2; i < argc; i += 2) {
    const std::string name = argv[i];
    const bool known = name.rfind("--", 0) == 0 && arguments.count(name.substr(2)) != 0;
    if (!known) throw std::invalid_argument("unknown option " + name);
    arguments[name.substr(2)] = argv[i + 1];
  }
  const std::string& ordering = arguments["ordering"];
  if (ordering != "points" && ordering != "auto") throw std::invalid_argument("unknown ordering");
  ceres::Solver::Options options = solver_options(arguments);
  Times times{};
  auto start = Clock::now();
  Problem data = raybundle::io::read_bal(argv[1]);
  times.read = seconds_since(start);

  start = Clock::now();
  ceres::Problem problem;
  if (ordering == "points") {
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  }
  build(data, problem, options.linear_solver_ordering.get());
  times.construct = seconds_since(start);

  Recorder recorder(std::stod(arguments["stop-cost"]));
  options.callbacks.push_back(&recorder);
  ceres::Solver::Summary summary;
  start = Clock::now();
  recorder.start();
  ceres::Solve(options, &problem, &summary);
  times.solve = seconds_since(start);

  const std::string output = arguments["output"];
  std::ofstream file;
  if (output != "-") file.open(output);
  std::ostream& out = output == "-" ? std::cout : file;
  write(out, arguments, recorder, summary, times);
  if (!out.flush()) throw std::runtime_error("cannot write " + output);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "ceres_driver: " << error.what() << '\n';
    for (const auto& [name, value] : default_arguments()) {
      std::cerr << "  --" << name << ' ' << value << '\n';
    }
    return 2;
  }
}
