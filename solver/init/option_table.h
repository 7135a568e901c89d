#pragma once

#include <raybundle/solver/init/initialize.h>
#include <raybundle/solver/option_table.h>

namespace raybundle {

template <>
inline constexpr int enum_count<init::RotationSource> = 2;

namespace init {

/// The options of initialisation that the command line has; as raybundle::visit_options().
template <class Visit>
void visit_options(InitializeOptions& o, Visit&& visit) {
  visit(o.pairs.min_common,
        OptionInfo{"min-common", "fewest points that a pair of images has in common", 6, 1e9});
  visit(o.pairs.most_per_image,
        OptionInfo{"pairs-per-camera",
                   "most pairs that an image asks for, those with most points in common", 1, 1e9});
  visit(o.relative_pose.min_inliers,
        OptionInfo{"min-inliers", "fewest points that fit the pose of a pair", 6, 1e9});
  visit(o.relative_pose.threshold,
        OptionInfo{"threshold", "largest epipolar error of a point that fits a pair, pixels", 1e-6,
                   1e6});
  visit(o.rotation_source,
        OptionInfo{"rotations", "averaged from those of pairs, or as the problem has them"});
  visit(o.rotations.prune,
        OptionInfo{"prune", "leave out pairs that disagree with the rotations by more degrees",
                   1e-6, 180});
  visit(o.positions.loss, OptionInfo{"loss", "robust loss of the positions"});
  visit(o.positions.loss_scale, OptionInfo{"loss-scale", "its scale, pixels", 1e-100, 1e100});
  visit(o.threads, OptionInfo{"threads", "worker threads; 0 means all cores", 0, 1024});
}

}  // namespace init
}  // namespace raybundle
