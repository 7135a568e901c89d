// The kinds of scenes that copy real ones, how long their tracks are, and the presets.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/aerial.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/scenes/photos.h>
#include <raybundle/models/scenes/presets.h>
#include <raybundle/models/scenes/track_lengths.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/models/scene_hash.h>

namespace raybundle::scenes {
namespace {

using test::hash;

void expect_sound(const Scene& scene) {
  const Problem& truth = scene.truth;
  EXPECT_NO_THROW(validate(truth));
  const StructureStatistics s = structure_statistics(truth);
  EXPECT_EQ(s.unobserved_cameras + s.unobserved_points + s.points_seen_once, 0);
  EXPECT_EQ(s.duplicate_observations, 0);
  EXPECT_EQ(s.components, 1);
  EXPECT_GE(s.fewest_observations, 9);
  const ReprojectionStatistics exact = reprojection_statistics(truth);
  EXPECT_EQ(exact.behind_camera, 0);
  EXPECT_LT(exact.rmse, 1e-9);
  for (std::size_t k = 0; k < truth.observations.size(); k += 2) {
    ASSERT_LE(std::abs(truth.observations[k]), 0.5 * scene.image_width);
    ASSERT_LE(std::abs(truth.observations[k + 1]), 0.5 * scene.image_height);
  }
}

TEST(TrackLengths, AddUpAndStayInBounds) {
  for (const std::int64_t observations : {2000, 2001, 3500, 7000, 30000, 39999, 40000}) {
    Random random(1);
    const auto lengths = draw_track_lengths(1000, observations, 40, random);
    EXPECT_EQ(std::accumulate(lengths.begin(), lengths.end(), std::int64_t{0}), observations);
    EXPECT_GE(*std::min_element(lengths.begin(), lengths.end()), 2);
    EXPECT_LE(*std::max_element(lengths.begin(), lengths.end()), 40);
  }
}

struct RealTracks {
  std::int64_t cameras, points, observations;
  std::vector<double> shares;  // of tracks of 2, 3, ... observations
};

TEST(TrackLengths, AreDistributedAsInRealProblems) {
  const RealTracks ladybug = {49, 7776, 31843, {.444, .178, .106, .067, .050, .033, .027, .021}};
  const RealTracks trafalgar = {21, 11315, 36455, {.518, .196, .110, .066, .040, .028, .017, .011}};
  const RealTracks dubrovnik = {16, 22106, 83718, {.389, .204, .130, .091, .064, .043, .029, .020}};
  for (const RealTracks& real : {ladybug, trafalgar, dubrovnik}) {
    Random random(1);
    const auto lengths = draw_track_lengths(real.points, real.observations, real.cameras, random);
    double distance = 0;  // between the cumulative shares
    double cumulated = 0, cumulated_real = 0;
    for (std::size_t k = 0; k < real.shares.size(); ++k) {
      const auto count = std::count(lengths.begin(), lengths.end(), static_cast<int>(k) + 2);
      cumulated += static_cast<double>(count) / static_cast<double>(real.points);
      cumulated_real += real.shares[k];
      distance = std::max(distance, std::abs(cumulated - cumulated_real));
    }
    EXPECT_LT(distance, 0.075) << real.cameras;
  }
}

TEST(Aerial, IsPinned) {
  EXPECT_EQ(hash(aerial_scene().truth), 0x66CD0A37B701D815U);
  EXPECT_EQ(hash(aerial_scene({.seed = 4, .observations = 9000}).truth), 0x3C3C82FBD1409DBBU);
}

TEST(Aerial, IsSound) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    expect_sound(aerial_scene({.seed = seed}));
    const Scene scene =
        aerial_scene({.seed = seed, .cameras = 150, .points = 5000, .observations = 31000});
    expect_sound(scene);
    EXPECT_EQ(scene.truth.observation_count(), 31000);
  }
}

TEST(Aerial, HeightTakesTheParallaxAway) {
  const auto share = [](double height) {
    const StructureStatistics s =
        structure_statistics(aerial_scene({.observations = 9000, .height = height}).truth);
    return static_cast<double>(s.low_parallax_points) / static_cast<double>(s.points);
  };
  EXPECT_LT(share(20), 0.01);
  EXPECT_GT(share(200), 0.5);
}

TEST(Photos, IsPinned) {
  EXPECT_EQ(hash(photos_scene().truth), 0x3E9C62446A6C7932U);
  EXPECT_EQ(hash(photos_scene({.seed = 4, .cameras = 200, .sights = 4}).truth),
            0xF770AACB1AF893FEU);
}

TEST(Photos, IsSoundAndHasHubsAndAHeavyTail) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene scene =
        photos_scene({.seed = seed, .cameras = 400, .points = 40000, .observations = 200000});
    expect_sound(scene);
    const StructureStatistics s = structure_statistics(scene.truth);
    EXPECT_EQ(s.observations, 200000);
    EXPECT_GT(s.longest_track, 10 * s.mean_track_length);
    EXPECT_GT(s.most_observations, 5 * s.observations / s.cameras);
    EXPECT_GT(s.fewest_observations, 40);
    EXPECT_LT(s.camera_pairs, s.cameras * (s.cameras - 1) / 4);  // not all at one sight
  }
}

TEST(Photos, SmallestScenes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    EXPECT_EQ(photos_scene({.seed = seed, .cameras = 2, .points = 5}).truth.observation_count(),
              10);
    EXPECT_EQ(aerial_scene({.seed = seed, .cameras = 2, .points = 5}).truth.observation_count(),
              10);
  }
}

TEST(SceneKinds, RefuseWhatCannotBe) {
  EXPECT_THROW(aerial_scene({.cameras = 1}), InputError);
  EXPECT_THROW(aerial_scene({.observations = 5}), InputError);
  EXPECT_THROW(aerial_scene({.height = 0}), InputError);
  EXPECT_THROW(aerial_scene({.height = std::nan("")}), InputError);
  EXPECT_THROW(photos_scene({.points = 0}), InputError);
  EXPECT_THROW(photos_scene({.sights = 31}), InputError);
  EXPECT_THROW(photos_scene({.sights = -1}), InputError);
}

TEST(Presets, ThesisSizesHaveTheirCounts) {
  for (const char* name : {"sphere-10", "sphere-50", "sphere-100"}) {
    const Preset& each = preset(name);
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      const Scene scene = preset_scene(each, seed);
      EXPECT_EQ(scene.truth.camera_count(), each.cameras);
      EXPECT_EQ(scene.truth.point_count(), each.points);
      EXPECT_EQ(scene.truth.observation_count(), each.observations) << name << " " << seed;
      expect_sound(scene);
    }
  }
}

double rmse(const std::vector<Vec3>& differences) {
  double squares = 0;
  for (const Vec3& d : differences) squares += dot(d, d);
  return std::sqrt(squares / static_cast<double>(differences.size()));
}

TEST(Presets, ThesisStartsAreAsFarOffAsItsTablesSay) {
  // [Qu18, Tables 5.1 to 5.4]: 26 to 76 for the cameras, 6 to 14 for the points.
  for (const char* name : {"sphere-10", "sphere-50", "sphere-100"}) {
    const Problem truth = preset_scene(preset(name)).truth;
    const Problem start = perturb(truth, preset(name).start);
    std::vector<Vec3> cameras, points;
    for (std::int64_t j = 0; j < truth.camera_count(); ++j) {
      cameras.push_back(difference(camera_of(start, j).centre, camera_of(truth, j).centre));
    }
    for (std::int64_t i = 0; i < truth.point_count(); ++i) {
      points.push_back(difference(point_of(start, i), point_of(truth, i)));
    }
    EXPECT_GT(rmse(cameras), 26);
    EXPECT_LT(rmse(cameras), 76);
    EXPECT_GT(rmse(points), 6);
    EXPECT_LT(rmse(points), 14.1);
  }
}

TEST(Presets, CopiesOfRealProblemsHaveTheirCountsAndStarts) {
  for (const Preset& full : presets()) {
    if (full.kind == Kind::sphere) continue;
    const Preset small = resized(full, full.points > 500'000 ? 0.03 : 0.1);
    const Scene scene = preset_scene(small);
    expect_sound(scene);
    EXPECT_EQ(scene.truth.camera_count(), small.cameras) << full.name;
    EXPECT_EQ(scene.truth.point_count(), small.points) << full.name;
    EXPECT_EQ(scene.truth.observation_count(), small.observations) << full.name;
    EXPECT_NEAR(static_cast<double>(small.observations) / static_cast<double>(small.points),
                static_cast<double>(full.observations) / static_cast<double>(full.points), 0.01);
    const Problem noisy = add_noise(scene, small.noise).problem;
    const ReprojectionStatistics start = reprojection_statistics(perturb(noisy, small.start));
    EXPECT_EQ(start.behind_camera, 0) << full.name;
    // The unknowns take up their share of the noise: the final cost is below that at the truth.
    const double unknowns = static_cast<double>(9 * small.cameras + 3 * small.points);
    const double left = 1 - unknowns / static_cast<double>(2 * small.observations);
    const double ratio = start.cost / (left * reprojection_statistics(noisy).cost);
    EXPECT_GT(ratio, 50) << full.name;
    EXPECT_LT(ratio, 250) << full.name;
  }
}

TEST(Presets, OfFullSizeIsExact) {
  const Preset& each = preset("trafalgar-257");
  const Scene scene = preset_scene(each);
  expect_sound(scene);
  EXPECT_EQ(scene.truth.camera_count(), 257);
  EXPECT_EQ(scene.truth.point_count(), 65132);
  EXPECT_EQ(scene.truth.observation_count(), 225911);
}

TEST(Presets, RefuseUnknownNamesAndSizes) {
  EXPECT_THROW(preset("venice"), InputError);
  EXPECT_THROW(resized(preset("venice-1778"), 0), InputError);
  EXPECT_THROW(resized(preset("venice-1778"), 11), InputError);
  EXPECT_THROW(resized(preset("venice-1778"), std::nan("")), InputError);
  EXPECT_EQ(resized(preset("venice-1778"), 1).observations, 5001946);
}

}  // namespace
}  // namespace raybundle::scenes
