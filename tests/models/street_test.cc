#include <raybundle/models/scenes/street.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/random.h>
#include <raybundle/models/scenes/camera.h>
#include <raybundle/models/statistics.h>
#include <raybundle/tests/models/scene_hash.h>

namespace raybundle::scenes {
namespace {

using test::hash;
using test::Hash;

TEST(Random, BitsArePinned) {
  Random random(1);
  EXPECT_EQ(random.bits(), 0xA4F53D3266AE449EU);
  EXPECT_EQ(random.bits(), 0xF53FEDF0B2F7A850U);
  Hash normals;
  for (int k = 0; k < 1000; ++k) normals.add(random.normal());
  EXPECT_EQ(normals.value(), 0xD8155D063955ABC2U);
}

TEST(Random, SeedsAndStreamsDiffer) {
  std::set<std::uint64_t> firsts;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (std::uint64_t stream = 0; stream < 50; ++stream) {
      firsts.insert(Random(seed, stream).bits());
    }
  }
  EXPECT_EQ(firsts.size(), 2500U);
}

TEST(Random, UniformNumbersFillTheUnitInterval) {
  Random random(2);
  std::vector<int> bins(20, 0);
  constexpr int count = 100000;
  for (int k = 0; k < count; ++k) {
    const double x = random.uniform();
    ASSERT_GE(x, 0);
    ASSERT_LT(x, 1);
    ++bins[static_cast<std::size_t>(20 * x)];
  }
  double chi_squared = 0;
  for (const int bin : bins) chi_squared += (bin - 5000.0) * (bin - 5000.0) / 5000.0;
  EXPECT_LT(chi_squared, 43.8);  // 19 degrees of freedom: exceeded once in a thousand seeds
}

TEST(Random, NormalNumbersHaveTheNormalDistribution) {
  Random random(3);
  constexpr int count = 200000;
  std::vector<double> x(count);
  for (double& value : x) value = random.normal();
  std::sort(x.begin(), x.end());
  double distance = 0;  // Kolmogorov-Smirnov
  for (int k = 0; k < count; ++k) {
    const double cdf = 0.5 * std::erfc(-x[static_cast<std::size_t>(k)] / std::sqrt(2.0));
    distance = std::max(
        {distance, std::abs(cdf - k / double{count}), std::abs(cdf - (k + 1) / double{count})});
  }
  EXPECT_LT(distance * std::sqrt(count), 1.95);  // exceeded once in a thousand seeds
  EXPECT_GT(x.back(), 4);                        // has tails
  EXPECT_LT(x.front(), -4);
}

TEST(Random, BelowReachesEveryValue) {
  Random random(4);
  std::vector<int> seen(7, 0);
  for (int k = 0; k < 1000; ++k) ++seen[static_cast<std::size_t>(random.below(7))];
  EXPECT_GT(*std::min_element(seen.begin(), seen.end()), 100);
}

TEST(Street, DefaultSceneIsPinned) {
  // Must hold for every compiler, machine and set of flags.
  EXPECT_EQ(hash(street()), 0x44D624FE572B3B73U);
  EXPECT_EQ(hash(street_scene({.observations = 9000}).truth), 0x349982CFF5BAC4F8U);
  EXPECT_EQ(hash(street_scene({.cameras = 400, .lap = 200}).truth), 0x6D5414DBFB73662BU);
}

TEST(Street, DependsOnItsOptionsOnly) {
  EXPECT_EQ(hash(street()), hash(street()));
  EXPECT_EQ(hash(street({.seed = 5, .cameras = 9})), hash(street({.seed = 5, .cameras = 9})));
  EXPECT_NE(hash(street({.seed = 5})), hash(street({.seed = 6})));
}

TEST(Street, HasTheShapeOfARealProblem) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = street_scene({.seed = seed});
    const StructureStatistics s = structure_statistics(scene.truth);
    EXPECT_EQ(s.cameras, 30);
    EXPECT_EQ(s.points, 3000);
    EXPECT_EQ(s.unobserved_cameras + s.unobserved_points + s.points_seen_once, 0);
    EXPECT_EQ(s.duplicate_observations, 0);
    EXPECT_EQ(s.components, 1);
    EXPECT_GE(s.fewest_observations, 100);
    EXPECT_GE(s.longest_track, 20);  // a tail ...
    EXPECT_LE(s.mean_track_length, 10);
    EXPECT_GE(s.low_parallax_points, 100);  // far features and features straight ahead
    EXPECT_EQ(reprojection_statistics(scene.truth).behind_camera, 0);
    EXPECT_EQ(reprojection_statistics(street({.seed = seed})).behind_camera, 0);
  }
}

TEST(Street, ObservationsAreSortedByPointThenCamera) {
  const Problem problem = street();
  std::vector<std::pair<int, int>> pairs;
  for (std::size_t k = 0; k < problem.observation_point.size(); ++k) {
    pairs.emplace_back(problem.observation_point[k], problem.observation_camera[k]);
  }
  EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
}

TEST(Street, IsExact) {
  for (const std::int64_t lap : {0, 200}) {
    const Problem truth = street_scene({.cameras = 300, .lap = lap}).truth;
    EXPECT_LT(reprojection_statistics(truth).largest, 1e-8);
  }
}

TEST(Street, StartsFromTheSceneWithHalfAPixelOfNoise) {
  const Problem start = street();
  Problem truth = street_scene().truth;
  EXPECT_EQ(start.observation_camera, truth.observation_camera);
  EXPECT_EQ(start.observation_point, truth.observation_point);
  truth.observations = start.observations;
  const double at_truth = reprojection_statistics(truth).cost;
  const double count = 2.0 * static_cast<double>(truth.observation_count());
  EXPECT_NEAR(std::sqrt(2 * at_truth / count), 0.5, 4 * 0.5 / std::sqrt(2 * count));
  const double ratio = reprojection_statistics(start).cost / at_truth;
  EXPECT_GT(ratio, 50);
  EXPECT_LT(ratio, 1000);
}

TEST(Street, HasTheObservationsAskedFor) {
  for (const std::int64_t observations : {10000, 21000, 40000}) {
    const Problem truth =
        street_scene({.cameras = 100, .points = 5000, .observations = observations}).truth;
    const StructureStatistics s = structure_statistics(truth);
    EXPECT_EQ(s.observations, observations);
    EXPECT_EQ(s.points_seen_once + s.unobserved_points + s.duplicate_observations, 0);
    EXPECT_EQ(s.components, 1);
    EXPECT_GE(s.fewest_observations, 50);
  }
}

TEST(Street, LoopsCloseAndAreSeenToClose) {
  const std::int64_t lap = 200;
  const Problem truth =
      street_scene({.cameras = 500, .points = 10000, .observations = 45000, .lap = lap}).truth;
  EXPECT_LT(reprojection_statistics(truth).largest, 1e-8);
  for (std::int64_t j = 0; j < 300; ++j) {  // the same place again
    const Vec3 d = difference(camera_of(truth, j).centre, camera_of(truth, j + lap).centre);
    EXPECT_LT(norm(d), 0.5);
  }
  const double seam =
      norm(difference(camera_of(truth, lap - 1).centre, camera_of(truth, lap).centre));
  EXPECT_NEAR(seam, 1, 0.3);
  std::int64_t revisits = 0;
  for (std::size_t k = 1; k < truth.observation_camera.size(); ++k) {
    if (truth.observation_point[k] != truth.observation_point[k - 1]) continue;
    if (truth.observation_camera[k] - truth.observation_camera[k - 1] > lap / 2) ++revisits;
  }
  EXPECT_GT(revisits, 1000);
  EXPECT_EQ(structure_statistics(truth).components, 1);
}

/// Whether all observers of a point lie within 2 degrees of a line through it, seen from there.
bool is_collinear(const Problem& truth, std::size_t first, std::size_t last) {
  const Vec3 X = point_of(truth, truth.observation_point[first]);
  const auto ray = [&](std::size_t k) {
    const Vec3 d = difference(X, camera_of(truth, truth.observation_camera[k]).centre);
    return scaled(1 / norm(d), d);
  };
  const auto centre = [&](std::size_t k) {
    return camera_of(truth, truth.observation_camera[k]).centre;
  };
  const Vec3 way = difference(centre(last - 1), centre(first));
  return norm(cross(ray(first), ray(last - 1))) < 0.035 &&
         norm(cross(ray(first), scaled(1 / norm(way), way))) < 0.035;
}

double collinear_share(const Problem& truth) {
  double count = 0;
  const std::size_t rows = truth.observation_point.size();
  for (std::size_t first = 0, last = 0; first < rows; first = last) {
    while (last < rows && truth.observation_point[last] == truth.observation_point[first]) ++last;
    if (is_collinear(truth, first, last)) ++count;
  }
  return count / static_cast<double>(truth.point_count());
}

TEST(Street, HasTheShareOfCollinearPointsAskedFor) {
  const StreetOptions none = {.cameras = 20, .points = 1000};
  const double natural = collinear_share(street_scene(none).truth);
  for (const double share : {0.2, 0.6}) {
    StreetOptions options = none;
    options.collinear_share = share;
    const Problem truth = street_scene(options).truth;
    EXPECT_NEAR(collinear_share(truth), share + (1 - share) * natural, 0.05);
    EXPECT_EQ(structure_statistics(truth).points_seen_once, 0);
  }
}

TEST(Street, SmallestScenes) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const Problem problem = street({.seed = seed, .cameras = 2, .points = 1});
    EXPECT_EQ(problem.observation_count(), 2);
    EXPECT_NO_THROW(validate(problem));
  }
}

TEST(Street, LongStreetsStayOneProblem) {
  const Problem problem = street({.cameras = 500, .points = 5000});
  const StructureStatistics s = structure_statistics(problem);
  EXPECT_EQ(s.unobserved_cameras, 0);
  EXPECT_EQ(s.components, 1);
  EXPECT_NO_THROW(validate(problem));
}

TEST(Street, RefusesWhatMakesNoSense) {
  EXPECT_THROW(street({.cameras = 1}), InputError);
  EXPECT_THROW(street({.cameras = -5}), InputError);
  EXPECT_THROW(street({.points = 0}), InputError);
  EXPECT_THROW(street({.observations = 5999}), InputError);
  EXPECT_THROW(street({.lap = 100}), InputError);
  EXPECT_THROW(street({.lap = 201}), InputError);
  EXPECT_THROW(street({.points = std::int64_t{1} << 31}), InputError);
  EXPECT_THROW(street({.far_share = 1.1}), InputError);
  EXPECT_THROW(street({.collinear_share = -0.1}), InputError);
}

}  // namespace
}  // namespace raybundle::scenes
