#pragma once

#include <raybundle/linalg/parallel.h>
#include <raybundle/solver/init/feature_rays.h>
#include <raybundle/solver/init/pose_graph_system.h>

#include <Eigen/Core>

#include <cstdint>
#include <vector>

namespace raybundle::init {

/// The convex quadratic programme of positions x, three for an image [Liu18, Eq. 14]:
///   minimise sum w |v x N|^2   such that v . N >= 0, sum v . N = rays, x_root = 0
/// Images are 0 .. images - 1, and all rays and features are among them.
class PositionProgramme {
 public:
  PositionProgramme(std::int64_t images, std::int32_t root, std::vector<Feature> features,
                    std::vector<FeatureRay> rays, linalg::ThreadPool& pool);

  /// The minimum without the inequalities: x = H^-1 c rays / (c^T H^-1 c). False where it cannot be
  /// computed; x is then as before.
  bool solve(Eigen::VectorXd& x);

  struct Steps {
    int count = 0;
    bool converged = true;  ///< to 5e-4 of a mean depth, else ended by their number
  };
  /// The minimum with them, from the one without, by the method of multipliers [Boyd11, 5.2]: those
  /// that it breaks are looked after, and then those that the minimum with these breaks.
  Steps constrain(Eigen::VectorXd& x, int most_steps);

  /// Gives w the weights of Cauchy's loss of the angles between v and N at x, scale in pixels, and
  /// a mean of 1; rays of little weight have no inequality any more. The lengths of N stay in:
  /// divided by them, rays would ask for ever less where positions collapse.
  void reweight(const Eigen::VectorXd& x, double scale);

  /// v . N of all rays, 0 of those without an inequality.
  Eigen::VectorXd depths(const Eigen::VectorXd& x) const;

 private:
  // Inequalities that are looked after, by their rays, and what the method of multipliers knows:
  // z takes the place of the depth, the multiplier is what their equality costs.
  struct Constraint {
    std::int64_t ray;
    double z = 0, multiplier = 0;
  };

  std::int64_t count() const { return static_cast<std::int64_t>(rays_.size()); }
  std::vector<PoseGraphSystem<3>::Couple> couples() const;
  template <class Body>
  void parallel(Body&& body) const;

  Eigen::Vector3d towards_feature(const FeatureRay& ray, const Eigen::VectorXd& x) const;
  Eigen::VectorXd sum_of_depths() const;
  void add_transposed(std::int64_t k, double factor, Eigen::VectorXd& to) const;
  void fill();
  void add_ray(const FeatureRay& ray, const Eigen::Matrix3d& W);

  bool add_broken(const Eigen::VectorXd& x, std::vector<Constraint>& working) const;
  Steps solve_with(std::vector<Constraint>& working, const Eigen::VectorXd& c, Eigen::VectorXd& x,
                   int most_steps);
  struct Gap {
    double primal = 0, dual = 0;  // depths less z, and how far z went
  };
  bool factor_with(const std::vector<Constraint>& working, double rho);
  Gap move_multipliers(std::vector<Constraint>& working, double rho,
                       const Eigen::VectorXd& x) const;

  std::vector<Feature> features_;
  std::vector<FeatureRay> rays_;
  std::int32_t root_;
  std::int64_t order_;
  linalg::ThreadPool& pool_;
  Eigen::VectorXd weight_;
  std::vector<std::uint8_t> constrained_;
  PoseGraphSystem<3> system_;
};

}  // namespace raybundle::init
