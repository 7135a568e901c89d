#include <raybundle/solver/methods.h>

#include <raybundle/solver/option_table.h>

#include <array>

namespace raybundle {
namespace {

constexpr std::array table = {
    MethodTraits{.method = Method::automatic,
                 .name = "auto",
                 .help = "damped steps by factorisation or conjugate gradients, the lesser work",
                 .inner = InnerSolve::automatic,
                 .preconditioner = Preconditioner::adaptive,
                 .damping_matrix = DiagonalMatrix::held_h},
    // [Qu18, 3.2] "LMA-CD"
    MethodTraits{.method = Method::lm_cholesky,
                 .name = "lm-cholesky",
                 .help = "damped steps by Cholesky factorisation",
                 .inner = InnerSolve::cholesky,
                 .damping_matrix = DiagonalMatrix::diag_h},
    // [Qu18, Alg. 7, 8]; with preconditioner b it is the thesis' "BAL" [Agarwal10]
    MethodTraits{.method = Method::tnm,
                 .name = "tnm",
                 .help = "truncated Newton: damped steps by conjugate gradients",
                 .inner = InnerSolve::pcg,
                 .preconditioner = Preconditioner::adaptive,
                 .damping_matrix = DiagonalMatrix::diag_h},
    // [Qu18, Alg. 3, 4, 5]
    MethodTraits{.method = Method::inm,
                 .name = "inm",
                 .help = "inexact Newton: conjugate gradients within a trust region",
                 .inner = InnerSolve::pcg,
                 .damped = false,
                 .bounded = true,
                 .preconditioner = Preconditioner::block_diag_s,
                 .scaling = DiagonalMatrix::inc},
    // [Qu18, Alg. 9]
    MethodTraits{.method = Method::dinm,
                 .name = "dinm",
                 .help = "damped inexact Newton: damping and trust region",
                 .inner = InnerSolve::pcg,
                 .bounded = true,
                 .preconditioner = Preconditioner::block_diag_s,
                 .scaling = DiagonalMatrix::inc},
    // [Qu18, Alg. 10]
    MethodTraits{.method = Method::adinm,
                 .name = "adinm",
                 .help = "adaptive dinm: eliminates the better conditioned side",
                 .inner = InnerSolve::pcg,
                 .bounded = true,
                 .adaptive = true,
                 .preconditioner = Preconditioner::block_diag_s,
                 .scaling = DiagonalMatrix::inc},
    // [Liu18, Table 1]
    MethodTraits{.method = Method::dogleg,
                 .name = "dogleg",
                 .help = "Gauss-Newton steps, bent to the steepest descent by a trust region",
                 .inner = InnerSolve::dogleg,
                 .damped = false,
                 .bounded = true,
                 .gauge = Gauge::fixed,
                 .point_steps = PointSteps::better,
                 .radius = {.shrink = 0.5, .grow = 3}},
    // [Qu18, Alg. 11]
    MethodTraits{.method = Method::irls,
                 .name = "irls",
                 .help = "dinm on a robust loss",
                 .inner = InnerSolve::pcg,
                 .bounded = true,
                 .preconditioner = Preconditioner::block_diag_s,
                 .scaling = DiagonalMatrix::inc,
                 .loss = Loss::tukey,
                 .graduated = true},
};
static_assert(table.size() == enum_count<Method>);

}  // namespace

const MethodTraits& traits(Method method) { return table[static_cast<std::size_t>(method)]; }

}  // namespace raybundle
