#include <raybundle/models/scenes/street.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <raybundle/models/error.h>
#include <raybundle/models/scenes/random.h>
#include <raybundle/models/statistics.h>

namespace raybundle::scenes {
namespace {

/// FNV-1a over 64-bit words: the same on machines of either byte order.
class Hash {
 public:
  void add(std::uint64_t word) {
    for (int k = 0; k < 8; ++k, word >>= 8) value_ = (value_ ^ (word & 0xFF)) * 0x100000001B3U;
  }
  void add(const std::vector<double>& values) {
    for (const double x : values) add(std::bit_cast<std::uint64_t>(x));
  }
  void add(const std::vector<std::int32_t>& values) {
    for (const std::int32_t i : values) add(static_cast<std::uint64_t>(i));
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xCBF29CE484222325U;
};

std::uint64_t hash(const Problem& problem) {
  Hash result;
  result.add(problem.cameras);
  result.add(problem.points);
  result.add(problem.observation_camera);
  result.add(problem.observation_point);
  result.add(problem.observations);
  return result.value();
}

TEST(Random, BitsArePinned) {
  Random random(1);
  EXPECT_EQ(random.bits(), 0xA4F53D3266AE449EU);
  EXPECT_EQ(random.bits(), 0xF53FEDF0B2F7A850U);
  Hash normals;
  for (int k = 0; k < 1000; ++k) normals.add(std::bit_cast<std::uint64_t>(random.normal()));
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
  const StreetScene scene = street_scene();
  EXPECT_EQ(hash(scene.start), 0x44D624FE572B3B73U);
  EXPECT_EQ(hash(scene.truth), 0x72685159046EEA1EU);
}

TEST(Street, DependsOnItsOptionsOnly) {
  EXPECT_EQ(hash(street()), hash(street_scene().start));
  EXPECT_EQ(hash(street({.seed = 5, .cameras = 9})), hash(street({.seed = 5, .cameras = 9})));
  EXPECT_NE(hash(street({.seed = 5})), hash(street({.seed = 6})));
}

TEST(Street, NoiseDoesNotChangeWhatIsThere) {
  const StreetScene quiet = street_scene({.pixel_noise = 0});
  const StreetScene loud =
      street_scene({.pixel_noise = 3, .rotation_noise = 0.1, .position_noise = 1});
  EXPECT_EQ(quiet.truth.cameras, loud.truth.cameras);
  EXPECT_EQ(quiet.truth.points, loud.truth.points);
  EXPECT_EQ(quiet.truth.observation_camera, loud.truth.observation_camera);
}

TEST(Street, HasTheShapeOfARealProblem) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const StreetScene scene = street_scene({.seed = seed});
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
    EXPECT_EQ(reprojection_statistics(scene.start).behind_camera, 0);
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

TEST(Street, TruthFitsUpToThePixelNoise) {
  for (const double noise : {0.0, 0.5, 4.0}) {
    const Problem truth = street_scene({.pixel_noise = noise}).truth;
    // Two components per observation; four standard deviations of their root mean square.
    const double count = 2.0 * static_cast<double>(truth.observation_count());
    const double rmse = reprojection_statistics(truth).rmse / std::sqrt(2.0);
    EXPECT_NEAR(rmse, noise, 4 * noise / std::sqrt(2 * count) + 1e-12);
  }
}

TEST(Street, StartIsWorseThanTheTruthBySomeHundredTimes) {
  const StreetScene scene = street_scene();
  const double ratio =
      reprojection_statistics(scene.start).cost / reprojection_statistics(scene.truth).cost;
  EXPECT_GT(ratio, 50);
  EXPECT_LT(ratio, 1000);
}

TEST(Street, StartIsOffByTheNoiseAskedFor) {
  const StreetScene scene =
      street_scene({.cameras = 400, .points = 400, .rotation_noise = 0.02, .position_noise = 0});
  double squares = 0;
  for (std::size_t j = 0; j < scene.start.cameras.size(); j += 9) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double d = scene.start.cameras[j + k] - scene.truth.cameras[j + k];
      squares += d * d;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / 1200), 0.02, 4 * 0.02 / std::sqrt(2400));
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
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_THROW(street({.cameras = 1}), InputError);
  EXPECT_THROW(street({.cameras = -5}), InputError);
  EXPECT_THROW(street({.points = 0}), InputError);
  EXPECT_THROW(street({.points = std::int64_t{1} << 31}), InputError);
  EXPECT_THROW(street({.pixel_noise = -1}), InputError);
  EXPECT_THROW(street({.rotation_noise = nan}), InputError);
  EXPECT_THROW(street({.position_noise = infinity}), InputError);
  EXPECT_THROW(street({.point_noise = -0.1}), InputError);
}

}  // namespace
}  // namespace raybundle::scenes
