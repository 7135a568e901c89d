#pragma once

#include <cstddef>

#include <raybundle/models/alignment.h>
#include <raybundle/solver/init/image_pairs.h>
#include <raybundle/solver/init/view_graph.h>

namespace raybundle::test {

/// Edges between images with points in common, as the true poses have them.
inline init::ViewGraph true_graph(const Problem& truth, const init::Sightings& sightings,
                                  linalg::ThreadPool& pool) {
  const auto R_cw = camera_rotations(truth);
  const auto t = [&](std::size_t k) {
    return Eigen::Map<const Eigen::Vector3d>(truth.cameras.data() + 9 * k + 3);
  };
  init::ViewGraph graph = {truth.camera_count(), {}, false};
  for (const init::ImagePair& pair : image_pairs(sightings, {.min_common = 8}, pool)) {
    const auto i = static_cast<std::size_t>(pair.i), j = static_cast<std::size_t>(pair.j);
    init::ViewEdge edge;
    edge.i = pair.i, edge.j = pair.j;
    edge.pose.R = R_cw[j] * R_cw[i].transpose();
    edge.pose.t = (t(j) - edge.pose.R * t(i)).normalized();
    edge.alone = edge.pose;
    graph.edges.push_back(edge);
  }
  return graph;
}

}  // namespace raybundle::test
