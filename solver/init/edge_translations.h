#pragma once

#include <raybundle/solver/init/rotation_averaging.h>
#include <raybundle/solver/init/view_graph.h>

namespace raybundle::init {

/// The graph with rotations as averaged and, for these, the direction of translation of each edge
/// anew [Liu18, 3.1]: the one with the least sum of Cauchy's loss of the epipolar errors. Edges
/// between images that are not known and those that were pruned are dropped; those of pure
/// rotation, with hardly any parallax or left with too few inliers have no translation.
ViewGraph with_rotations(const Sightings& sightings, const ViewGraph& graph,
                         const AveragedRotations& rotations, const RelativePoseOptions& options,
                         linalg::ThreadPool& pool);

}  // namespace raybundle::init
