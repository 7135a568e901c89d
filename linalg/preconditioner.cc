#include <raybundle/linalg/preconditioner.h>

#include <raybundle/linalg/block_factor.h>

#include <algorithm>
#include <array>

namespace raybundle::linalg {
namespace {

void invert_diagonal(const DiagonalBlocks& blocks, std::vector<double>& inverse) {
  inverse.clear();
  for (const auto& run : blocks.runs) {
    for (std::int64_t i = 0; i < run.count * run.size; ++i) {
      const double value = run.values[index(i * run.size + i % run.size)];
      inverse.push_back(value > 0 ? 1 / value : 0);
    }
  }
}

}  // namespace

void Preconditioner::build(Form form, const DiagonalBlocks& blocks, ThreadPool& pool) {
  form_ = form;
  if (form == Form::diagonal) invert_diagonal(blocks, inverse_);
  if (form != Form::blocks) return;
  factors_.runs.resize(blocks.runs.size());
  for (std::size_t k = 0; k < blocks.runs.size(); ++k) {
    const auto& run = blocks.runs[k];
    auto& factors = factors_.runs[k];
    factors.size = run.size;
    factors.count = run.count;
    factors.values.resize(run.values.size());
    const int entries = run.size * run.size;
    parallel_for(pool, run.count, 64, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t b = first; b < last; ++b) {
        inverse_factor(run.values.data() + b * entries, run.size,
                       factors.values.data() + b * entries);
      }
    });
  }
}

void Preconditioner::apply_blocks(const DiagonalBlocks::Run& run, const double* r, double* z,
                                  ThreadPool& pool) const {
  const int n = run.size;
  parallel_for(pool, run.count, 1024, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t b = first; b < last; ++b) {
      const double* F = run.values.data() + b * n * n;
      std::array<double, 12> y = {};
      for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) y[index(j)] += F[i * n + j] * r[b * n + i];
      }
      for (int i = 0; i < n; ++i) {
        double sum = 0;
        for (int j = 0; j < n; ++j) sum += F[i * n + j] * y[index(j)];
        z[b * n + i] = sum;
      }
    }
  });
}

void Preconditioner::apply(const double* r, double* z, std::int64_t size, ThreadPool& pool) const {
  switch (form_) {
    case Form::identity:
      std::copy_n(r, size, z);
      return;
    case Form::diagonal:
      for (std::int64_t i = 0; i < size; ++i) z[i] = inverse_[index(i)] * r[i];
      return;
    case Form::blocks:
      for (const auto& run : factors_.runs) {
        apply_blocks(run, r, z, pool);
        r += run.count * run.size;
        z += run.count * run.size;
      }
      return;
  }
}

}  // namespace raybundle::linalg
