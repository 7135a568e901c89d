#!/usr/bin/env python3
"""Checks tools/reproduce qu18 on tiny scenes: the report has every table, figure and plot of the thesis, its
cutting of runs and its claims judge as they should, and it comes out the same a second time.

Usage: check_qu18.py PROJECT PROGRAM PROBE
"""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

TABLES = [f"3.{k}" for k in range(1, 12)] + ["4.1", "4.2", "5.1", "5.2", "5.3", "5.4"]
FIGURES = ([f"3-{k:02d}" for k in [1, *range(4, 24)]] + [f"4-{k:02d}" for k in range(1, 7)]
           + [f"5-{k:02d}" for k in [2, *range(4, 20)]])
LARGEST = 60_000  # bytes of a plot


def require(good, what):
    if not good:
        sys.exit(f"check_qu18: {what}")


def check_judgement(project):
    """The parts of the script that decide what the report says."""
    sys.path.insert(0, str(project / "bench"))
    from qu18 import claims, logs, measured, variants
    from reproduce.claims import FAILS, HOLDS, MISSING, TIE

    trials = [{"accepted": good, "cost": cost, "gradient_norm": norm, "seconds": time,
               "inner_iterations": 4 if time else 0} for good, cost, norm, time in
              ((True, 9, 8, 0), (False, 9, 8, 1), (True, 5, 80, 2), (True, 4, 0.8, 3), (True, 3, 1, 4))]
    require(len(logs.cut(trials, 2)) == 4 and len(logs.cut(trials, 99)) == 5, "cut by accepted steps")
    run = logs.Run(pathlib.Path("nowhere"), 2)
    require(not run and run.status == "not run", "a run that is not there")
    run.trials = logs.cut(trials, 2)
    run.kept = [each for each in run.trials if each["accepted"]]
    require((run.steps, run.rejected, run.cost, run.total, run.inner) == (2, 1, 4, 3, 4), "counts of a run")
    require(abs(run.rises - 1) < 1e-12 and run.steps_to(5) == 1, "rises and steps of a run")

    class Results:
        def __init__(self, costs):
            self.costs = costs

        def run(self, _, name):
            return type("R", (), {"cost": self.costs[name]}) if name in self.costs else None

    check = claims.least("p", "cost", ["a"], ["a", "b"])
    for costs, verdict in (({"a": 1, "b": 2}, HOLDS), ({"a": 2, "b": 1}, FAILS),
                           ({"a": 1, "b": 1 + 1e-9}, TIE), ({"b": 1}, MISSING)):
        require(check(Results(costs))[0] == verdict, f"verdict {verdict}")
    require(abs(measured.normal_share(0, 1, 2) - 0.0455) < 1e-4, "tail of the Gaussian")
    require(len(variants.ladybug()) == 51, "variants of chapters 3 and 4")


def main():
    project, program, probe = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    sys.dont_write_bytecode = True
    check_judgement(project)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [project / "tools/reproduce", "qu18", "-o", folder / "runs", "--docs", folder / "docs",
                   "--program", program, "--probe", probe]
        subprocess.run([*command, "--quick"], check=True, stdout=subprocess.DEVNULL)
        report = folder / "docs/qu18.md"
        text = report.read_text()
        require("look-alike scene" in text, "the report does not say what stood in for Ladybug")
        for table in TABLES:
            require(re.search(rf"^Table {re.escape(table)}\b", text, re.M), f"no Table {table}")
        require("Figure" not in "".join(re.findall(r"^.*: not run\.$", text, re.M)), "figures were not run")
        for figure in FIGURES:
            require(f"](qu18/fig-{figure}" in text, f"no Figure {figure}")
        require("nan" not in re.findall(r"[a-z]+", text), "a number is NaN")
        if shutil.which("gnuplot"):
            for plot in re.findall(r"\]\((qu18/\S+\.svg)\)", text):
                size = (report.parent / plot).stat().st_size
                require(0 < size < LARGEST, f"{plot} has {size} bytes")
        subprocess.run([*command, "--report-only"], check=True, stdout=subprocess.DEVNULL)
        require(report.read_text() == text, "the report differs the second time")


main()
