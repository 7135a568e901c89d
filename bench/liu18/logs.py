"""A run of Table 4, and all that one folder holds."""

import math

from reproduce.logs import fastest, load

from .initial import ORDERS, Row
from .initialise import seen_from_above
from .variants import METHODS


def half_chi2(iteration):
    """Half the sum of squared pixel residuals, whatever the objective: what the paper calls chi2."""
    pixels = iteration["pixel_cost"]
    return iteration["cost"] if pixels is None else pixels


class Run:
    def __init__(self, folder):
        self.log, self.outcome, truth = fastest(folder)
        self.camera = truth.get("camera_rmse")
        trials = self.log["iterations"] if self.log else []
        self.trials = len(trials) - 1
        self.kept = [each for each in trials if each["accepted"]]

    def __bool__(self):
        return bool(self.kept)

    @property
    def termination(self):
        text = self.log["summary"]["termination"] if self else self.outcome["status"]
        return text.replace("_", " ")

    @property
    def broke_down(self):
        """Ended neither converged nor at a limit of iterations or time."""
        return not self or self.outcome["status"] not in ("ok", "not run")

    @property
    def solves(self):
        return self.log["summary"]["linear_solves"]

    @property
    def iterations(self):
        return len(self.kept) - 1

    @property
    def chi2(self):
        return half_chi2(self.kept[-1])

    @property
    def start(self):
        return half_chi2(self.kept[0])

    @property
    def mse(self):
        return 2 * self.chi2 / self.log["problem"]["observations"]

    @property
    def seconds(self):
        return self.log["summary"]["seconds"]["total"]

    @property
    def per_solve(self):
        """Seconds of an equation solve with all that belongs to its iteration, set-up left out."""
        seconds = self.log["summary"]["seconds"]
        return (seconds["total"] - seconds["setup"]) / max(self.solves, 1)

    def first_below(self, chi2):
        """The first accepted iteration at or below; infinite if none."""
        return next((k for k, each in enumerate(self.kept) if half_chi2(each) <= chi2), math.inf)

    def seconds_to(self, chi2):
        return next((each["seconds"] for each in self.kept if half_chi2(each) <= chi2), math.inf)

    def curve(self):
        return list(range(len(self.kept))), [half_chi2(each) for each in self.kept]


class Simulated:
    """A run of Table 3."""

    def __init__(self, folder, name):
        self.log = load(folder / (name + ".json"))
        truth = (load(folder / (name + ".eval.json")) or {}).get("truth") or {}
        self.camera, self.point = truth.get("camera_rmse"), truth.get("point_median")
        kept = [each for each in self.log["iterations"] if each["accepted"]] if self.log else []
        self.chi2 = half_chi2(kept[-1]) if kept else None
        self.points = [each["diagnosis"]["points"] for each in kept if each.get("diagnosis")]

    def __bool__(self):
        return self.log is not None

    @property
    def conditions(self):
        """Of H_FF: its largest over its smallest eigenvalue, of all points."""
        return [each["largest"] / each["smallest"] if each["smallest"] else math.inf for each in self.points]


class Results:
    def __init__(self, folder, settings):
        self.folder, self.settings = folder, settings
        self.methods = list(METHODS)
        self.cache = {}

    def run(self, data_set, method):
        key = data_set, method
        if key not in self.cache:
            self.cache[key] = Run(self.folder / data_set / "runs" / data_set / method)
        return self.cache[key]

    def runs(self, data_set, methods):
        """Those that are there: {method: run}."""
        found = {method: self.run(data_set, method) for method in methods}
        return {method: run for method, run in found.items() if run}

    def simulated(self, method):
        """The first of the draws, which Table 3 shows."""
        return Simulated(self.folder / "four-poses/1", method)

    def draws(self, method):
        folders = (self.folder / "four-poses" / str(seed) for seed in range(1, self.settings.draws + 1))
        return [run for run in (Simulated(folder, method) for folder in folders) if run]

    def start_camera(self, data_set):
        """RMSE of the start's camera centres."""
        data = load(self.folder / data_set / "start.eval.json") or {}
        return (data.get("truth") or {}).get("camera_rmse")

    def streets(self):
        files = sorted((self.folder / "streets").glob("*.json"))
        found = [load(file) for file in files if file.stem.isdigit()]
        return [each for each in found if int(each["seed"]) <= self.settings.streets]

    def initial(self, name, order):
        """A row of Table 5, or nothing."""
        found = load(self.folder / "initial" / name / order.replace(" ", "-") / "found.json")
        return Row(found) if found else None

    def layout(self, name):
        return seen_from_above(self.folder / "initial" / name) if self.initial(name, ORDERS[0]) else []

    def small_scenes(self):
        files = sorted((self.folder / "initial-scenes").glob("*-*.json"))
        return [each for each in map(load, files) if int(each["seed"]) <= self.settings.small_scenes]

    def positions(self):
        """Of images with known rotations."""
        return [load(file) for file in sorted((self.folder / "theorem-2").glob("*-*.json"))]
