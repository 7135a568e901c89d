#pragma once

#include <raybundle/linalg/block_layout.h>

#include <cholmod.h>

#include <cstdint>
#include <vector>

namespace raybundle::linalg {

/// CHOLMOD as we use it: 64-bit indices, supernodal, silent.
class CholmodSession {
 public:
  CholmodSession() {
    cholmod_l_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.useGPU = 0;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.nmethods = 1;
    common.postorder = 1;
    common.quick_return_if_not_posdef = 1;
  }
  ~CholmodSession() { cholmod_l_finish(&common); }
  CholmodSession(const CholmodSession&) = delete;
  CholmodSession& operator=(const CholmodSession&) = delete;

  cholmod_common common;
};

/// A view of a lower triangle in compressed columns, pattern only when `values` is null; CHOLMOD
/// does not write to it.
inline cholmod_sparse lower_triangle(std::int64_t order, std::vector<std::int64_t>& begin,
                                     std::vector<std::int64_t>& row, double* values) {
  static_assert(sizeof(SuiteSparse_long) == sizeof(std::int64_t));
  cholmod_sparse A = {};
  A.nrow = A.ncol = index(order);
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

}  // namespace raybundle::linalg
