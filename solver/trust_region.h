#pragma once

#include <raybundle/models/objective.h>
#include <raybundle/solver/convergence.h>
#include <raybundle/solver/damping.h>
#include <raybundle/solver/diagnosis.h>
#include <raybundle/solver/diagonal_matrix.h>
#include <raybundle/solver/forcing.h>
#include <raybundle/solver/loss_schedule.h>
#include <raybundle/solver/solve.h>
#include <raybundle/solver/step.h>
#include <raybundle/solver/trust_radius.h>

#include <chrono>
#include <optional>
#include <vector>

namespace raybundle {

/// The engine: one loop for every method. It owns all buffers, allocated once; a step solver
/// proposes, the objective judges, and damping and radius learn from the verdict.
class TrustRegion {
 public:
  using Clock = std::chrono::steady_clock;

  /// `options` are resolved; everything else outlives this. `start` is the time zero of the log.
  TrustRegion(Objective& objective, StepSolver& steps, linalg::ThreadPool& pool,
              const Options& options, const Observer& observer, Clock::time_point start);

  /// Bytes of all this owns and of the states, without the objective and the step solver.
  static double memory(const linalg::LayoutSize& n, const Options& options);

  /// Moves `state` to the best state found.
  Summary run(State& state);

 private:
  void start();
  void iterate();
  void compute_step();
  void propose();
  void predict_decrease(const std::optional<double>& known_curvature);  // |J p|^2
  void evaluate_candidate();
  void judge();
  void linearize();
  void diagnose();
  void end_iteration();
  Convergence::Situation situation() const;
  void tighten_loss();
  bool rounding_is_suspect(const std::optional<Termination>& verdict) const;
  void widen_rows();
  double widening_memory() const;
  void set_loss_scale(double scale);
  void stop(Termination termination);

  void start_globalisation();
  void begin_record();
  void fill_damping();
  bool points_stay() const { return summary_.options.point_steps == PointSteps::none; }
  void hold_points();
  std::int64_t free_unknowns() const;
  void fill_matrices();
  void fill_modes();
  bool step_is_finite() const;
  double free_promise() const;
  double seconds() const;

  Objective& objective_;
  StepSolver& steps_;
  linalg::ThreadPool& pool_;
  const Observer& observer_;
  Clock::time_point start_;

  State state_;      // the best so far
  State candidate_;  // swapped with state_ when accepted
  linalg::BlockJacobian J_;
  linalg::NormalEquations normal_;
  linalg::LargeVector<double> damping_matrix_;    // D
  linalg::LargeVector<double> damping_diagonal_;  // mu D
  linalg::LargeVector<double> inverse_scaling_;  // D^-1 of the scaled unknowns; empty: the identity
  std::vector<double> hub_modes_;  // Linearization::hub_modes; empty where nobody asks
  linalg::LargeVector<double> step_;
  linalg::LargeVector<double> whole_step_;  // before points were held

  std::optional<Diagnoser> diagnoser_;       // on request
  std::optional<Damping> damping_;           // what the method has of these
  std::optional<TrustRadius> radius_;        // two decides what it is
  std::optional<TrustRadius> block_radius_;  // of eliminated blocks that no damping holds
  Increments increments_;
  std::optional<Forcing> forcing_;
  LossSchedule loss_;
  Convergence convergence_;
  double cost_ = 0;
  double previous_cost_ = 0;  // before the current iteration
  double promise_ = 0;        // of the model without damping and region, at least
  StepReport report_;         // of the last step
  bool step_valid_ = false;
  bool relinearised_ = true;  // since the last step
  bool stopped_ = false;
  IterationRecord record_;
  Summary summary_;
};

}  // namespace raybundle
