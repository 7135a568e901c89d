#include <raybundle/linalg/ordering.h>

#include <raybundle/linalg/cholmod_session.h>

#include <algorithm>
#include <new>
#include <optional>

namespace raybundle::linalg {
namespace {

// What the factor holds when block column k of the ordering has count[k] blocks. Where block sizes
// differ, fill is between the large blocks: they are what the rows are counted as.
void predict(const SymmetricPattern& pattern, const SuiteSparse_long* count, Ordering& ordering) {
  std::int64_t largest = 0;
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    largest = std::max(largest, pattern.block_size(a));
  }
  for (std::size_t k = 0; k < ordering.permutation.size(); ++k) {
    const auto width = static_cast<double>(pattern.block_size(ordering.permutation[k]));
    const double height = static_cast<double>(count[k]) * static_cast<double>(largest);
    ordering.nonzeros += width * height;
    ordering.flops += width * height * height;
  }
}

std::optional<Ordering> analyze(const SymmetricPattern& pattern, int cholmod_method) {
  CholmodSession session;
  cholmod_common& common = session.common;
  common.method[0].ordering = cholmod_method;
  common.supernodal = CHOLMOD_SIMPLICIAL;  // fill is counted, not factorised
  std::vector<std::int64_t> begin = pattern.row_begin;
  std::vector<std::int64_t> row(pattern.column.begin(), pattern.column.end());
  cholmod_sparse A = lower_triangle(pattern.blocks(), begin, row, nullptr);
  cholmod_factor* factor = cholmod_l_analyze(&A, &common);
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (factor == nullptr) return std::nullopt;

  Ordering found;
  const auto* order = static_cast<const SuiteSparse_long*>(factor->Perm);
  found.permutation.assign(order, order + pattern.blocks());
  predict(pattern, static_cast<const SuiteSparse_long*>(factor->ColCount), found);
  cholmod_l_free_factor(&factor, &common);
  return found;
}

}  // namespace

Ordering find_ordering(const SymmetricPattern& pattern) {
  std::optional<Ordering> degree = analyze(pattern, CHOLMOD_AMD);
  std::optional<Ordering> dissection = analyze(pattern, CHOLMOD_METIS);
  if (degree) degree->method = "minimum degree";
  if (dissection) dissection->method = "nested dissection";
  if (!degree && !dissection) throw std::bad_alloc();
  const bool dissect = dissection && (!degree || dissection->nonzeros < degree->nonzeros);
  return dissect ? *std::move(dissection) : *std::move(degree);
}

}  // namespace raybundle::linalg
