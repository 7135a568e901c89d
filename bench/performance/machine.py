"""What the machine itself gains and reaches, from a file of JSON with any of these members:

dgemm_gain, triad_gain          what two copies at once do over one: 1 is nothing gained, 2 all
implicit_product_of_triad       bandwidth of the implicit product over that of STREAM triad
evaluation_of_peak              flops of the evaluation over the peak
"""

PHASES = ("residual", "jacobian", "linear")


def bound(phase, linear_solver):
    """What limits a phase. Jacobian blocks, 24 numbers of an observation, are written and read; residuals
    are computed from states that fit the caches; a factorisation computes; iterations, and the set-up, read."""
    if phase == "linear":
        return "dgemm_gain" if "cholesky" in linear_solver.lower() else "triad_gain"
    return "dgemm_gain" if phase == "residual" else "triad_gain"


def gain(rates, phase, linear_solver):
    return (rates or {}).get(bound(phase, linear_solver))
