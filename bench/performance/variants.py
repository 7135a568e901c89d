"""The solvers: ours, forced to one way or not, and Ceres in every way that it has."""

import pathlib

# All of Ceres' ways that suit bundle adjustment; the driver's other options are its defaults: points
# eliminated first, and tolerances so tight that nothing but the stop cost and the limits ends it.
CERES = {
    "dense-eigen": "--linear-solver dense_schur --dense-library eigen",
    "dense-lapack": "--linear-solver dense_schur --dense-library lapack",
    "sparse": "--linear-solver sparse_schur",
    "iterative-explicit": "--linear-solver iterative_schur --preconditioner schur_jacobi --explicit 1",
    "iterative": "--linear-solver iterative_schur --preconditioner schur_jacobi",
    "cluster-tridiagonal": "--linear-solver iterative_schur --preconditioner cluster_tridiagonal",
    "cluster-jacobi": "--linear-solver iterative_schur --preconditioner cluster_jacobi",
}
DENSE_MOST = 1000  # cameras; beyond, a dense Schur complement of order 9 n is several GB
LOSES = 1.3  # one is given up that takes this many times the time of another
SLOW = 50  # ... or this many times the time of our default
# Ceres' own defaults, for where it ends when left alone.
CERES_DEFAULTS = "--function-tolerance 1e-6 --gradient-tolerance 1e-10 --parameter-tolerance 1e-8"

AUTO = "auto"  # our default: no option at all
# Methods that a user can force: by factorisation, by conjugate gradients, and by these within a trust
# region; each chooses the rest by itself. `auto` is to be within 1.25 of the best of them.
FORCED = {
    "lm-cholesky": "--method lm-cholesky",
    "tnm": "--method tnm",
    "dinm": "--method dinm",
}
NATIVE = "native"  # the default of a program built with -march=native
# As the Ceres driver: runs go on to the bound on iterations or time.
TIGHT = "--function-tolerance 1e-16 --gradient-tolerance 1e-16 --parameter-tolerance 1e-16"


def ceres_for(cameras):
    """Names of the variants that fit."""
    return [name for name in CERES if cameras <= DENSE_MOST or not name.startswith("dense")]


def blas_environment():
    """What OpenBLAS needs to be at its best: one thread beside Ceres' own, and the kernels of the
    processor, which Debian's version does not find by itself on recent ones."""
    flags = processor_value("flags").split()
    core = "SKYLAKEX" if "avx512f" in flags else "HASWELL" if "avx2" in flags else ""
    return {"OPENBLAS_NUM_THREADS": "1", **({"OPENBLAS_CORETYPE": core} if core else {})}


def processor_value(key):
    try:
        text = pathlib.Path("/proc/cpuinfo").read_text()
    except OSError:
        return ""
    lines = (line.split(":", 1) for line in text.splitlines() if line.startswith(key))
    return next((value.strip() for _, value in lines), "")
