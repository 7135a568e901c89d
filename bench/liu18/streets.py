"""Many small street scenes with far and collinear points: how often each method finds the least cost."""

import itertools
import statistics

from reproduce.claims import number
from reproduce.text import table

from .logs import half_chi2
from .variants import COMMON, OWN, POINTS, SOLVERS

SCENE = ("street --cameras 20 --points 300 --far 0.35 --collinear 0.2 --true-lenses "
         "--start-rotation 0.005 --start-position 0.01")
TRIALS = 200
NEAR = 1.001  # of the least cost
FAR = 100  # steps


def runs():
    """{name: options}"""
    models = {**POINTS, "PMBA-pixels": "--points pmba"}
    common = [word for key, value in COMMON.items() for word in ("--" + key, value)]
    methods = {f"{points}-{solver}": f"{models[points]} {SOLVERS[solver]}"
               for points, solver in itertools.product(models, SOLVERS)} | OWN
    return {name: [*options.split(), *common, "--max-iterations", str(TRIALS)]
            for name, options in methods.items()}


def recipe():
    """What the results depend on beside the program."""
    return {"scene": SCENE, **{name: " ".join(options) for name, options in runs().items()}}


def outcome(log):
    kept = [each for each in log["iterations"] if each["accepted"]]
    return {"cost": half_chi2(kept[-1]), "accepted": len(kept) - 1,
            "solves": log["summary"]["linear_solves"], "termination": log["summary"]["termination"]}


def kinds(truth):
    """How many points a truth has, and how many are far from all of its cameras."""
    with open(truth, encoding="utf-8") as file:
        cameras, points, observations = map(int, file.readline().split())
        numbers = [float(line) for line in itertools.islice(file, observations, None)]
    positions = numbers[9 * cameras:]
    # The street starts at the origin and is as long as it has cameras.
    far = sum(sum(x * x for x in positions[3 * i:3 * i + 3]) > (cameras + FAR) ** 2 for i in range(points))
    return {"points": points, "far": far}


def report(results):
    scenes = [each for each in results.streets() if each["stamp"]["recipe"] == recipe()]
    if not scenes:
        return "Not run.\n"
    far = sum(each["kinds"]["far"] for each in scenes) / sum(each["kinds"]["points"] for each in scenes)
    least = [min(run["cost"] for run in each["runs"].values() if run["cost"] is not None) for each in scenes]
    rows = []
    for name in runs():
        own = [each["runs"][name] for each in scenes]
        ratios = [run["cost"] / low if run["cost"] is not None else float("inf")
                  for run, low in zip(own, least)]
        rows.append([name, *(share(sum(ratio <= bound for ratio in ratios), len(scenes))
                             for bound in (NEAR, 1.01)), f"{statistics.median(ratios):.5f}",
                     number(max(ratios)), number(statistics.median(run["solves"] for run in own)),
                     endings(own)])
    return (f"{len(scenes)} scenes `raybundle generate {SCENE} --seed N`: {100 * far:.0f} % of the points are "
            f"more than {FAR} steps ahead, 20 % on the line of motion. Up to {TRIALS} iterations. Shares of the scenes "
            f"in which a method ends within {NEAR} and 1.01 of the least pixel cost that any found. PMBA "
            "minimises rays, weighted alike as in the paper: its own minimum lies a little beside that of "
            "the pixels, which the median ratio shows; PMBA-pixels minimises what is judged.\n\n"
            + table(["", f"within {NEAR}", "within 1.01", "median cost / least", "worst", "median solves",
                     "endings"], rows))


def share(count, of):
    return f"{100 * count / of:.1f} %"


def endings(own):
    counts = {}
    for run in own:
        counts[run["termination"]] = counts.get(run["termination"], 0) + 1
    return ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in
                     sorted(counts.items(), key=lambda item: -item[1]))
