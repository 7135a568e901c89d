#include <raybundle/solver/init/positions_linear.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/solver/init/graph.h>
#include <raybundle/solver/init/pose_graph_system.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using linalg::index;

// A ray to a feature, from image `image`; images are nodes here.
struct Row {
  std::int32_t feature, image;
  double pixels;
  Vector3d v;
};

// The images that features tie to the root, with numbers of their own.
struct Nodes {
  std::vector<std::int32_t> image;
  std::vector<std::int32_t> node;  // of an image; -1
  std::int32_t root = 0;
};

class Programme {
 public:
  Programme(std::vector<Feature> features, std::vector<Row> rows, const Nodes& nodes,
            linalg::ThreadPool& pool)
      : features_(std::move(features)),
        rows_(std::move(rows)),
        root_(nodes.root),
        order_(3 * static_cast<std::int64_t>(nodes.image.size())),
        pool_(pool),
        weight_(VectorXd::Ones(count())),
        constrained_(rows_.size(), 1),
        system_(static_cast<std::int64_t>(nodes.image.size()), couples(), pool) {}

  std::int64_t count() const { return static_cast<std::int64_t>(rows_.size()); }

  // Least squares of the present weights, without inequalities: x = rows H^-1 c / (c^T H^-1 c).
  bool solve(VectorXd& x) {
    const VectorXd c = sum_of_depths();
    fill();
    system_.keep();
    system_.hold(root_);
    if (!system_.factor()) return false;
    Eigen::MatrixXd direction = c;
    system_.solve(direction);
    x = direction * (static_cast<double>(count()) / c.dot(direction.col(0)));
    return x.allFinite();
  }

  // The same with them, from the solution without: those that it breaks are added, and then those
  // that the solution with these breaks. Returns the steps that it took.
  int constrain(VectorXd& x, int most_steps) {
    const VectorXd c = sum_of_depths();
    Constraints working;
    int steps = 0;
    while (steps < most_steps && add_broken(x, working)) {
      steps += solve_with(working, c, x, most_steps - steps);
    }
    return steps;
  }

  // Weights of Cauchy's loss of the angles, in pixels, at x. The lengths of rays stay in: divided
  // by them, rows would ask for ever less where positions collapse.
  void reweight(const VectorXd& x, double scale) {
    parallel([&](std::int64_t k) {
      const Row& row = rows_[index(k)];
      const Vector3d N = ray(row, x);
      const double length = std::max(N.norm(), 1e-3);
      const double error = row.v.cross(N).norm() / length * row.pixels;
      const double robust = 1 / (1 + error * error / (scale * scale));
      weight_[k] = robust;
      constrained_[index(k)] = robust > 0.1 ? 1 : 0;
    });
    weight_ /= weight_.mean();
  }

  VectorXd depths(const VectorXd& x) const {
    VectorXd result(count());
    parallel([&](std::int64_t k) {
      const Row& row = rows_[index(k)];
      result[k] = constrained_[index(k)] != 0 ? row.v.dot(ray(row, x)) : 0;
    });
    return result;
  }

  const std::vector<Row>& rows() const { return rows_; }

 private:
  // Inequalities v . N >= 0 that are looked after: their rows, and of each what the method of
  // multipliers knows.
  struct Constraints {
    std::vector<std::int64_t> row;
    std::vector<double> z, multiplier;
  };

  // False where there is none to add.
  bool add_broken(const VectorXd& x, Constraints& working) const {
    constexpr double tolerance = 1e-3;  // of a mean depth of 1
    const VectorXd depth = depths(x);
    const std::size_t before = working.row.size();
    for (std::int64_t k = 0; k < count(); ++k) {
      if (!(depth[k] < -tolerance)) continue;
      if (std::binary_search(working.row.begin(),
                             working.row.begin() + static_cast<std::ptrdiff_t>(before), k)) {
        continue;
      }
      working.row.push_back(k);
    }
    if (working.row.size() == before) return false;
    std::sort(working.row.begin(), working.row.end());
    working.z.assign(working.row.size(), 0);
    working.multiplier.assign(working.row.size(), 0);
    return true;
  }

  // ADMM over z = A x >= 0 [Boyd11, 5.2], A the rows that are looked after.
  int solve_with(Constraints& working, const VectorXd& c, VectorXd& x, int most_steps) {
    const double rho = 1e-2;
    system_.restore();
    for (const std::int64_t k : working.row) {
      const Vector3d& v = rows_[index(k)].v;
      add_row(rows_[index(k)], rho * v * v.transpose());
    }
    system_.hold(root_);
    if (!system_.factor()) return most_steps;
    Eigen::MatrixXd towards_c = c;
    system_.solve(towards_c);
    for (int step = 1; step <= most_steps; ++step) {
      Eigen::MatrixXd next = Eigen::MatrixXd::Zero(order_, 1);
      VectorXd sums = VectorXd::Zero(order_);
      for (std::size_t i = 0; i < working.row.size(); ++i) {
        add_transposed(working.row[i], rho * working.z[i] - working.multiplier[i], sums);
      }
      sums.segment<3>(3 * root_).setZero();
      next = sums;
      system_.solve(next);
      const double missing = static_cast<double>(count()) - c.dot(next.col(0));
      x = next + towards_c * (missing / c.dot(towards_c.col(0)));
      double gap = 0;
      for (std::size_t i = 0; i < working.row.size(); ++i) {
        const Row& row = rows_[index(working.row[i])];
        const double depth = row.v.dot(ray(row, x));
        working.z[i] = std::max(0.0, depth + working.multiplier[i] / rho);
        working.multiplier[i] += rho * (depth - working.z[i]);
        gap = std::max(gap, std::abs(depth - working.z[i]));
      }
      if (gap < 5e-4) return step;
    }
    return most_steps;
  }

  std::vector<PoseGraphSystem::Couple> couples() const {
    std::vector<PoseGraphSystem::Couple> result;
    result.reserve(3 * rows_.size());
    for (const Row& row : rows_) {
      const Feature& feature = features_[index(row.feature)];
      result.emplace_back(feature.main, feature.associate);
      result.emplace_back(feature.main, row.image);
      result.emplace_back(feature.associate, row.image);
    }
    return result;
  }

  template <class Body>
  void parallel(Body&& body) const {
    linalg::parallel_for(pool_, count(), 1024, [&](std::int64_t first, std::int64_t last) {
      for (; first < last; ++first) body(first);
    });
  }

  Vector3d ray(const Row& row, const VectorXd& x) const {
    const Feature& feature = features_[index(row.feature)];
    const Vector3d P_m = x.segment<3>(3 * feature.main), P_a = x.segment<3>(3 * feature.associate);
    const Vector3d P_i = x.segment<3>(3 * row.image);
    return feature.G * (P_a - P_m) + feature.sin_theta * (P_m - P_i);
  }

  // A^T y, of the rows with an inequality: pieces of rows have sums of their own, added in order.
  VectorXd transposed(const VectorXd& y) const {
    const linalg::Chunks pieces = linalg::chunks(count(), 4096, 16);
    std::vector<VectorXd> parts(index(pieces.pieces));
    pool_.run(pieces.pieces, [&](std::int64_t piece) {
      VectorXd& part = parts[index(piece)];
      part = VectorXd::Zero(order_);
      for (std::int64_t k = pieces.begin(piece); k < pieces.end(piece); ++k) {
        if (constrained_[index(k)] != 0) add_transposed(k, y[k], part);
      }
    });
    VectorXd result = VectorXd::Zero(order_);
    for (const VectorXd& part : parts) result += part;
    return result;
  }

  void add_transposed(std::int64_t k, double factor, VectorXd& to) const {
    const Row& row = rows_[index(k)];
    const Feature& feature = features_[index(row.feature)];
    const Vector3d along = factor * row.v, moved = feature.G.transpose() * along;
    to.segment<3>(3 * feature.associate) += moved;
    to.segment<3>(3 * feature.main) += feature.sin_theta * along - moved;
    to.segment<3>(3 * row.image) -= feature.sin_theta * along;
  }

  VectorXd sum_of_depths() const {
    VectorXd c = transposed(VectorXd::Ones(count()));
    c.segment<3>(3 * root_).setZero();
    return c;
  }

  // H and a pinch of the identity.
  void fill() {
    system_.set_zero();
    for (std::int64_t k = 0; k < count(); ++k) {
      const Vector3d& v = rows_[index(k)].v;
      add_row(rows_[index(k)], weight_[k] * (Matrix3d::Identity() - v * v.transpose()));
    }
    const double pinch =
        1e-10 * weight_.mean() * static_cast<double>(count()) / static_cast<double>(order_);
    for (std::int32_t i = 0; i < order_ / 3; ++i) {
      system_.add(i, i, pinch * Matrix3d::Identity());
    }
  }

  // N^T W N of a row.
  void add_row(const Row& row, const Matrix3d& W) {
    const Feature& feature = features_[index(row.feature)];
    const std::array<std::pair<std::int32_t, Matrix3d>, 3> terms = {
        {{feature.main, feature.of_main()},
         {feature.associate, feature.of_associate()},
         {row.image, feature.of_observer() * Matrix3d::Identity()}}};
    for (std::size_t p = 0; p < 3; ++p) {
      const Matrix3d left = terms[p].second.transpose() * W;
      system_.add(terms[p].first, terms[p].first, left * terms[p].second);
      for (std::size_t q = p + 1; q < 3; ++q) {
        const Matrix3d product = left * terms[q].second;
        const bool same = terms[p].first == terms[q].first;
        system_.add(terms[p].first, terms[q].first,
                    same ? Matrix3d(product + product.transpose()) : product);
      }
    }
  }

  std::vector<Feature> features_;
  std::vector<Row> rows_;
  std::int32_t root_;
  std::int64_t order_;
  linalg::ThreadPool& pool_;
  VectorXd weight_;
  std::vector<std::uint8_t> constrained_;
  PoseGraphSystem system_;
};

template <class Visit>
void for_rows(const Sightings& sightings, const Feature& feature,
              std::span<const std::uint8_t> known, Visit&& visit) {
  const Sightings::Range track = sightings.of_point(feature.point);
  for (std::int64_t s = track.first; s < track.last; ++s) {
    if (known[index(sightings.image(s))] != 0) visit(s);
  }
}

// The largest set of images that features tie to one another, its root the one asked for if it is
// among them.
Nodes tied_images(std::int32_t root, const Sightings& sightings, std::span<const Feature> features,
                  std::span<const std::uint8_t> known) {
  std::vector<WeightedEdge> ties;
  for (const Feature& feature : features) {
    for_rows(sightings, feature, known, [&](std::int64_t s) {
      ties.push_back({feature.main, sightings.image(s), 1});
    });
  }
  const Components parts = components(sightings.images(), ties);
  Nodes nodes;
  nodes.node.assign(index(sightings.images()), -1);
  for (std::int32_t i = 0; i < sightings.images(); ++i) {
    if (known[index(i)] == 0 || !parts.in_largest(i)) continue;
    nodes.node[index(i)] = static_cast<std::int32_t>(nodes.image.size());
    nodes.image.push_back(i);
  }
  nodes.root = std::max(nodes.node[index(root)], 0);
  return nodes;
}

}  // namespace

LinearPositions linear_positions(const Sightings& sightings, std::span<const Feature> features,
                                 const std::vector<Matrix3d>& R_cw,
                                 std::span<const std::uint8_t> known, std::int32_t root,
                                 const LinearPositionOptions& options, linalg::ThreadPool& pool) {
  const Nodes nodes = tied_images(root, sightings, features, known);
  std::vector<Feature> tied;
  std::vector<Row> rows;
  for (const Feature& each : features) {
    if (nodes.node[index(each.main)] < 0) continue;
    const auto number = static_cast<std::int32_t>(tied.size());
    for_rows(sightings, each, known, [&](std::int64_t s) {
      rows.push_back({number, nodes.node[index(sightings.image(s))], sightings.pixels(s),
                      world_ray(sightings, R_cw, s)});
    });
    tied.push_back(each);
    tied.back().main = nodes.node[index(each.main)];
    tied.back().associate = nodes.node[index(each.associate)];
  }
  LinearPositions result;
  result.P.assign(index(sightings.images()), Vector3d::Zero());
  result.known.assign(index(sightings.images()), 0);
  result.rows = static_cast<std::int64_t>(rows.size());
  if (rows.empty()) return result;

  Programme programme(std::move(tied), std::move(rows), nodes, pool);
  VectorXd x;
  for (int round = 0; round < options.rounds; ++round) {
    if (round > 0) programme.reweight(x, options.scale);
    if (!programme.solve(x)) return result;
    if (round == 0) result.rows_behind = (programme.depths(x).array() < 0).count();
    result.admm_steps += programme.constrain(x, options.admm_steps);
  }
  for (std::size_t node = 0; node < nodes.image.size(); ++node) {
    result.P[index(nodes.image[node])] = x.segment<3>(3 * static_cast<std::int64_t>(node));
    result.known[index(nodes.image[node])] = 1;
  }
  return result;
}

}  // namespace raybundle::init
