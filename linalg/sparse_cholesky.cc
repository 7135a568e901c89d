#include <raybundle/linalg/sparse_cholesky.h>

#include <raybundle/linalg/blas_threads.h>

#include <cholmod.h>

#include <algorithm>
#include <new>
#include <type_traits>

namespace raybundle::linalg {
namespace {

using Integer = SuiteSparse_long;
static_assert(sizeof(Integer) == sizeof(std::int64_t));

// A view of a lower triangle in compressed columns; CHOLMOD does not write to it.
cholmod_sparse lower_triangle(std::int64_t order, std::vector<std::int64_t>& begin,
                              std::vector<std::int64_t>& row, double* values) {
  cholmod_sparse A = {};
  A.nrow = A.ncol = static_cast<std::size_t>(order);
  A.nzmax = row.size();
  A.p = begin.data();
  A.i = row.data();
  A.x = values;
  A.stype = -1;
  A.itype = CHOLMOD_LONG;
  A.xtype = values == nullptr ? CHOLMOD_PATTERN : CHOLMOD_REAL;
  A.dtype = CHOLMOD_DOUBLE;
  A.sorted = 1;
  A.packed = 1;
  return A;
}

}  // namespace

struct SparseCholesky::Cholmod {
  explicit Cholmod(const SymmetricPattern& block_pattern);
  ~Cholmod();

  void order_blocks();
  double predict(int method, std::vector<std::int64_t>& permutation);
  std::vector<std::int64_t> scalar_permutation() const;
  void fill_scalar_pattern();
  void check_memory() const {
    if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  }

  const SymmetricPattern& pattern;
  cholmod_common common;
  cholmod_factor* L = nullptr;
  cholmod_dense* y = nullptr;  // workspaces of solve()
  cholmod_dense* e = nullptr;
  cholmod_dense* solution = nullptr;
  std::vector<std::int64_t> begin;  // scalar columns
  std::vector<std::int64_t> row;
  std::vector<std::int64_t> block_permutation;
  std::string ordering;
  double block_flops = 0;
  double block_nonzeros = 0;
};

SparseCholesky::Cholmod::Cholmod(const SymmetricPattern& block_pattern) : pattern(block_pattern) {
  cholmod_l_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  common.useGPU = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.quick_return_if_not_posdef = 1;
  order_blocks();
}

SparseCholesky::Cholmod::~Cholmod() {
  cholmod_l_free_dense(&solution, &common);
  cholmod_l_free_dense(&y, &common);
  cholmod_l_free_dense(&e, &common);
  cholmod_l_free_factor(&L, &common);
  cholmod_l_finish(&common);
}

// Nonzeros of the block factor under one ordering; the permutation found is returned.
double SparseCholesky::Cholmod::predict(int method, std::vector<std::int64_t>& permutation) {
  std::vector<std::int64_t> block_row(pattern.column.begin(), pattern.column.end());
  std::vector<std::int64_t> block_begin = pattern.row_begin;
  cholmod_sparse A = lower_triangle(pattern.blocks(), block_begin, block_row, nullptr);
  common.nmethods = 1;
  common.method[0].ordering = method;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_factor* factor = cholmod_l_analyze(&A, &common);
  common.supernodal = CHOLMOD_SUPERNODAL;
  check_memory();
  if (factor == nullptr) return -1;
  const auto* order = static_cast<const Integer*>(factor->Perm);
  permutation.assign(order, order + pattern.blocks());
  cholmod_l_free_factor(&factor, &common);
  return common.lnz;
}

void SparseCholesky::Cholmod::order_blocks() {
  const double blocks = static_cast<double>(pattern.blocks());
  const double scale = static_cast<double>(pattern.order()) / blocks;
  ordering = "minimum degree";
  block_nonzeros = predict(CHOLMOD_AMD, block_permutation);
  block_flops = common.fl;
  std::vector<std::int64_t> other;
  const double dissection = predict(CHOLMOD_METIS, other);
  if (block_nonzeros < 0 || (dissection >= 0 && dissection < block_nonzeros)) {
    ordering = "nested dissection";
    block_nonzeros = dissection;
    block_flops = common.fl;
    block_permutation = std::move(other);
  }
  block_nonzeros *= scale * scale;
  block_flops *= scale * scale * scale;
}

std::vector<std::int64_t> SparseCholesky::Cholmod::scalar_permutation() const {
  std::vector<std::int64_t> scalar;
  scalar.reserve(index(pattern.order()));
  for (const std::int64_t a : block_permutation) {
    for (std::int64_t i = pattern.offset[index(a)]; i < pattern.offset[index(a + 1)]; ++i) {
      scalar.push_back(i);
    }
  }
  return scalar;
}

// A scalar row of a block row is a column of the lower triangle; the diagonal block is stored
// whole, and CHOLMOD ignores what lies above the diagonal.
void SparseCholesky::Cholmod::fill_scalar_pattern() {
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
      begin.push_back(static_cast<std::int64_t>(row.size()));
    }
  }
}

SparseCholesky::SparseCholesky(const SymmetricPattern& pattern)
    : cholmod_(std::make_unique<Cholmod>(pattern)) {}
SparseCholesky::~SparseCholesky() = default;

double SparseCholesky::predicted_flops() const { return cholmod_->block_flops; }
double SparseCholesky::predicted_nonzeros() const { return cholmod_->block_nonzeros; }
const std::string& SparseCholesky::ordering() const { return cholmod_->ordering; }

void SparseCholesky::analyze() {
  Cholmod& c = *cholmod_;
  c.fill_scalar_pattern();
  std::vector<std::int64_t> permutation = c.scalar_permutation();
  cholmod_sparse A = lower_triangle(c.pattern.order(), c.begin, c.row, nullptr);
  c.common.nmethods = 1;
  c.common.method[0].ordering = CHOLMOD_GIVEN;
  c.common.postorder = 1;
  c.L = cholmod_l_analyze_p(&A, reinterpret_cast<Integer*>(permutation.data()), nullptr, 0,
                            &c.common);
  if (c.L == nullptr) throw std::bad_alloc();
}

bool SparseCholesky::factor(const SymmetricBlocks& A) {
  Cholmod& c = *cholmod_;
  const SingleThreadedBlas guard;
  cholmod_sparse matrix =
      lower_triangle(c.pattern.order(), c.begin, c.row, const_cast<double*>(A.values()));
  const int done = cholmod_l_factorize(&matrix, c.L, &c.common);
  c.check_memory();
  return done != 0 && c.common.status == CHOLMOD_OK;
}

void SparseCholesky::solve(double* x) {
  Cholmod& c = *cholmod_;
  const SingleThreadedBlas guard;
  const std::size_t order = index(c.pattern.order());
  cholmod_dense b = {};
  b.nrow = b.nzmax = b.d = order;
  b.ncol = 1;
  b.x = x;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  cholmod_l_solve2(CHOLMOD_A, c.L, &b, nullptr, &c.solution, nullptr, &c.y, &c.e, &c.common);
  c.check_memory();
  std::copy_n(static_cast<const double*>(c.solution->x), order, x);
}

}  // namespace raybundle::linalg
