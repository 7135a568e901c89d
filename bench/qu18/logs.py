"""What a run of `raybundle bench` left behind."""

import math

from reproduce.logs import fastest, load


class Run:
    """The fastest run of a variant (they differ in time only), cut after `steps` accepted steps, which
    is how the thesis counts iterations."""

    def __init__(self, folder, steps):
        self.log, self.outcome, truth = fastest(folder)
        self.camera, self.point = truth.get("camera_rmse"), truth.get("point_rmse")
        self.median = truth.get("point_median")
        self.trials = cut(self.log["iterations"], steps) if self.log else []
        self.kept = [each for each in self.trials if each["accepted"]]

    def __bool__(self):
        return bool(self.kept)

    @property
    def status(self):
        return self.outcome["status"] if not self else self.log["summary"]["termination"]

    @property
    def failed(self):
        """Ended without having come to a limit or to convergence."""
        return self.outcome["status"] not in ("ok", "not run")

    @property
    def steps(self):
        return len(self.kept) - 1

    @property
    def rejected(self):
        return len(self.trials) - len(self.kept)

    @property
    def cost(self):
        return self.kept[-1]["cost"]

    @property
    def gradient(self):
        return self.kept[-1]["gradient_norm"]

    @property
    def least_gradient(self):
        return min(each["gradient_norm"] for each in self.kept)

    @property
    def total(self):
        """Seconds up to the last step that counts."""
        return self.trials[-1]["seconds"]

    @property
    def per_solve(self):
        """Seconds of a linear solve, mean over the whole run."""
        summary = self.log["summary"]
        return summary["seconds"]["linear"] / max(summary["linear_solves"], 1)

    @property
    def inner(self):
        """Inner iterations of a linear solve."""
        return sum(each["inner_iterations"] for each in self.trials) / max(len(self.trials) - 1, 1)

    @property
    def rises(self):
        """Decades by which the gradient norm rises, all rises added: how much it fluctuates."""
        norms = [each["gradient_norm"] for each in self.kept]
        return sum(max(0.0, math.log10(b / a)) for a, b in zip(norms, norms[1:]) if a > 0 and b > 0)

    @property
    def settled(self):
        """Accepted steps until the gradient norm is at most 10; infinite if never."""
        return next((k for k, each in enumerate(self.kept) if each["gradient_norm"] <= 10), math.inf)

    @property
    def settled_seconds(self):
        """Seconds until the gradient norm is at most 100; infinite if never."""
        return next((each["seconds"] for each in self.kept if each["gradient_norm"] <= 100), math.inf)

    def steps_to(self, cost):
        """Accepted steps until the cost is at most this; infinite if never."""
        return next((k for k, each in enumerate(self.kept) if each["cost"] <= cost), math.inf)

    def seconds_to(self, cost):
        return next((each["seconds"] for each in self.kept if each["cost"] <= cost), math.inf)

    def curve(self, x, y):
        if x == "steps":
            return list(range(len(self.kept))), [each[y] for each in self.kept]
        return [each["seconds"] for each in self.kept], [each[y] for each in self.kept]


def cut(iterations, steps):
    accepted = -1  # the start counts as accepted
    for k, each in enumerate(iterations):
        accepted += each["accepted"]
        if accepted == steps:
            return iterations[:k + 1]
    return iterations


class Results:
    """All that one folder holds: runs[problem][variant] on demand, and what the probe measured."""

    def __init__(self, folder, settings):
        self.folder = folder
        self.settings = settings
        self.cache = {}

    def run(self, problem, variant):
        key = problem, variant
        if key not in self.cache:
            base = self.folder / problem / "runs" / problem / variant
            steps = self.settings.steps if problem == "ladybug" and not variant.startswith("long-") else 10**9
            self.cache[key] = Run(base, steps)
        return self.cache[key]

    def names(self, problem):
        """All variants that the folder has runs of."""
        return sorted(each.name for each in (self.folder / problem / "runs" / problem).glob("*"))

    def probe(self, name):
        return load(self.folder / "probe" / (name + ".json"))
