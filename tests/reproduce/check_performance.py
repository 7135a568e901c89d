#!/usr/bin/env python3
"""Checks tools/reproduce performance on tiny scenes: times are found from the best cost whenever it was found, runs
stand as long as they go far enough, floors judge as they should, and the page comes out the same a second time.

Usage: check_performance.py PROJECT PROGRAM PROBE
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import types


def require(good, what):
    if not good:
        sys.exit(f"check_performance: {what}")


def course(*pairs):
    """A log of (seconds, cost)."""
    trials = [{"iteration": k, "seconds": seconds, "cost": cost, "accepted": True}
              for k, (seconds, cost) in enumerate(pairs)]
    return {"iterations": trials, "problem": {"observations": 10},
            "summary": {"peak_rss_bytes": 1000, "linear_solver": "dense Cholesky", "seconds": {"total": 1}}}


def put(results, kind, variant, log, **outcome):
    base = results.base("bal-21", kind, variant)
    base.parent.mkdir(parents=True, exist_ok=True)
    base.with_suffix(".json").write_text(json.dumps(log))
    known = {"stamp": "s", "status": "ok", "seconds": 100, "iterations": 500, "stop": 0, **outcome}
    base.with_suffix(".run.json").write_text(json.dumps(known))
    return base


def check_times(folder):
    from performance.logs import Results
    results = Results(folder)
    ours, theirs = course((0, 900), (1, 100.5), (2, 100)), course((0, 900), (3, 100.9), (9, 100.02))
    put(results, "explore", "auto", ours)
    put(results, "screen-1", "sparse", theirs)
    put(results, "screen-1", "iterative", course((0, 900), (2, 100.9), (12, 100.02)))
    for number in (1, 2, 3):
        put(results, f"timed-1-{number}", "auto", course((0, 900), (number, 100.5), (2 * number, 100)))
        for name, first in (("sparse", 3), ("iterative", 2)):
            put(results, f"timed-1-{number}", name,
                course((0, 900), (first, 100.9), (9 if name == "sparse" else 12, 100.02)))
    require(results.chosen_ceres("bal-21", 1) == ["sparse", "iterative"], "the best variant for each target")
    require(results.speed_up("bal-21", 1, 1.01) == (1, True), "iterative is first at 1.01")
    require(results.speed_up("bal-21", 1, 1.001) == (9 / 4, True), "sparse is first at 1.001")
    # Somebody finds less: the same runs now get to less.
    put(results, "final", "ceres", course((0, 900), (30, 99.95)))
    require(results.best("bal-21") == 99.95, "the least of all")
    require(results.seconds("bal-21", 1, "auto", 1.001) == 4, "time to the new target")
    put(results, "final", "ceres", course((0, 900), (30, 95)))
    value, reached = results.speed_up("bal-21", 1, 1.01)
    require(value == 0 and not reached, "nobody gets there in the rounds")


def check_standing(folder):
    from performance.execute import Bounds, stands
    from performance.logs import Results

    class Solver:
        def stamp(self, threads):
            return "s"

    results, log = Results(folder), course((0, 900), (50, 101), (60, 100.05))

    def good(bounds, **outcome):
        return stands(Solver(), put(results, "screen-2", "sparse", log, **outcome), 1, bounds)

    require(good(Bounds(100, 500, 100.1, 100.08), stop=100.08), "it reached the target")
    require(not good(Bounds(100, 500, 100, 99.9), stop=100.08), "it was stopped above the new target")
    require(good(Bounds(100, 500, 100, 99.9)), "it ended by itself")
    require(not good(Bounds(100, 500, 100), seconds=60), "it could have had more time")
    require(good(Bounds(50, 500, 100), seconds=60), "it had more time than others get now")
    require(not good(Bounds(100, 500, 100), iterations=2), "it could have gone on")
    require(not good(Bounds(100, 500, 100), stamp="another"), "it was another program")
    require(good(Bounds(100, 500, 1), status="failed"), "a failure is an outcome")
    require(not stands(Solver(), results.base("bal-21", "screen-2", "none"), 1, Bounds(1, 1)), "no run")


def check_judgement():
    from performance import claims
    from reproduce.claims import FAILS, HOLDS, MISSING
    require(abs(claims.slope([(x, 3 * x**1.2) for x in (1, 10, 40)]) - 1.2) < 1e-12, "slope")
    require(abs(claims.geometric_mean([2, 8]) - 4) < 1e-12 and claims.geometric_mean([0, 8]) == 0, "mean")
    above = claims.worst({"a": 2, "b": 1}, lambda x: -x, lambda x: x >= 1.5)
    require(above == (FAILS, "not on 1 of 2: b 1"), f"one fails: {above}")
    require(claims.worst({"a": 2}, lambda x: -x, lambda x: x >= 1.5)[0] == HOLDS, "all hold")
    require(claims.worst({}, lambda x: -x, bool)[0] == MISSING, "nothing was run")
    dense, sparse = "dense Cholesky of order 9", "sparse Cholesky of order 18 by minimum degree"

    def growth(*points):
        return claims.growth(types.SimpleNamespace(growth=lambda: list(points)))

    steep = growth((100, 1, dense), (200, 4, dense.replace("9", "18")), (400, 4, sparse))
    require(steep == (HOLDS, "exponent 1.000 from 100 to 400 observations, at most 2.000 between neighbours solved alike, "
                             "there up to 200"), f"told: steep between two neighbours: {steep}")
    require(growth((100, 1, dense), (200, 4, sparse), (400, 4, sparse))[0] == HOLDS, "another linear solver")
    require(growth((100, 1, dense), (200, 4, sparse)) == (FAILS, "exponent 2.000 from 100 to 200 observations"),
            "steep over all")
    require(growth((100, 1, dense))[0] == MISSING, "one size")


def check_page(folder, command):
    subprocess.run([*command, "--quick"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    page = folder / "docs/performance.md"
    text = page.read_text()
    for section in ("Floors", "Beside Ceres, 1 thread", "Beside Ceres, 2 threads", "Growth", "Cost over time"):
        require(f"\n## {section}\n" in text, f"no section {section}")
    require("Fitted exponent" in text and "ended by function tolerance" in text, "growth and the largest")
    require("nan" not in re.findall(r"[a-z]+", text), "a number is NaN")
    plots = re.findall(r"\]\((performance/course-\S+\.svg)\)", text)
    require(len(plots) == 5, f"{len(plots)} courses of five")
    times = {file: file.stat().st_mtime_ns for file in (folder / "runs").rglob("*.run.json")}
    subprocess.run([*command, "--quick"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    require(times == {file: file.stat().st_mtime_ns for file in times}, "a run was repeated")
    subprocess.run([*command, "--report-only"], check=True, stdout=subprocess.DEVNULL)
    require(page.read_text() == text, "the report differs the second time")


def check_without_ceres(folder, command):
    subprocess.run([*command, "--quick", "--skip-ceres", "--only", "trafalgar-257"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    text = (folder / "docs/performance.md").read_text()
    require(text.count("Ceres was not run.") == 2, "the page without Ceres")
    require("The default beside forced choices" in text, "ours alone")


def main():
    project, program, probe = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(project / "bench"))
    check_judgement()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_times(folder / "times")
        check_standing(folder / "standing")
        for each, check in (("whole", check_page), ("alone", check_without_ceres)):
            check(folder / each, [project / "tools/reproduce", "performance", "-o", folder / each / "runs", "--docs",
                                  folder / each / "docs", "--program", program, "--probe", probe])


main()
