"""The report: docs/results/performance.md with its plots."""

import math

from reproduce.claims import FAILS, HOLDS, MISSING, count, judged, number
from reproduce.text import capital, claim_lines, image, table, write_page

from . import plots, scaling
from .claims import (CLAIMS, LARGEST_COUNT, geometric_mean, largest, local_exponents, observations, slope,
                     speed_ups)
from .logs import TARGETS
from .problems import CALIBRATE, FAR, TITLES
from .scaling import choice, ratio, short
from .variants import AUTO, CERES, DENSE_MOST, FORCED, LOSES, SLOW
from .work import MORE_ROUNDS, SMALL

def threads_text(threads):
    return f"{threads} thread{'s' * (threads > 1)}"


def times(value, reached=True):
    return "ours never" if not value else f"{'' if reached else '> '}{number(value)}"


def rival_row(results, name, threads):
    theirs = results.ceres(name, threads, TARGETS[-1])
    ups = [results.speed_up(name, threads, factor) for factor in TARGETS]
    bound = TARGETS[-1] * results.best(name)
    runs = [results.timed(name, threads, variant) for variant in (theirs[0], AUTO)]
    counts = [number(each[0].iterations_to(bound)) if each else "" for each in runs]
    difference, memory = results.final_difference(name), results.memory(name, threads)
    return [TITLES[name], f"{observations(results, name):,}", theirs[0], *(times(*up) if up else "" for up in ups),
            ", ".join(counts), "" if difference is None else f"{difference:+.1e}",
            *(ratio(memory[0] / other) if memory else "" for other in (memory or [0, 0, 0])[1:])]


def beside_ceres(results, threads):
    names = [name for name in results.names if results.ceres(name, threads, TARGETS[-1])]
    if not names:
        return "Ceres was not run.\n"
    rows = [rival_row(results, name, threads) for name in names]
    found = [speed_ups(results, threads, factor).values() for factor in TARGETS]
    rows.append(["**geometric mean**", "", "", *(f"**{number(geometric_mean(each))}**" for each in found),
                 "", "", "", ""])
    rows.append(["**least**", "", "", *(f"**{number(min(each))}**" if each else "" for each in found),
                 "", "", "", ""])
    return table(["problem", "observations", "Ceres' best variant", "faster, to 1.01", "to 1.001",
                  "iterations, theirs and ours", "final cost, ours to theirs", "memory, over the best's",
                  "over the leanest's"], rows)


def forced_choices(results, threads):
    rows = []
    for name in results.names:
        row = [TITLES[name], choice(results, name)]
        for factor in TARGETS:
            best = results.forced(name, threads, factor)
            row += [best[0], ratio(results.over(name, threads, best[0], factor))] if best else ["", ""]
        rows.append(row)
    return table(["problem", "the default chose", "best forced, to 1.01", "default over it",
                  "best forced, to 1.001", "default over it"], rows)


def growth(results):
    points = results.growth()
    if len(points) < 2:
        return "Not run.\n"
    first, local = points[0], local_exponents(points)
    rows = [[f"{x:,}", short(solver), number(y / first[1]), number((y / x) / (first[1] / first[0])), ratio(local.get(x))]
            for x, y, solver in points]
    return (table(["observations", "linear solver", "time of an iteration", "the same per observation",
                   "exponent from the size before, where solved alike"], rows)
            + f"\nFitted exponent: {slope(points):.3f}.\n")


def screening(results, threads):
    """What every variant of Ceres takes to the second target, over the best of them."""
    rows = []
    for name in results.names:
        runs, bound = results.screened(name, threads, CERES), TARGETS[-1] * results.best(name)
        taken = {variant: run.seconds_to(bound) for variant, run in runs.items()}
        if taken:
            low = min(taken.values())
            rows.append([TITLES[name], *(screened(taken.get(variant), low, results, name, threads, variant)
                                         for variant in CERES)])
    return table(["problem", *CERES], rows) if rows else "Not run.\n"


def screened(seconds, low, results, name, threads, variant):
    if seconds is None:
        status = results.run(name, f"screen-{threads}", variant).outcome.get("status")
        return status or "left out"
    if math.isinf(seconds):
        return "given up"
    return number(seconds / low)


def far(results, threads):
    rows = []
    for problem in FAR:
        runs = results.screened(problem.name, threads, [AUTO, *FORCED, *CERES])
        least = min((run.least for run in runs.values()), default=None)
        if runs:
            rows.append([problem.title, *(number(runs[name].least / least, 5) if name in runs else ""
                                          for name in (AUTO, *FORCED, *CERES))])
    return table(["problem", "raybundle", *FORCED, *(f"Ceres {name}" for name in CERES)], rows) if rows \
        else "Not run.\n"


def heading(results, settings, meta, counts):
    limits = settings.limit
    loads = ", ".join(f"{name} {a:.1f} and {b:.1f}" for name, (a, b) in meta["load"].items())
    scale = "" if settings.scale == 1 else f" All generated scenes are {settings.scale:g} times that size."
    several = len(results.builds()) > 1
    return f"""# Speed and memory

Beside Ceres, against ourselves when told how to solve, from one thread to two, and from small to large.
`tools/reproduce performance` runs it all and writes this page; `--report-only` writes it again from the runs that
are there.

Of {sum(counts.values())} floors {counts[HOLDS]} hold, {counts[FAILS]} fail, {counts[MISSING]} were not measured in this run.

- Time counts from the call of the solver, its set-up included, to the first iteration whose cost is at most 1.01
  or 1.001 times the best that any run here found; reading, and building Ceres' problem, come before. Figures are
  ratios of medians of {settings.runs} runs ({MORE_ROUNDS * settings.runs} below {SMALL:,} observations), round by round: every variant once in each, in any order, after as much memory as it takes was touched and freed.
- Every solver reads the same BAL file: same start, no loss, nine free parameters per camera, nothing held.
  Cost is ½ Σ |r|² in pixels².
- Ceres {ceres_version(results)}: automatic derivatives compiled for this processor, points eliminated first, its default trust region,
  {blas(results)}. Variants: dense with Eigen and with LAPACK
  (up to {DENSE_MOST} cameras: beyond, the matrix takes gigabytes), sparse, and iterative with block-Jacobi (implicit and
  explicit) and both cluster preconditioners. Each ran once for at most {limits:g} s, less where another had been faster by
  {100 * (LOSES - 1):.0f} % or ours {SLOW} times; the best for each target went into the rounds. "> 3" means that no variant got there in that time.
- raybundle without any option but tolerances as tight as Ceres' and a bound on iterations that ends it at the second target.
- Final costs: both with their own tolerances (1e-6 of the cost, 50 iterations, {2 * limits:g} s); below 0, ours is lower.
- Memory: the peak of the process; of ours the largest of all its runs, of Ceres the smallest.
- Malaga and Fake-pile come as folders of ParallaxBA, with a known lens and without points. Their start is their
  solution with that lens (`raybundle solve FOLDER {CALIBRATE}`),
  from which the lenses are let go. BAL's pixels are square, so that y is divided by f_y / f_x (0.9986 and 0.9992).
- Generated scenes have the counts and the look of their namesakes of BAL, seed 1; of final-4585 a quarter of the
  counts, since of all of it the iterative solver of Ceres took ten minutes for an attempt that was to end after two.{scale}
- Machine: {meta["machine"]}. Load (1 is one core) before and after the runs on each problem: {loads or "unknown"}.
{"- The runs are of several builds of raybundle." if several else ""}
"""


def ceres_version(results):
    run = next((run for name in results.names for run in results.screened(name, results.threads[-1], CERES).values()),
               None)
    return run.log["version"] if run else "(not run)"


def blas(results):
    run = next((run for name in results.names for run in results.screened(name, results.threads[-1], CERES).values()),
               None)
    core = run.log["blas"].get("openblas_core") if run else None
    return f"OpenBLAS held to one thread, with the kernels {core}" if core else "BLAS as it comes"


def sections(results):
    most = results.threads[-1]
    for threads in results.threads:
        yield f"Beside Ceres, {threads_text(threads)}", beside_ceres(results, threads) + "\n", \
            [plots.speed_ups(results, threads)]
    yield "What each variant of Ceres takes", (
        f"To 1.001 of the best cost, over the best variant, {threads_text(most)}, one run each.\n\n"
        + screening(results, most) + "\n"), []
    for threads in results.threads:
        yield f"The default beside forced choices, {threads_text(threads)}", (
            f"Forced: {', '.join(f'`{options}`' for options in FORCED.values())}. Left out are those that take more than "
            "twice as long as the default, and a second.\n\n" + forced_choices(results, threads) + "\n"), []
    yield "From one thread to two", scaling.text(results), []
    yield "Far starts", (
        "Malaga and Fake-pile as `raybundle convert` makes BAL files of them: points on the two rays of best parallax, "
        "cameras hundreds of pixels off, all lenses free. Everybody ends in a minimum of their own or on the way to one, so "
        "that times to a common cost mean nothing, and the floors leave them out: the least cost found within 200 "
        "iterations, over the least of all. Points by parallax do not have this trouble ([liu18.md](liu18.md)).\n\n"
        + far(results, most) + "\n"), []
    yield "Growth", ("Streets of growing length at the same density; time of an outer iteration, set-up left out, over that "
                     "of the shortest.\n\n" + growth(results) + "\n"), [plots.growth(results)]
    yield f"{LARGEST_COUNT:,} observations", capital(largest(results)[1] or "not run") + ".\n\n", []
    yield "Cost over time", ("Time is that of raybundle's default to 1.001 of the best cost.\n\n"), \
        [plots.course(results, name, TITLES[name], most) for name in results.names]


def write(results, settings, meta, work, docs):
    rows = judged(CLAIMS, results)
    text = heading(results, settings, meta, count(rows)) + "## Floors\n\n" + claim_lines(rows) + "\n"
    drawn = []
    for title, body, own in sections(results):
        text += f"## {title}\n\n{body}"
        for plot in filter(None, own):
            drawn.append(plot)
            text += image("performance", plot["name"], plot["title"])
    return write_page("performance", text.rstrip() + "\n", drawn, work, docs)
