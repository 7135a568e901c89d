"""The floors that were set for speed and memory, decided from the runs."""

import math
import statistics

from reproduce.claims import FAILS, HOLDS, MISSING, Claim, number

from . import machine
from .logs import SCALING_FROM, TARGETS
from .problems import LARGEST
from .variants import AUTO

MEAN, SINGLE = 5, 1.5  # times faster than Ceres
COST = 1e-4  # above Ceres' final cost, relative
MEMORY, MEMORY_FROM = 0.5, 100_000  # of Ceres' peak; observations
SCALING = 0.85  # of what the machine gains
FORCED, NATIVE = 1.25, 1.1
EXPONENT = 1.1
LARGEST_COUNT, LARGEST_BYTES = 10_000_000, 16 * 2**30
PRODUCT, EVALUATION = 0.6, 0.4


def verdict(good):
    return HOLDS if good else FAILS


def worst(values, bad, good, shown=number):
    """`values`: {what: figure}, of which `good` says whether it will do and `bad` how bad it is."""
    if not values:
        return MISSING, ""
    failing = [what for what, value in values.items() if not good(value)]
    last = max(values, key=lambda what: bad(values[what]))
    text = f"worst: {last}, {shown(values[last])}"
    if failing:
        text = f"not on {len(failing)} of {len(values)}: " + ", ".join(
            f"{what} {shown(values[what])}" for what in failing)
    return verdict(not failing), text


def speed_ups(results, threads, factor):
    found = {name: results.speed_up(name, threads, factor) for name in results.names}
    return {name: value[0] for name, value in found.items() if value}


def speed(value):
    return number(value) if value else "never there"


def geometric_mean(values):
    values = list(values)
    if not values or min(values) <= 0:
        return 0.0
    return math.exp(statistics.fmean(math.log(value) for value in values))


def mean_speed(results):
    values = {f"{threads} thread{'s' * (threads > 1)} to {factor}": geometric_mean(found.values())
              for threads in results.threads for factor in TARGETS
              if (found := speed_ups(results, threads, factor))}
    return worst(values, lambda x: -x, lambda x: x >= MEAN, speed)


def single_speed(results):
    values = {f"{name}, {threads} thread{'s' * (threads > 1)} to {factor}": value
              for threads in results.threads for factor in TARGETS
              for name, value in speed_ups(results, threads, factor).items()}
    return worst(values, lambda x: -x, lambda x: x >= SINGLE, speed)


def final_cost(results):
    values = {name: results.final_difference(name) for name in results.names}
    values = {name: value for name, value in values.items() if value is not None}
    return worst(values, lambda x: x, lambda x: x <= COST, lambda x: f"{x:+.1e}")


def observations(results, name):
    return results.counts(name)["observations"]


def memory(which):
    def check(results):
        values = {}
        for name in results.names:
            for threads in results.threads:
                found = results.memory(name, threads)
                if found and observations(results, name) > MEMORY_FROM:
                    values[f"{name}, {threads} thread{'s' * (threads > 1)}"] = found[0] / found[which]
        return worst(values, lambda x: x, lambda x: x <= MEMORY)
    return check


def scaling(whole_gain):
    """Against `whole_gain(results, name, phase)`."""
    def check(results):
        values = {}
        for name in results.names:
            for phase in machine.PHASES if observations(results, name) > SCALING_FROM else []:
                ours, whole = results.phase_gain(name, phase), whole_gain(results, name, phase)
                if ours and whole:
                    values[f"{name}, {phase}"] = ours / whole
        return worst(values, lambda x: -x, lambda x: x >= SCALING)
    return check


def of_machine(results, name, phase):
    return machine.gain(results.rates, phase, results.linear_solver(name))


def of_twins(results, name, phase):
    return results.twin_gain(name, phase)


def forced(results):
    values = {}
    for name in results.names:
        for threads in results.threads:
            for factor in TARGETS:
                found = results.forced(name, threads, factor)
                if found and math.isfinite(found[1]):
                    ratio = results.over(name, threads, found[0], factor)
                    values[f"{name}, {threads} thread{'s' * (threads > 1)} to {factor}"] = ratio
    return worst(values, lambda x: x, lambda x: x <= FORCED)


def native(results):
    values = {f"{name}, {threads} thread{'s' * (threads > 1)}": results.native(name, threads, TARGETS[-1])
              for name in results.names for threads in results.threads}
    values = {name: value for name, value in values.items() if value}
    return worst(values, lambda x: x, lambda x: x <= NATIVE)


def slope(points):
    """Least squares through logarithms, of the first two numbers of each point."""
    logs = [(math.log(x), math.log(y)) for x, y, *_ in points]
    mean_x, mean_y = (statistics.fmean(each[k] for each in logs) for k in (0, 1))
    return (sum((x - mean_x) * (y - mean_y) for x, y in logs)
            / sum((x - mean_x) ** 2 for x, _ in logs))


def local_exponents(points):
    """{observations: exponent from the size before}, where both have the same linear solver: what one
    gains over another would hide how either grows."""
    kinds = [solver.split(" of order ")[0] for _, _, solver in points]
    return {points[k][0]: slope(points[k - 1:k + 1]) for k in range(1, len(points)) if kinds[k - 1] == kinds[k]}


def growth(results):
    points = results.growth()
    if len(points) < 2:
        return MISSING, ""
    exponent, local = slope(points), local_exponents(points)
    text = f"exponent {exponent:.3f} from {points[0][0]:,} to {points[-1][0]:,} observations"
    if local:
        steepest = max(local, key=local.get)
        text += f", at most {local[steepest]:.3f} between neighbours solved alike, there up to {steepest:,}"
    return verdict(exponent <= EXPONENT), text


def largest(results):
    run = results.run(LARGEST.name, "final", AUTO)
    if not run:
        return MISSING, ""
    count, ending = run.log["problem"]["observations"], run.summary["termination"]
    text = (f"{count:,} observations, ended by {ending.replace('_', ' ')} after {run.iterations} iterations, "
            f"{run.peak / 2**30:.2f} GiB")
    if count < LARGEST_COUNT:
        return MISSING, text
    return verdict(ending.endswith("tolerance") and run.peak <= LARGEST_BYTES), text


def kernel(name, floors):
    """Good when one of the floors is reached: {counter: floor}."""
    def check(results):
        found = results.rates.get(name)
        if not found:
            return MISSING, ""
        text = ", ".join(f"{100 * found[counter]:.0f} % {what}" for counter, what in
                         (("of_triad", "of triad's bandwidth"), ("of_peak", "of the peak flops")) if counter in found)
        return verdict(any(found.get(counter, 0) >= floor for counter, floor in floors.items())), text
    return check


CLAIMS = [
    Claim(f"Geometric mean of the speed-ups over Ceres' best variants at least {MEAN}", mean_speed),
    Claim(f"At least {SINGLE} times faster on every problem", single_speed),
    Claim(f"Final cost never above Ceres' by more than {COST:g}, relative", final_cost),
    Claim(f"Peak memory at most half of that of Ceres' best variant above {MEMORY_FROM:,} observations", memory(1)),
    Claim("The same against whichever variant of Ceres takes least", memory(2)),
    Claim(f"Two threads over one, above {SCALING_FROM:,} observations: in every phase at least "
          f"{100 * SCALING:.0f} % of what the machine gains in dgemm or STREAM", scaling(of_machine)),
    Claim("The same of what it gains for two solves at once, one thread each", scaling(of_twins)),
    Claim(f"The product with the implicit Schur complement at {100 * PRODUCT:.0f} % of the bandwidth of triad",
          kernel("product", {"of_triad": PRODUCT})),
    Claim(f"Evaluation at {100 * EVALUATION:.0f} % of the peak flops, or, limited by memory, at "
          f"{100 * PRODUCT:.0f} % of the bandwidth", kernel("evaluation", {"of_peak": EVALUATION, "of_triad": PRODUCT})),
    Claim(f"Time of an outer iteration on streets grows with exponent at most {EXPONENT}", growth),
    Claim(f"{LARGEST_COUNT:,} observations solved within {LARGEST_BYTES >> 30} GiB", largest),
    Claim("The portable build within 10 % of -march=native", native),
    Claim(f"The default within {FORCED} of the best forced choice", forced),
]
