#pragma once

#include <string>

namespace raybundle::linalg {

/// Holds the BLAS that is loaded to one thread for as long as this lives: our own threads are the
/// parallel level, and a sum split over BLAS threads would depend on their number. Knows OpenBLAS;
/// any other BLAS is left as it is.
class SingleThreadedBlas {
 public:
  SingleThreadedBlas();
  ~SingleThreadedBlas();
  SingleThreadedBlas(const SingleThreadedBlas&) = delete;
  SingleThreadedBlas& operator=(const SingleThreadedBlas&) = delete;
};

/// The BLAS that is loaded, as far as it can be told: "OpenBLAS with kernels for Haswell".
std::string blas_name();

}  // namespace raybundle::linalg
