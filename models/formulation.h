#pragma once

#include <raybundle/models/lens.h>
#include <raybundle/models/point_model.h>
#include <raybundle/models/pose.h>

namespace raybundle {

/// What a residual compares:
///   pixel  the projected with the observed pixel, 2 numbers                     [Liu18, Eq. 5]
///   ray    the direction to the point with that of the observed ray, 3 numbers  [Liu18, Eq. 7, 8]
enum class ObjectiveKind { pixel, ray };

/// What multiplies a ray's residual:
///   pixel  the pixels per radian of its lens where it was observed, a 3 x 3 matrix: small
///          residuals are those of pixels
///   focal  the focal length of its camera: the same in the image's centre
///   unit   1, as in [Liu18, Eq. 7]
enum class RayWeight { pixel, focal, unit };

/// The seven freedoms that no observation sees: position, orientation and scale of everything.
///   free   damping and trust regions choose among them
///   fixed  the first camera's pose stays, and of the steps of the second one component of the
///          translation is 0, the one that feels the scale most. Where the problem itself holds
///          poses or points still, those hold the rest
enum class Gauge { free, fixed };

/// Which unknowns stand for a Problem, and what is minimised over them.
struct Formulation {
  PoseUpdate pose_update = PoseUpdate::local;
  Lens lens = Lens::free;
  PointModel points = PointModel::xyz;
  ObjectiveKind objective = ObjectiveKind::pixel;
  RayWeight ray_weight = RayWeight::pixel;
  Gauge gauge = Gauge::free;
};

}  // namespace raybundle
