#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include <raybundle/linalg/normal_equations.h>
#include <raybundle/linalg/parallel.h>
#include <raybundle/linalg/reduced_system.h>
#include <raybundle/models/objective.h>
#include <raybundle/models/problem.h>

/// What tools/reproduce needs beside solves: measurements of single steps of [Qu18], and plots.
namespace raybundle::bench {

using Json = nlohmann::ordered_json;

/// Frames of a problem, chosen at random, with the points that at least two of them see: the
/// sub-dataset of [Qu18, 2.3]. As many frames as there are when `frames` is more.
Problem sub_dataset(const Problem& problem, std::int64_t frames, std::uint64_t seed);

/// A problem linearised at a state, with additive poses as in [Qu18, 3.1].
class Linearised {
 public:
  Linearised(const Problem& problem, linalg::ThreadPool& pool);
  Linearised(const Linearised&) = delete;

  /// Residuals, Jacobian and normal equations at `state`; returns the cost.
  double at(const State& state);

  const linalg::BlockLayout& layout() const { return objective.layout(); }
  linalg::Linearization view() const { return {&J, &normal}; }

  linalg::ThreadPool& pool;
  Objective objective;
  linalg::BlockJacobian J;
  linalg::NormalEquations normal;
  std::vector<double> residual;
};

/// Time and memory of J and H in four forms [Qu18, Table 3.1].
Json matrix_forms(const Problem& problem, linalg::ThreadPool& pool);
/// Time and agreement of CG, Cholesky and LU on reduced camera systems [Qu18, Tables 3.3, 3.4].
Json linear_solvers(const Problem& problem, int systems, linalg::ThreadPool& pool);
/// The remainder of the linearisation along a random direction [Qu18, Fig. 3.1].
Json taylor(const Problem& problem, std::uint64_t seed, linalg::ThreadPool& pool);
/// Observed and projected positions of each observation, and the gradient.
Json residuals(const Problem& problem, linalg::ThreadPool& pool);
/// Camera centres and points.
Json geometry(const Problem& problem);

/// Draws what `specification` lists into `folder`; what went wrong, or nothing. Throws
/// nlohmann::json::exception when it lists something else.
std::string draw(const Json& specification, const std::filesystem::path& folder);

}  // namespace raybundle::bench
