#include <raybundle/linalg/explicit_system.h>

#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <string>
#include <utility>

namespace raybundle::linalg {
namespace {

SymmetricPattern checked(SymmetricPattern pattern) {
  require_memory(ExplicitSystem::memory(pattern),
                 "the matrix of order " + std::to_string(pattern.order()));
  return pattern;
}

// One run for each stretch of equal sizes.
std::vector<DiagonalBlocks::Run> runs_of(const SymmetricPattern& pattern) {
  std::vector<DiagonalBlocks::Run> runs;
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    const auto size = static_cast<int>(pattern.block_size(a));
    if (runs.empty() || runs.back().size != size) runs.push_back({size, 0, {}});
    ++runs.back().count;
  }
  for (DiagonalBlocks::Run& run : runs) run.values.resize(index(run.count * run.size * run.size));
  return runs;
}

}  // namespace

ExplicitSystem::ExplicitSystem(std::unique_ptr<ReducedSystem> system, SymmetricPattern pattern,
                               ThreadPool& pool)
    : system_(std::move(system)),
      pool_(pool),
      A_(checked(std::move(pattern)), SymmetricBlocks::Storage::sparse),
      product_(A_.pattern()),
      v_(index(system_->size())) {}

double ExplicitSystem::memory(const SymmetricPattern& pattern) {
  return 8.0 * static_cast<double>(pattern.scalar_nonzeros()) +
         20.0 * static_cast<double>(pattern.column.size()) + SymmetricProduct::memory(pattern);
}

void ExplicitSystem::prepare(const Linearization& at, const double* damping) {
  system_->prepare(at, damping);
  system_->assemble(A_, v_.data());
}

void ExplicitSystem::gradient(double* v) { std::copy(v_.begin(), v_.end(), v); }

void ExplicitSystem::apply(const double* x, double* y) { product_.multiply(A_, x, y, pool_); }

void ExplicitSystem::reduced_diagonal(DiagonalBlocks& out, double* v) {
  gradient(v);
  if (out.runs.empty()) out.runs = runs_of(A_.pattern());
  std::int64_t a = 0;
  for (DiagonalBlocks::Run& run : out.runs) {
    double* value = run.values.data();
    for (const std::int64_t end = a + run.count; a < end; ++a) {
      const double* block = A_.row(a);
      for (int i = 0; i < run.size; ++i) {
        for (int j = 0; j < run.size; ++j) {
          *value++ = block[std::min(i, j) * A_.stride(a) + std::max(i, j)];
        }
      }
    }
  }
}

}  // namespace raybundle::linalg
