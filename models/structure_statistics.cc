#include <raybundle/models/statistics.h>

#include <algorithm>
#include <bit>
#include <numeric>
#include <utility>

namespace raybundle {
namespace {

std::size_t index(std::int64_t i) { return static_cast<std::size_t>(i); }

/// Who belongs to whom: members of group g stand at member[begin[g]] .. member[begin[g + 1]].
struct Groups {
  std::vector<std::int64_t> begin;
  std::vector<std::int32_t> member;

  std::int64_t count() const { return static_cast<std::int64_t>(begin.size()) - 1; }
  std::int64_t size(std::int64_t g) const { return begin[index(g + 1)] - begin[index(g)]; }
  const std::int32_t* first(std::int64_t g) const { return member.data() + begin[index(g)]; }
  const std::int32_t* last(std::int64_t g) const { return member.data() + begin[index(g + 1)]; }
};

/// Groups `member[k]` by `group[k]`, in the order of k: a counting sort.
Groups group_by(const std::vector<std::int32_t>& group, const std::vector<std::int32_t>& member,
                std::int64_t groups) {
  Groups result;
  result.begin.assign(index(groups + 1), 0);
  for (const std::int32_t g : group) ++result.begin[index(g) + 1];
  std::partial_sum(result.begin.begin(), result.begin.end(), result.begin.begin());
  result.member.resize(member.size());
  std::vector<std::int64_t> next(result.begin.begin(), result.begin.end() - 1);
  for (std::size_t k = 0; k < group.size(); ++k) {
    result.member[index(next[index(group[k])]++)] = member[k];
  }
  return result;
}

/// Disjoint sets of cameras with union by size and path halving.
class DisjointSets {
 public:
  explicit DisjointSets(std::int64_t count) : parent_(index(count)), size_(index(count), 1) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  std::int32_t root(std::int32_t i) {
    while (parent_[index(i)] != i) {
      parent_[index(i)] = parent_[index(parent_[index(i)])];
      i = parent_[index(i)];
    }
    return i;
  }

  void unite(std::int32_t i, std::int32_t j) {
    i = root(i);
    j = root(j);
    if (i == j) return;
    if (size_[index(i)] < size_[index(j)]) std::swap(i, j);
    parent_[index(j)] = i;
    size_[index(i)] += size_[index(j)];
  }

  std::int64_t size(std::int32_t root) const { return size_[index(root)]; }

 private:
  std::vector<std::int32_t> parent_;
  std::vector<std::int64_t> size_;
};

/// Degrees of the points, their duplicates and track lengths.
void point_degrees(const Groups& cameras_of, StructureStatistics& result) {
  std::vector<std::int64_t> last_point(index(result.cameras), -1);  // that the camera was met at
  for (std::int64_t i = 0; i < cameras_of.count(); ++i) {
    std::int64_t distinct = 0;
    for (const std::int32_t* j = cameras_of.first(i); j != cameras_of.last(i); ++j) {
      if (last_point[index(*j)] != i) {
        last_point[index(*j)] = i;
        ++distinct;
      } else if (result.duplicate_observations++ == 0) {
        result.first_duplicate_camera = *j;
        result.first_duplicate_point = i;
      }
    }
    if (distinct == 0 && result.unobserved_points++ == 0) result.first_unobserved_point = i;
    if (distinct == 1 && result.points_seen_once++ == 0) result.first_point_seen_once = i;
    result.longest_track = std::max(result.longest_track, cameras_of.size(i));
  }
  const std::int64_t observed = result.points - result.unobserved_points;
  if (observed > 0) {
    result.mean_track_length =
        static_cast<double>(result.observations) / static_cast<double>(observed);
  }
}

void camera_degrees(const Groups& points_of, StructureStatistics& result) {
  for (std::int64_t j = 0; j < points_of.count(); ++j) {
    const std::int64_t degree = points_of.size(j);
    if (degree == 0) {
      if (result.unobserved_cameras++ == 0) result.first_unobserved_camera = j;
      continue;
    }
    const bool first = result.most_observations == 0;
    result.fewest_observations = first ? degree : std::min(result.fewest_observations, degree);
    result.most_observations = std::max(result.most_observations, degree);
  }
}

void connectivity(const Groups& cameras_of, const Groups& points_of, StructureStatistics& result) {
  DisjointSets sets(result.cameras);
  for (std::int64_t i = 0; i < cameras_of.count(); ++i) {
    for (const std::int32_t* j = cameras_of.first(i); j != cameras_of.last(i); ++j) {
      sets.unite(*cameras_of.first(i), *j);
    }
  }
  for (std::int32_t j = 0; j < static_cast<std::int32_t>(result.cameras); ++j) {
    if (points_of.size(j) == 0 || sets.root(j) != j) continue;
    ++result.components;
    result.largest_component = std::max(result.largest_component, sets.size(j));
  }
}

/// Counts the pairs of cameras that share a point, camera by camera. A short track is walked
/// through; a long one (more cameras than a set of bits has words) is a set of bits, made once.
class PairCounter {
 public:
  PairCounter(const Groups& cameras_of, const Groups& points_of)
      : cameras_of_(cameras_of),
        points_of_(points_of),
        words_((points_of.count() + 63) / 64),
        bits_of_(index(cameras_of.count()), -1),
        seen_with_(index(points_of.count()), -1),
        row_(index(words_), 0) {
    for (std::int64_t i = 0; i < cameras_of.count(); ++i) {
      if (cameras_of.size(i) <= words_) continue;
      bits_of_[index(i)] = static_cast<std::int64_t>(bits_.size());
      bits_.resize(bits_.size() + index(words_), 0);
      std::uint64_t* bits = bits_.data() + bits_of_[index(i)];
      for (const std::int32_t* j = cameras_of.first(i); j != cameras_of.last(i); ++j) set(bits, *j);
    }
  }

  /// Cameras after camera j that share a point with it.
  std::int64_t later_partners(std::int64_t j) {
    bool long_tracks = false;
    partners_.clear();
    for (const std::int32_t* i = points_of_.first(j); i != points_of_.last(j); ++i) {
      if (bits_of_[index(*i)] < 0) {
        walk(j, *i);
        continue;
      }
      if (!long_tracks) std::fill(row_.begin(), row_.end(), 0);
      long_tracks = true;
      const std::uint64_t* bits = bits_.data() + bits_of_[index(*i)];
      for (std::int64_t w = j / 64; w < words_; ++w) row_[index(w)] |= bits[w];
    }
    if (!long_tracks) return static_cast<std::int64_t>(partners_.size());
    for (const std::int32_t partner : partners_) set(row_.data(), partner);
    row_[index(j / 64)] &= ~std::uint64_t{1} << (j % 64);  // only what comes after j
    std::int64_t count = 0;
    for (std::int64_t w = j / 64; w < words_; ++w) count += std::popcount(row_[index(w)]);
    return count;
  }

 private:
  static void set(std::uint64_t* bits, std::int32_t j) {
    bits[j / 64] |= std::uint64_t{1} << (j % 64);
  }

  void walk(std::int64_t j, std::int32_t point) {
    for (const std::int32_t* k = cameras_of_.first(point); k != cameras_of_.last(point); ++k) {
      if (*k <= j || seen_with_[index(*k)] == j) continue;
      seen_with_[index(*k)] = j;
      partners_.push_back(*k);
    }
  }

  const Groups& cameras_of_;
  const Groups& points_of_;
  std::int64_t words_;                 // of a set of cameras
  std::vector<std::int64_t> bits_of_;  // per point: where its set starts in bits_, or -1
  std::vector<std::uint64_t> bits_;
  std::vector<std::int64_t> seen_with_;  // per camera: the last camera it was a partner of
  std::vector<std::uint64_t> row_;       // partners of the current camera, where tracks are long
  std::vector<std::int32_t> partners_;   // its partners from short tracks
};

/// Who observes whom, both ways.
struct Incidences {
  explicit Incidences(const Problem& problem)
      : cameras_of(
            group_by(problem.observation_point, problem.observation_camera, problem.point_count())),
        points_of(group_by(problem.observation_camera, problem.observation_point,
                           problem.camera_count())) {}

  Groups cameras_of;
  Groups points_of;
};

StructureStatistics of_groups(const Problem& problem, const Incidences& incidences) {
  StructureStatistics result;
  result.cameras = problem.camera_count();
  result.points = problem.point_count();
  result.observations = problem.observation_count();
  point_degrees(incidences.cameras_of, result);
  camera_degrees(incidences.points_of, result);
  connectivity(incidences.cameras_of, incidences.points_of, result);
  return result;
}

std::string counted(std::int64_t count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string first(const std::string& what, std::int64_t i) {
  return " (first: " + what + " " + std::to_string(i) + ")";
}

}  // namespace

StructureStatistics degree_statistics(const Problem& problem) {
  return of_groups(problem, Incidences(problem));
}

StructureStatistics structure_statistics(const Problem& problem) {
  const Incidences incidences(problem);
  StructureStatistics result = of_groups(problem, incidences);
  PairCounter pairs(incidences.cameras_of, incidences.points_of);
  for (std::int64_t j = 0; j < result.cameras; ++j) {
    result.camera_pairs += pairs.later_partners(j);
  }
  const ParallaxStatistics parallax = parallax_statistics(problem);
  result.low_parallax_points = parallax.low;
  result.collinear_points = parallax.collinear;
  return result;
}

std::vector<std::string> warnings(const StructureStatistics& s) {
  std::vector<std::string> result;
  if (s.unobserved_cameras > 0) {
    result.push_back(counted(s.unobserved_cameras, "camera has no observations and stays as it is",
                             "cameras have no observations and stay as they are") +
                     first("camera", s.first_unobserved_camera));
  }
  if (s.unobserved_points > 0) {
    result.push_back(counted(s.unobserved_points, "point is not observed and stays as it is",
                             "points are not observed and stay as they are") +
                     first("point", s.first_unobserved_point));
  }
  if (s.points_seen_once > 0) {
    result.push_back(counted(s.points_seen_once, "point is observed by one camera only: its depth",
                             "points are observed by one camera only: their depth") +
                     " is not determined" + first("point", s.first_point_seen_once));
  }
  if (s.duplicate_observations > 0) {
    result.push_back(
        counted(s.duplicate_observations, "observation repeats", "observations repeat") +
        " a camera and point that occurred before; all count (first: camera " +
        std::to_string(s.first_duplicate_camera) + ", point " +
        std::to_string(s.first_duplicate_point) + ")");
  }
  if (s.components > 1) {
    result.push_back("the cameras fall into " + std::to_string(s.components) +
                     " sets that share no points (largest: " +
                     counted(s.largest_component, "camera", "cameras") +
                     "): their places relative to one another are not determined");
  }
  return result;
}

}  // namespace raybundle
