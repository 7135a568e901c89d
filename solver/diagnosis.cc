#include <raybundle/solver/diagnosis.h>

#include <algorithm>

namespace raybundle {

Diagnoser::Diagnoser(const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
    : layout_(layout), pool_(pool), reduced_(layout, pool) {}

double Diagnoser::memory(const linalg::LayoutSize& n) {
  const auto hubs = static_cast<double>(n.size(linalg::Side::hubs));
  const double lanczos = std::min(100.0, hubs) * hubs;  // its directions
  return reduced_system_memory(n, linalg::Side::leaves, true) +
         8 * (static_cast<double>(n.unknowns()) + lanczos);
}

Diagnosis Diagnoser::measure(const linalg::Linearization& at) {
  const linalg::BlockSpectrum points = linalg::block_spectrum(
      at.normal->C.data(), layout_.leaf_size, layout_.leaves, nullptr, pool_);
  const linalg::Spectrum reduced = reduced_.measure(at);
  return {points.smallest, points.largest, points.worst_condition, reduced.smallest,
          reduced.largest};
}

}  // namespace raybundle
