#include <raybundle/solver/init/rotation_averaging.h>

#include <raybundle/linalg/block_layout.h>
#include <raybundle/solver/init/connected_rotations.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace raybundle::init {
namespace {

using Eigen::Matrix3d;
using linalg::index;
using Edges = std::vector<RelativeRotation>;

double prune_angle(const RotationOptions& options) {
  return options.prune * std::numbers::pi / 180;
}

// The largest component of those edges that are not pruned, with numbers of its own.
struct Core {
  std::vector<std::int32_t> image;  // of a node
  std::vector<std::int32_t> node;   // of an image; -1: not in it
  std::vector<std::int64_t> edge;   // kept: their places in the whole list
  Edges edges;

  Core(std::int64_t images, std::span<const RelativeRotation> all,
       const std::vector<std::uint8_t>& pruned)
      : node(index(images), -1) {
    std::vector<WeightedEdge> left;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (pruned[k] == 0) left.push_back({all[k].i, all[k].j, all[k].weight});
    }
    const Components parts = components(images, left);
    for (std::int32_t i = 0; i < images; ++i) {
      if (!parts.in_largest(i)) continue;
      node[index(i)] = static_cast<std::int32_t>(image.size());
      image.push_back(i);
    }
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (pruned[k] != 0 || node[index(all[k].i)] < 0 || node[index(all[k].j)] < 0) continue;
      edge.push_back(static_cast<std::int64_t>(k));
      edges.push_back({node[index(all[k].i)], node[index(all[k].j)], all[k].R_ji, all[k].weight});
    }
  }

  std::int64_t nodes() const { return static_cast<std::int64_t>(image.size()); }

  bool is_within(const Core& other) const {
    return std::all_of(image.begin(), image.end(),
                       [&](std::int32_t i) { return other.node[index(i)] >= 0; });
  }

  // The node whose edges weigh most.
  std::int32_t heaviest() const {
    std::vector<double> weight(image.size(), 0);
    for (const RelativeRotation& each : edges) {
      weight[index(each.i)] += each.weight;
      weight[index(each.j)] += each.weight;
    }
    return static_cast<std::int32_t>(std::max_element(weight.begin(), weight.end()) -
                                     weight.begin());
  }
};

void check(std::int64_t images, std::span<const RelativeRotation> edges) {
  for (const RelativeRotation& edge : edges) {
    const bool legal = edge.i >= 0 && edge.j >= 0 && edge.i < images && edge.j < images;
    if (!legal || edge.i == edge.j) {
      throw std::invalid_argument("an edge between images " + std::to_string(edge.i) + " and " +
                                  std::to_string(edge.j) + " of " + std::to_string(images));
    }
  }
}

AveragedRotations nothing_known(std::int64_t images, std::size_t edges) {
  AveragedRotations result;
  result.R_cw.assign(index(images), Matrix3d::Identity());
  result.known.assign(index(images), 0);
  result.angle.assign(edges, std::numeric_limits<double>::quiet_NaN());
  result.pruned.assign(edges, 0);
  return result;
}

// Of every image of the core, from both starts; marks the edges that disagree.
Rotations average_all(const Core& core, const RotationOptions& options, linalg::ThreadPool& pool,
                      AveragedRotations& result) {
  const std::int32_t root = core.heaviest();
  result.root = core.image[index(root)];
  ConnectedRotations graph(core.nodes(), core.edges, root, pool);
  constexpr double widest_scale = 1;  // radian
  Rotations R = graph.chordal(), tree = graph.along_tree();
  result.chordal = statistics_of(graph.angles(R));
  result.tree = statistics_of(graph.angles(tree));
  result.iterations += graph.refine(R, options.most_iterations, widest_scale) +
                       graph.refine(tree, options.most_iterations, widest_scale);
  if (graph.robust_sum(tree) < graph.robust_sum(R)) R.swap(tree);
  const std::vector<double> angles = graph.angles(R);
  result.before = statistics_of(angles);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    result.pruned[index(core.edge[k])] = angles[k] > prune_angle(options) ? 1 : 0;
  }
  return R;
}

// The same of what is left, from rotations nearby; writes them into the result.
void average_rest(const Core& core, Rotations R, const RotationOptions& options,
                  linalg::ThreadPool& pool, AveragedRotations& result) {
  const std::int32_t before = core.node[index(result.root)];
  const std::int32_t root = before >= 0 ? before : core.heaviest();
  result.root = core.image[index(root)];
  ConnectedRotations graph(core.nodes(), core.edges, root, pool);
  result.iterations += graph.refine(R, options.most_iterations, 0);
  result.after = statistics_of(graph.angles(R));
  const Matrix3d R_wr = R[index(root)].transpose();
  for (std::size_t node = 0; node < R.size(); ++node) {
    result.R_cw[index(core.image[node])] = R[node] * R_wr;
    result.known[index(core.image[node])] = 1;
  }
}

// The angles of edges between images of known rotation.
void measure_edges(std::span<const RelativeRotation> edges, AveragedRotations& result) {
  for (std::size_t k = 0; k < edges.size(); ++k) {
    if (result.known[index(edges[k].i)] == 0 || result.known[index(edges[k].j)] == 0) continue;
    result.angle[k] = angle_of(edges[k], result.R_cw);
  }
}

// Of what is left of a component another one may be the largest: that is then averaged too.
AveragedRotations averaged(std::int64_t images, std::span<const RelativeRotation> edges,
                           const RotationOptions& options, linalg::ThreadPool& pool) {
  AveragedRotations result = nothing_known(images, edges.size());
  if (images == 0) return result;
  Core core(images, edges, result.pruned);
  Rotations R = average_all(core, options, pool, result);
  while (true) {
    Core left(images, edges, result.pruned);
    if (left.is_within(core)) {
      Rotations kept;
      kept.reserve(left.image.size());
      for (const std::int32_t i : left.image) kept.push_back(R[index(core.node[index(i)])]);
      average_rest(left, std::move(kept), options, pool, result);
      break;
    }
    core = std::move(left);
    R = average_all(core, options, pool, result);
  }
  measure_edges(edges, result);
  return result;
}

// Of the two rotations that an edge may have the one nearer to these; whether any is another now.
bool take_nearer(Edges& edges, const Rotations& R, const std::vector<std::uint8_t>& known) {
  bool changed = false;
  for (RelativeRotation& edge : edges) {
    if (!edge.other || known[index(edge.i)] == 0 || known[index(edge.j)] == 0) continue;
    RelativeRotation swapped = edge;
    std::swap(swapped.R_ji, *swapped.other);
    if (!(angle_of(swapped, R) < angle_of(edge, R))) continue;
    edge = swapped;
    changed = true;
  }
  return changed;
}

}  // namespace

AveragedRotations average_rotations(std::int64_t images, std::span<const RelativeRotation> edges,
                                    const RotationOptions& options, linalg::ThreadPool& pool) {
  constexpr double doubt = 0.1;  // of an edge that may have another rotation: the starts avoid it
  constexpr int most_choices = 5;
  check(images, edges);
  Edges chosen(edges.begin(), edges.end());
  for (RelativeRotation& edge : chosen) edge.weight *= edge.other ? doubt : 1;
  AveragedRotations result = averaged(images, chosen, options, pool);
  for (int k = 0; k < most_choices && take_nearer(chosen, result.R_cw, result.known); ++k) {
    const int before = result.iterations;
    result = averaged(images, chosen, options, pool);
    result.iterations += before;
  }
  return result;
}

AveragedRotations given_rotations(const Rotations& R_cw, std::span<const RelativeRotation> edges,
                                  const RotationOptions& options) {
  const auto images = static_cast<std::int64_t>(R_cw.size());
  check(images, edges);
  AveragedRotations result = nothing_known(images, edges.size());
  if (images == 0) return result;

  Edges chosen(edges.begin(), edges.end());
  take_nearer(chosen, R_cw, std::vector<std::uint8_t>(R_cw.size(), 1));
  const std::vector<double> angles = angles_of(chosen, R_cw);
  result.before = statistics_of(angles);
  for (std::size_t k = 0; k < angles.size(); ++k) {
    result.pruned[k] = angles[k] > prune_angle(options) ? 1 : 0;
  }
  const Core left(images, chosen, result.pruned);
  result.root = left.image[index(left.heaviest())];
  for (const std::int32_t image : left.image) {
    result.R_cw[index(image)] = R_cw[index(image)];
    result.known[index(image)] = 1;
  }
  measure_edges(chosen, result);
  std::vector<double> kept;
  kept.reserve(left.edge.size());
  for (const std::int64_t edge : left.edge) kept.push_back(result.angle[index(edge)]);
  result.after = statistics_of(std::move(kept));
  return result;
}

}  // namespace raybundle::init
