#pragma once

#include <string>

namespace raybundle::linalg {

/// Holds the BLAS that is loaded to one thread for as long as this lives: our own threads are the
/// parallel level, and a sum split over BLAS threads would depend on their number. The same for the
/// OpenMP loops of CHOLMOD, which take four threads whatever anybody asks for. Knows OpenBLAS;
/// any other BLAS is left as it is.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;

 private:
  int openmp_levels_ = 0;  // to restore; 0: nothing
};

/// The BLAS that is loaded, as far as it can be told: "OpenBLAS with kernels for Haswell".
std::string blas_name();

}  // namespace raybundle::linalg
