#include <raybundle/solver/methods.h>

#include <raybundle/solver/option_table.h>

#include <array>

namespace raybundle {
namespace {

constexpr std::array table = {
    // [Qu18, 3.2] "LMA-CD"
    MethodTraits{Method::lm_cholesky, "lm-cholesky", "damped steps by Cholesky factorisation",
                 InnerSolve::cholesky, Elimination::points, Preconditioner::identity,
                 DiagonalMatrix::diag_h, DiagonalMatrix::identity, 0, 0},
    // [Qu18, Alg. 7, 8]; with preconditioner b it is the thesis' "BAL" [Agarwal10]
    MethodTraits{Method::tnm, "tnm", "truncated Newton: damped steps by conjugate gradients",
                 InnerSolve::pcg, Elimination::points, Preconditioner::block_diag_s,
                 DiagonalMatrix::diag_h, DiagonalMatrix::identity, 0.1, 1000},
};
static_assert(table.size() == enum_count<Method>);

}  // namespace

const MethodTraits& traits(Method method) { return table[static_cast<std::size_t>(method)]; }

}  // namespace raybundle
