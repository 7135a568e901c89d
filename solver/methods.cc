#include <raybundle/solver/methods.h>

#include <array>

namespace raybundle {
namespace {

constexpr std::array table = {
    // [Qu18, 3.2] "LMA-CD"
    MethodTraits{Method::lm_cholesky, "lm-cholesky", "damped steps by Cholesky factorisation",
                 InnerSolve::cholesky, Elimination::points, Preconditioner::identity,
                 DiagonalMatrix::diag_h, DiagonalMatrix::identity},
    // [Qu18, Alg. 7, 8]; with preconditioner b it is the thesis' "BAL" [Agarwal10]
    MethodTraits{Method::tnm, "tnm", "truncated Newton: damped steps by conjugate gradients",
                 InnerSolve::pcg, Elimination::points, Preconditioner::block_diag_s,
                 DiagonalMatrix::diag_h, DiagonalMatrix::identity},
};

}  // namespace

const MethodTraits& traits(Method method) { return table[static_cast<std::size_t>(method)]; }

}  // namespace raybundle
