#pragma once

#include <cstdint>

namespace raybundle::linalg {

/// A Cholesky pivot at or below this share of its diagonal entry may be nothing but rounding that
/// the pivots before it have magnified: the eigenvalues decide then. Relative to the entry, so that
/// the units of the unknowns do not matter.
constexpr double pivot_tolerance = 1e-10;

/// Eigenvalues at or below this share of the largest, times the order, count as zero in a block
/// whose diagonal is scaled to one.
constexpr double null_tolerance = 1e-14;

/// M with M M^T = A^-1 for a symmetric block of order `size` (at most 12, row-major): the inverse
/// transpose of its Cholesky factor, or pseudo_inverse_factor() where Cholesky fails.
void inverse_factor(const double* A, int size, double* M);

/// For a positive semi-definite block that Cholesky refuses: M with M M^T the pseudo-inverse of A
/// after scaling its diagonal to one. Directions without information get no step (of
/// anchored leaves: but what their anchors give them). A block that is
/// not finite gives M = 0.
void pseudo_inverse_factor(const double* A, int size, double* M);

}  // namespace raybundle::linalg
