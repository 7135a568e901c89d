#pragma once

#include <raybundle/solver/init/features.h>

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace raybundle::init {

/// A ray to a feature as a row of [Liu18, Eq. 13, 14]: v, observed in the world, is to be along N,
/// which is linear in the positions of main and associate anchor and observing image.
struct FeatureRay {
  std::int32_t feature, image;  ///< the feature's place in its list
  double pixels;                ///< per radian
  Eigen::Vector3d v;

  /// The images that N depends on, the observer last, with the coefficients of their positions; the
  /// observer may be an anchor too.
  struct Term {
    std::int32_t image;
    Eigen::Matrix3d coefficient;
  };
  std::array<Term, 3> terms(const Feature& of) const {
    return {{{of.main, of.of_main()},
             {of.associate, of.of_associate()},
             {image, of.of_observer() * Eigen::Matrix3d::Identity()}}};
  }
};

/// The rays to these features from all images that are marked, in order; anchors are among these.
std::vector<FeatureRay> feature_rays(const Sightings& sightings, std::span<const Feature> features,
                                     const std::vector<Eigen::Matrix3d>& R_cw,
                                     std::span<const std::uint8_t> marked);

/// The largest set of images whose positions these rays tell, up to a scale and a shift; 1: it is
/// one. It grows from the two anchors of a feature: an image is told where the rays that depend on
/// it, and else on images of the set alone, move by a pixel or more whichever way it goes by as
/// much as the anchors are apart. Of the sets that different anchors lead to, of equals the one of
/// the pair with most features.
std::vector<std::uint8_t> determined_images(std::int64_t images, std::span<const Feature> features,
                                            std::span<const FeatureRay> rays);

}  // namespace raybundle::init
