#include <raybundle/solver/init/view_graph.h>

#include <raybundle/linalg/block_layout.h>

#include <atomic>
#include <mutex>
#include <optional>

namespace raybundle::init {
namespace {

std::optional<ViewEdge> edge_of(const Sightings& sightings, const ImagePair& pair,
                                const RelativePoseOptions& options, std::uint64_t seed) {
  const auto stream =
      static_cast<std::uint64_t>(pair.i) * static_cast<std::uint64_t>(sightings.images()) +
      static_cast<std::uint64_t>(pair.j);
  Random random(seed, stream);
  const auto view = relative_pose(sightings.pairs(pair.i, pair.j), options, random);
  if (!view) return {};
  return ViewEdge{.i = pair.i,
                  .j = pair.j,
                  .pose = view->pose,
                  .alone = view->pose,
                  .kind = view->kind,
                  .R_other = view->R_other,
                  .common = pair.common,
                  .inliers = static_cast<std::int64_t>(view->inliers.size()),
                  .parallax = view->parallax};
}

}  // namespace

ViewGraph view_graph(const Sightings& sightings, std::span<const ImagePair> pairs,
                     const RelativePoseOptions& options, std::uint64_t seed,
                     linalg::ThreadPool& pool, const Progress& progress) {
  const auto count = static_cast<std::int64_t>(pairs.size());
  std::vector<std::optional<ViewEdge>> edges(pairs.size());
  std::mutex mutex;
  std::int64_t done = 0;
  std::atomic<bool> stopped = false;
  pool.run(count, [&](std::int64_t k) {
    if (stopped) return;
    edges[linalg::index(k)] = edge_of(sightings, pairs[linalg::index(k)], options, seed);
    if (!progress) return;
    const std::lock_guard lock(mutex);
    if (progress("pairs", ++done, count) == Control::stop) stopped = true;
  });
  ViewGraph graph = {sightings.images(), {}, stopped};
  for (const auto& edge : edges) {
    if (edge) graph.edges.push_back(*edge);
  }
  return graph;
}

}  // namespace raybundle::init
