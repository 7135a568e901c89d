#include <raybundle/linalg/cholmod_cholesky.h>

#include <raybundle/linalg/blas_threads.h>
#include <raybundle/linalg/cholmod_session.h>
#include <raybundle/linalg/memory.h>

#include <algorithm>
#include <limits>
#include <new>
#include <string>

namespace raybundle::linalg {
namespace {

std::vector<std::int64_t> scalar_permutation(const SymmetricPattern& pattern,
                                             const std::vector<std::int64_t>& blocks) {
  std::vector<std::int64_t> scalar;
  scalar.reserve(index(pattern.order()));
  for (const std::int64_t a : blocks) {
    for (std::int64_t i = pattern.offset[index(a)]; i < pattern.offset[index(a + 1)]; ++i) {
      scalar.push_back(i);
    }
  }
  return scalar;
}

}  // namespace

struct CholmodCholesky::Cholmod {
  explicit Cholmod(const SymmetricPattern& block_pattern) : pattern(block_pattern) {}
  ~Cholmod() {
    cholmod_l_free_dense(&solution, &session.common);
    cholmod_l_free_dense(&y, &session.common);
    cholmod_l_free_dense(&e, &session.common);
    cholmod_l_free_factor(&L, &session.common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  void fill_scalar_pattern();
  void check_memory() const {
    if (session.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  }

  const SymmetricPattern& pattern;
  CholmodSession session;
  cholmod_factor* L = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* y = nullptr;  // workspaces of solve()
  cholmod_dense* e = nullptr;
  std::vector<std::int64_t> begin;  // scalar columns of the lower triangle
  std::vector<std::int64_t> row;
  std::vector<std::int64_t> diagonal;  // where the diagonal entries of the columns stand
};

// A scalar row of a block row is a column of the lower triangle; the diagonal block is stored
// whole, and CHOLMOD ignores what lies above the diagonal.
void CholmodCholesky::Cholmod::fill_scalar_pattern() {
  begin.assign(1, 0);
  row.reserve(index(pattern.scalar_nonzeros()));
  for (std::int64_t a = 0; a < pattern.blocks(); ++a) {
    for (std::int64_t i = 0; i < pattern.block_size(a); ++i) {
      for (std::int64_t p = pattern.row_begin[index(a)]; p < pattern.row_begin[index(a + 1)]; ++p) {
        const std::int64_t b = pattern.column[index(p)];
        for (std::int64_t k = pattern.offset[index(b)]; k < pattern.offset[index(b + 1)]; ++k) {
          row.push_back(k);
        }
      }
      diagonal.push_back(begin.back() + i);  // the diagonal block comes first
      begin.push_back(static_cast<std::int64_t>(row.size()));
    }
  }
}

CholmodCholesky::CholmodCholesky(const SymmetricPattern& pattern, const Ordering& ordering)
    : cholmod_(std::make_unique<Cholmod>(pattern)) {
  Cholmod& c = *cholmod_;
  c.fill_scalar_pattern();
  std::vector<std::int64_t> permutation = scalar_permutation(pattern, ordering.permutation);
  cholmod_sparse A = lower_triangle(pattern.order(), c.begin, c.row, nullptr);
  c.session.common.method[0].ordering = CHOLMOD_GIVEN;
  c.L = cholmod_l_analyze_p(&A, reinterpret_cast<SuiteSparse_long*>(permutation.data()), nullptr, 0,
                            &c.session.common);
  if (c.L == nullptr) throw std::bad_alloc();
  require_memory(8 * static_cast<double>(c.L->xsize),
                 "the factor of a sparse matrix of order " + std::to_string(pattern.order()));
}

CholmodCholesky::~CholmodCholesky() = default;

double CholmodCholesky::memory(const SymmetricPattern& pattern, const Ordering& ordering) {
  // Values, row indices, and the permuted copies that CHOLMOD analyses and factors (as measured);
  // supernodes store the upper part of their diagonal blocks and some explicit zeros.
  constexpr double per_entry = 51;
  constexpr double supernode_overhead = 1.3;
  constexpr double libraries = 7e6;  // their code and the buffers of the BLAS
  return libraries + per_entry * static_cast<double>(pattern.scalar_nonzeros()) +
         supernode_overhead * 8 * ordering.nonzeros;
}

bool CholmodCholesky::factor(const SymmetricBlocks& A) {
  Cholmod& c = *cholmod_;
  const SingleThreadedBlas guard;
  cholmod_sparse matrix =
      lower_triangle(c.pattern.order(), c.begin, c.row, const_cast<double*>(A.values()));
  const int done = cholmod_l_factorize(&matrix, c.L, &c.session.common);
  c.check_memory();
  return done != 0 && c.session.common.status == CHOLMOD_OK && pivots_are_sound(A);
}

// CHOLMOD itself refuses only pivots that are not positive.
bool CholmodCholesky::pivots_are_sound(const SymmetricBlocks& A) const {
  const Cholmod& c = *cholmod_;
  const auto* super = static_cast<const SuiteSparse_long*>(c.L->super);
  const auto* row_begin = static_cast<const SuiteSparse_long*>(c.L->pi);
  const auto* value_begin = static_cast<const SuiteSparse_long*>(c.L->px);
  const auto* permutation = static_cast<const SuiteSparse_long*>(c.L->Perm);
  const auto* values = static_cast<const double*>(c.L->x);
  const double tolerance = static_cast<double>(c.L->n) * std::numeric_limits<double>::epsilon();
  for (std::size_t s = 0; s < c.L->nsuper; ++s) {
    const std::int64_t rows = row_begin[s + 1] - row_begin[s];
    for (std::int64_t k = super[s]; k < super[s + 1]; ++k) {
      const std::int64_t local = k - super[s];
      const double root = values[value_begin[s] + local * (rows + 1)];
      const double entry = A.values()[c.diagonal[index(permutation[k])]];
      if (!(root * root > tolerance * entry)) return false;
    }
  }
  return true;
}

void CholmodCholesky::solve(double* x) {
  Cholmod& c = *cholmod_;
  const SingleThreadedBlas guard;
  const std::size_t order = index(c.pattern.order());
  cholmod_dense b = {};
  b.nrow = b.nzmax = b.d = order;
  b.ncol = 1;
  b.x = x;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_l_solve2(CHOLMOD_A, c.L, &b, nullptr, &c.solution, nullptr, &c.y, &c.e,
                   &c.session.common);
  c.check_memory();
  std::copy_n(static_cast<const double*>(c.solution->x), order, x);
}

}  // namespace raybundle::linalg
