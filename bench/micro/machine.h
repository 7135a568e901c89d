#pragma once

namespace raybundle::bench {

/// What the machine itself can do with some threads, measured when first asked for.
struct Machine {
  double triad;  ///< GB/s of a = b + s c on arrays far beyond the caches, counted as STREAM does
  double peak;   ///< GFlop/s of multiplications and additions of doubles
};

const Machine& machine(int threads);

}  // namespace raybundle::bench
