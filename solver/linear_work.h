#pragma once

#include <raybundle/linalg/cholesky.h>
#include <raybundle/solver/step.h>

namespace raybundle {

/// What the ways to a damped step cost, in multiplications with addition as a processor does them
/// from its caches; what waits for memory counts for more than it has. A prediction from sizes
/// alone, so that what is chosen by it is the same on every machine and for any number of threads,
/// as long as what it chooses fits into memory.
struct LinearWork {
  double product = 0;         ///< one implicit product of the reduced system
  double elimination = 0;     ///< what every step has
  double preconditioner = 0;  ///< the diagonal of the reduced matrix
  double coarse = 0;          ///< the coarse space of a step by two levels
  double assembly = 0;        ///< the whole of the reduced matrix, within the caches
};

/// Of a layout whose leaves are eliminated.
LinearWork linear_work(const linalg::BlockLayout& layout);

/// In the step after that: as many again, or, where Preconditioner::adaptive goes over to two
/// levels then, as many as steps with these mostly take.
InnerIterations expected_after(const StepReport& report);

/// The four ways side by side. Before the sparsity of the reduced matrix is known the ways that
/// form it have a lower bound of their work.
class LinearForecast {
 public:
  /// `memory_limit`: bytes that matrix and factor may take.
  LinearForecast(const linalg::BlockLayout& layout, double memory_limit);

  /// From now on so many bytes.
  void leave(double memory_limit);

  /// Raises bounds by what a sample says of the number of blocks: half of it is believed.
  void expect(double blocks);
  /// Takes the sparsity of the matrix into account, which leaves the sparse factorisation with a
  /// bound, and then its analysis; and what there is of memory.
  void add(const linalg::SymmetricPattern& pattern);
  void add(const linalg::CholeskyPlan& plan);

  /// Work for one step as it counts: a way that iterates is taken to need more steps, by this.
  static constexpr double worth_of_exact_steps = 1.35;
  static double weighed(const LinearCandidate& way, InnerIterations expected);
  /// The least of those that fit.
  const LinearCandidate& best(InnerIterations expected) const;
  /// What it takes to learn the sparsity and to analyse it, once.
  double planning() const;

  const std::vector<LinearCandidate>& candidates() const { return candidates_; }

 private:
  LinearCandidate& candidate(Linear linear);
  void weigh(double numbers);
  double formed() const { return work_.elimination + assembly_factor_ * work_.assembly; }
  void see_what_fits();

  LinearWork work_;
  double order_, size_;         // of the reduced matrix and of its blocks
  double assembly_factor_ = 1;  // at least; for a matrix beyond the caches
  double memory_limit_;
  std::vector<LinearCandidate> candidates_;
};

}  // namespace raybundle
