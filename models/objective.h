#pragma once

#include <raybundle/linalg/block_jacobian.h>
#include <raybundle/linalg/normal_equations.h>
#include <raybundle/models/anchors.h>
#include <raybundle/models/formulation.h>
#include <raybundle/models/observation_rows.h>
#include <raybundle/models/problem.h>
#include <raybundle/models/residual_kernels.h>
#include <raybundle/models/robust_loss.h>

#include <span>
#include <vector>

namespace raybundle {

/// What a solve changes: cameras and points, in the Problem's own order. Cameras have the Problem's
/// units. A rotation is its rotation vector whatever the update, so that a state written to a file
/// and read again has the same cost, of xyz to the last bit. Points have those of their model; in
/// coordinates of the world those beyond infinity are behind their cameras, which costs pixels
/// nothing, and rays of xyz everything.
struct State {
  std::vector<double> cameras;
  linalg::LargeVector<double> points;  ///< stored_size(model) numbers each
};

/// The cost of a Problem as a function of a State, with the derivatives a solver needs. Cameras
/// are the hubs and points the leaves of the layout, which is compiled once, here. Rows are sorted
/// by point, then camera. Anchored points take their anchors from the problem as it is then.
class Objective {
 public:
  /// Reads the observations of the problem where they are, if they are in the order of rows: they
  /// outlive this and stay as they are. Copies all else it needs. Throws InputError when the
  /// problem is inconsistent, or when it fixes a part of a pose that the update cannot hold: a
  /// local update turns a rotation and moves a translation as a whole, se3 only the whole pose;
  /// when the loss has no legal scale; for rays, when a lens cannot have made an observation.
  /// Throws std::invalid_argument for rays and free lenses.
  Objective(const Problem& problem, const Formulation& formulation, linalg::ThreadPool& pool,
            const RobustLoss& loss = {});
  Objective(const Problem&& problem, const Formulation& formulation, linalg::ThreadPool& pool,
            const RobustLoss& loss = {}) = delete;
  Objective(const Objective&) = delete;  // others hold its layout
  Objective& operator=(const Objective&) = delete;

  /// Bytes that it will take, its layout included.
  static double memory(const Problem& problem, const Formulation& formulation);
  static linalg::LayoutSize layout_size(const Problem& problem, const Formulation& formulation);

  const linalg::BlockLayout& layout() const { return layout_; }
  const Formulation& formulation() const { return formulation_; }
  const std::vector<Anchors>& anchors() const { return anchors_; }  ///< empty for xyz

  /// The problem's cameras and points, which must be those it was made from in number and order.
  /// Anchored points of rays, unless fixed, are on the side where most cameras saw them, in front
  /// or beyond infinity.
  State state_of(const Problem& problem) const;
  /// The same cameras; points that are not fixed as far as two of their rays tell
  /// [Liu18, Remark 5].
  State state_from_rays(const Problem& problem) const;
  /// Puts a state into the problem: points as coordinates of the world.
  void write(State state, Problem& problem) const;

  /// The cost of residuals of 1000 rounding errors of their observations. Less tells nothing: the
  /// coordinates that a residual is computed from add errors of their own.
  double rounding_cost() const { return rounding_cost_; }

  double loss_scale() const { return loss_.scale; }  ///< pixels
  /// Cost and derivatives are those of the new scale from here on. Throws InputError.
  void set_loss_scale(double scale);

  /// 1/2 sum rho(|r|^2), all of them plain squares where there is no loss; r is u - observed in
  /// pixels, or the difference of two rays times its weight. Not finite where the state cannot be
  /// projected, whatever the loss.
  double cost(const State& state);

  /// 1/2 sum |u - observed|^2 in pixels^2, whatever the objective.
  double pixel_cost(const State& state);

  /// The cost, the Jacobian J, the normal equations and, where asked for, the residuals r
  /// (layout().row_size per row), all in one pass over the points. A loss multiplies
  /// the rows of J and r by sqrt(weight), so that J^T r is the gradient of the cost and J^T J the
  /// matrix of iteratively reweighted least squares [Qu18, Eq. 4.26, 4.27]. There is no term of
  /// second order: rho is concave, so that the weighted squares of any state, moved to equal the
  /// cost at this one, lie nowhere below the cost. Rows beyond the cut of a loss are exactly 0;
  /// rows that cannot be projected are not finite, like the cost.
  double linearize(const State& state, linalg::BlockJacobian& J, linalg::NormalEquations& normal,
                   double* residual = nullptr);

  /// next = state moved by `step` (layout().unknowns() numbers). `next` must have its sizes.
  void retract(const State& state, const double* step, State& next);

  /// Sets the steps of those points to zero whose own cost, with the cameras moved, they would
  /// raise; returns how many that are. Anchored points then go with their anchors. `scratch` has
  /// the sizes of `state` and is overwritten.
  std::int64_t hold_worse_points(const State& state, double* step, State& scratch);

  /// The largest, over blocks (rotation, translation, f, distortion of each camera, each point), of
  /// |step| / (|block| + tolerance).
  double relative_step(const State& state, const double* step, double tolerance) const;

 private:
  /// What the layout knows of rows.
  struct Rows {
    std::span<const std::int32_t> camera;
    std::span<const std::int32_t> point;
    std::span<const std::int64_t> begin;  ///< rows of point i: [i] .. [i + 1]
  };

  void check_fixed() const;
  double rounding_cost_of(const Problem& problem) const;
  void hold_gauge(const Problem& problem);
  int scale_component(const CameraFrame& first, const CameraFrame& second) const;
  void compile_layout(const Problem& problem);
  void choose_all_anchors(const Problem& problem, const linalg::LargeVector<double>& rays);
  void weigh_rays(const Problem& problem);
  template <class Place>
  void place_points(State& state, Place&& place) const;
  PointSides sides(std::int64_t i, const double* X, const CameraPoses& poses) const;
  void place_in_world(std::int64_t i, const double* X, const CameraPoses& poses,
                      double* stored) const;
  bool is_fixed(std::int64_t point) const {
    return !fixed_points_.empty() && fixed_points_[linalg::index(point)] != 0;
  }
  void hold_points(State& state) const;
  void update_frames(const State& state);
  unsigned fixed_mask(std::int64_t camera) const;
  void clear_fixed(const linalg::RowTile& tile) const;
  void clear_fixed_anchors(const linalg::RowTile& tile, linalg::BlockJacobian& J) const;
  void clear_columns(unsigned mask, int rows, double* block) const;
  ResidualInput input(const State& state) const;
  double cost_of(const ResidualInput& in, std::int64_t first, std::int64_t last) const;
  double robust_cost(const ResidualInput& in, std::int64_t first, std::int64_t last) const;
  double evaluate(const ResidualInput& in, const linalg::RowTile& tile, double* Z) const;

  Formulation formulation_;
  RobustLoss loss_;
  linalg::ThreadPool& pool_;
  const ResidualKernels& kernels_;
  linalg::BlockLayout layout_;
  Rows rows_;
  double aspect_;
  std::vector<Anchors> anchors_;               // per point; empty for xyz
  linalg::LargeVector<double> sorted_pixels_;  // empty where the problem has them in order
  const double* pixels_ = nullptr;             // observed, per row
  linalg::LargeVector<double> rays_;           // observed, per row; empty for pixels
  double rounding_cost_ = 0;
  std::vector<CameraFrame> frames_;
  std::vector<std::uint16_t> fixed_camera_parameters_;
  std::vector<std::uint16_t> still_;  // the same, and what the gauge holds; empty: nothing
  std::vector<std::uint8_t> fixed_points_;
  std::vector<double> places_;  // in the world, of anchored points, where some are fixed
};

/// The problem with the coordinates of Objective::state_from_rays() of that model; points that
/// nobody observes stay. Throws InputError when the problem is inconsistent.
Problem with_points_from_rays(Problem problem, PointModel points = PointModel::xyz);

}  // namespace raybundle
