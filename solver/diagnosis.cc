#include <raybundle/solver/diagnosis.h>

namespace raybundle {

Diagnoser::Diagnoser(const linalg::BlockLayout& layout, linalg::ThreadPool& pool)
    : layout_(layout), pool_(pool), reduced_(layout, pool) {}

Diagnosis Diagnoser::measure(const linalg::Linearization& at) {
  const linalg::BlockSpectrum points = linalg::block_spectrum(
      at.normal->C.data(), layout_.leaf_size, layout_.leaves, nullptr, pool_);
  const linalg::Spectrum reduced = reduced_.measure(at);
  return {points.smallest, points.largest, points.worst_condition, reduced.smallest,
          reduced.largest};
}

}  // namespace raybundle
