#include <raybundle/bench/micro/workload.h>

#include <memory>

#include <raybundle/models/scenes/noise.h>
#include <raybundle/models/scenes/photos.h>

namespace raybundle::bench {

Problem photos(std::int64_t observations) {
  const scenes::Scene scene = scenes::photos_scene({.seed = 1,
                                                    .cameras = observations / 1100,
                                                    .points = observations * 2 / 9,
                                                    .observations = observations,
                                                    .sights = 0});
  return scenes::perturb(scenes::add_noise(scene).problem);
}

Workload::Workload(std::int64_t observations, int threads)
    : pool(threads),
      problem(photos(observations)),
      objective(problem, {}, pool),
      layout(objective.layout()),
      state(objective.state_of(problem)),
      J(layout, linalg::Precision::single_precision),
      normal(layout),
      damping(linalg::index(layout.unknowns())),
      schur(layout, linalg::Side::leaves, pool),
      x(linalg::index(schur.size()), 1e-3),
      y(x.size()),
      step(damping.size()) {
  objective.linearize(state, J, normal);
  normal.diagonal(1e-6, 1e32, damping.data(), pool);
  for (double& d : damping) d *= 1e-4;
  schur.prepare(at(), damping.data());
  const auto& begin = layout.leaf_side.begin;
  for (std::int64_t i = 0; i < layout.leaves; ++i) {
    const std::int64_t track = begin[linalg::index(i + 1)] - begin[linalg::index(i)];
    couples += track * (track + 1) / 2;
  }
}

linalg::SymmetricBlocks& Workload::reduced_matrix() {
  if (!reduced_) reduced_.emplace(schur.pattern(), linalg::SymmetricBlocks::Storage::sparse);
  return *reduced_;
}

std::int64_t Workload::reduced_nonzeros() const {
  return reduced_ ? reduced_->pattern().scalar_nonzeros() : 0;
}

Workload& workload(std::int64_t observations, int threads) {
  static std::unique_ptr<Workload> kept;
  static std::int64_t kept_observations = 0;
  if (!kept || kept_observations != observations || kept->pool.threads() != threads) {
    kept.reset();
    kept = std::make_unique<Workload>(observations, threads);
    kept_observations = observations;
  }
  return *kept;
}

}  // namespace raybundle::bench
