"""What the machine itself gains and reaches, as bench_micro measures it: JSON of Google Benchmark whose context has
triad_N (GB/s) and peak_N (GFlop/s) with N threads, and whose benchmarks, named KERNEL/observations:N/threads:N,
have the counters of_triad and of_peak.
"""

import re
import statistics
import subprocess

from reproduce.logs import load

PHASES = ("residual", "jacobian", "linear")
PRODUCT, EVALUATION = "implicit Schur product", "linearisation"


def measure(program, file):
    """Some minutes. What an earlier run left of the same program is as good."""
    if file.is_file() and file.stat().st_mtime > program.stat().st_mtime:
        return
    subprocess.run([str(program), f"--benchmark_out={file}", "--benchmark_out_format=json",
                    "--benchmark_repetitions=3"], check=True, stdout=subprocess.DEVNULL)


def rates(file):
    """{"triad", "peak": gain of two threads over one; "product", "evaluation": {counter: share}}, of what
    the file has."""
    data = load(file) or {}
    context, found = data.get("context", {}), {}
    for kind in ("triad", "peak"):
        one, two = (float(context.get(f"{kind}_{threads}", 0)) for threads in (1, 2))
        if one and two:
            found[kind] = two / one
    for name, kernel in (("product", PRODUCT), ("evaluation", EVALUATION)):
        shares = {counter: share(data, kernel, counter) for counter in ("of_triad", "of_peak")}
        found[name] = {counter: value for counter, value in shares.items() if value is not None}
    return found


def share(data, kernel, counter):
    """Median over the repetitions, the least of all sizes and numbers of threads."""
    runs = {}
    for run in data.get("benchmarks", []):
        named = re.match(rf"{kernel}/(observations:\d+/threads:\d+)", run["name"])
        if named and run.get("run_type", "iteration") == "iteration" and counter in run:
            runs.setdefault(named[1], []).append(run[counter])
    return min((statistics.median(each) for each in runs.values()), default=None)


def bound(phase, linear_solver):
    """What limits a phase. Jacobian blocks, 24 numbers of an observation, are written; residuals
    are computed from states that fit the caches; a factorisation computes; iterations, and the set-up, read."""
    if phase == "linear":
        return "triad" if linear_solver.startswith("conjugate") else "peak"
    return "peak" if phase == "residual" else "triad"


def gain(known, phase, linear_solver):
    return known.get(bound(phase, linear_solver))
