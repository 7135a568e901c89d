#!/usr/bin/env python3
"""Checks tools/reproduce liu18 on tiny scenes: the simulation is what it says, claims judge as they should,
the report has every table and figure, and it comes out the same a second time.

Usage: check_liu18.py PROJECT PROGRAM PROBE
"""

import math
import pathlib
import re
import subprocess
import sys
import tempfile


def require(good, what):
    if not good:
        sys.exit(f"check_liu18: {what}")


def check_simulation(folder):
    from liu18 import four_poses
    require(max(abs(a - b) for a, b in zip(four_poses.product(four_poses.rotation([0, 0, math.pi / 2]),
                                                              [1, 0, 0]), [0, 1, 0])) < 1e-15, "rotation")
    files = [folder / "start.txt", folder / "truth.txt"]
    four_poses.write(1, *files)
    start, truth = (file.read_text().split("\n") for file in files)
    require(start[0] == "4 10 40" and start[:41] == truth[:41], "counts and observations")
    numbers = [float(line) for line in truth[41:-1]]
    cameras = [numbers[9 * j:9 * j + 9] for j in range(4)]
    points = [numbers[36 + 3 * i:39 + 3 * i] for i in range(10)]
    for line in truth[1:41]:
        j, i, *seen = line.split()
        error = math.dist(map(float, seen), four_poses.project(cameras[int(j)], points[int(i)]))
        require(error < 5 * four_poses.PIXEL_NOISE, f"observation {line} is {error} pixels off")
    turned = [list(row) for row in zip(*four_poses.rotation(cameras[0][:3]))]  # R_wc
    centre = [-t for t in four_poses.product(turned, cameras[0][3:6])]
    offset = [a - b for a, b in zip(points[four_poses.SINGULAR], centre)]
    require(math.dist(offset, [0, 6, 0]) < 1e-12, "the singular feature is along y")
    require(math.hypot(*points[four_poses.FAR]) > 9e3, "the far feature is far")


class Run:
    def __init__(self, chi2, solves=1, broke_down=False):
        self.chi2, self.solves, self.broke_down, self.termination = chi2, solves, broke_down, "as it did"


class Results:
    def __init__(self, runs):
        self.methods, self.all = list(runs), runs

    def runs(self, data_set, methods):
        return {name: self.all[name] for name in methods if name in self.all and data_set == "malaga"}

    def run(self, data_set, method):
        return self.all.get(method) if data_set == "malaga" else None


def check_judgement():
    from liu18 import claims, logs
    from reproduce.claims import FAILS, HOLDS, MISSING
    good = {"PMBA-DL": Run(1.0, 3), "PBA-LM": Run(1.001, 4), "IDP-LM": Run(1.5, 4), "XYZ-LM": Run(2.0, 3)}
    require(claims.minima(Results(good))[0] == HOLDS, "minima as the paper has them")
    require(claims.minima(Results({**good, "IDP-LM": Run(1.0)}))[0] == FAILS, "one minimum too good")
    require(claims.minima(Results({}))[0] == MISSING, "no runs")
    solves = claims.fewest("solves", "solves")
    require(solves(Results(good))[0] == HOLDS, "fewest solves, a tie")
    require(solves(Results({**good, "XYZ-LM": Run(2.0, 2)}))[0] == FAILS, "fewer solves elsewhere")
    for run, verdict in ((Run(1.5), FAILS), (Run(1.6), HOLDS), (Run(1.5, broke_down=True), HOLDS)):
        require(claims.unstable("IDP")(Results({**good, "IDP-DL": run}))[0] == verdict, "instability")
    require(logs.half_chi2({"cost": 2, "pixel_cost": None}) == 2, "chi2 of pixels")
    require(logs.half_chi2({"cost": 2, "pixel_cost": 3}) == 3, "chi2 of rays")


def check_layout(folder):
    from liu18 import four_poses, initial, layout
    start, truth, other = folder / "start.txt", folder / "truth.txt", folder / "shuffled.txt"
    four_poses.write(2, start, truth)
    places = layout.centres(truth)
    turned = [[3 - 2 * y, 2 * x, 2 * z - 1] for x, y, z in places]
    back = layout.aligned(turned, places)
    require(max(math.dist(a, b) for a, b in zip(back, places)) < 1e-9, "alignment")
    flat = layout.from_above([[x, 0.1 * z, y] for x, y, z in [[5, 0, 0], [-5, 0, 0], [0, 2, 0], [0, -2, 0]]])[0]
    require(max(abs(x) for x, _ in flat) > 4.99 and max(abs(y) for _, y in flat) > 1.99, "seen from above")
    initial.shuffled(truth, other)
    moved = layout.centres(other)
    require(sorted(moved) == sorted(places) and moved != places, "the same cameras in another order")


def main():
    project, program, probe = (pathlib.Path(word).resolve() for word in sys.argv[1:])
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(project / "bench"))
    check_judgement()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        check_simulation(folder)
        check_layout(folder)
        command = [project / "tools/reproduce", "liu18", "-o", folder / "runs", "--docs", folder / "docs",
                   "--program", program, "--probe", probe]
        subprocess.run([*command, "--quick"], check=True, stdout=subprocess.DEVNULL)
        report = folder / "docs/liu18.md"
        text = report.read_text()
        require(re.search("^Table 3$", text, re.M), "no Table 3")
        require(text.count("Not run.") == 3, "something beside the three real data sets was not run")
        for method in ("PMBA-DL", "PMBA-LM", "PBA-DL", "IDP-LM", "XYZ-LM"):
            require(text.count(f"\n| {method} |") >= 6, f"{method} is not in every table")
        figures = re.findall(r"\]\((liu18/fig-8-\S+\.svg)\)", text)
        require(len(figures) == 5, f"{len(figures)} figures of five")
        require(len(re.findall(r"\| (?:sequential|out of order) \|", text)) == 4, "two scenes in two orders")
        require(len(re.findall(r"\]\(liu18/fig-9-", text)) == 2, "two layouts")
        require(all(f"\n| {kind} | 1 |" in text for kind in ("street", "sphere", "aerial", "photos")),
                "a small scene of each kind")
        require(text.count("\n| street, a third of the points along the way | ") == 1, "positions of a street")
        require("nan" not in re.findall(r"[a-z]+", text), "a number is NaN")
        subprocess.run([*command, "--report-only"], check=True, stdout=subprocess.DEVNULL)
        require(report.read_text() == text, "the report differs the second time")


main()
