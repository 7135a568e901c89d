"""What the runs left behind. Whole courses of the cost are kept: times are found here, from the best
cost that is known by now."""

import math
import statistics

from reproduce.logs import load

from .machine import PHASES
from .problems import PROBLEMS
from .variants import AUTO, CERES, FORCED, NATIVE

TARGETS = (1.01, 1.001)  # times the best cost that any solver found
SCALING_FROM = 200_000  # observations above which two threads are to show what they gain


class Run:
    def __init__(self, base):
        self.outcome = load(base.with_suffix(".run.json")) or {}
        self.log = load(base.with_suffix(".json")) if self.outcome else None
        trials = self.log["iterations"] if self.log else []
        self.iterations = len(trials) - 1
        self.end = trials[-1]["seconds"] if trials else 0
        self.kept = [each for each in trials if each["accepted"] and each["cost"] is not None]

    def __bool__(self):
        return bool(self.kept)

    @property
    def least(self):
        return min((each["cost"] for each in self.kept), default=math.inf)

    def first(self, cost):
        """The first iteration at or below."""
        return next((each for each in self.kept if each["cost"] <= cost), None)

    def seconds_to(self, cost):
        found = self.first(cost)
        return found["seconds"] if found else math.inf

    def iterations_to(self, cost):
        found = self.first(cost)
        return found["iteration"] if found else math.inf

    @property
    def summary(self):
        return self.log["summary"]

    @property
    def peak(self):
        return self.summary["peak_rss_bytes"]


def phase_median(runs, phase):
    """Of the seconds of a phase; `rest`: of no phase, such as the set-up. None without runs."""
    seconds = [run.summary["seconds"] for run in runs]
    if not seconds:
        return None
    if phase == "rest":
        return statistics.median(each["total"] - sum(each[name] for name in PHASES) for each in seconds)
    return statistics.median(each[phase] for each in seconds)


def per_iteration(runs):
    """Seconds of an outer iteration, set-up left out: the median of the runs."""
    return statistics.median((run.end - run.kept[0]["seconds"]) / run.iterations for run in runs)


class Results:
    """Of one folder: runs/PROBLEM/{explore,final,screen-T,timed-T-N,twins-N}/VARIANT. `rates`: see machine.py."""

    def __init__(self, folder, threads=(1, 2), rates=None):
        self.folder, self.threads, self.rates = folder, list(threads), rates or {}
        self.cache = {}

    @property
    def names(self):
        """Of the problems that our default ran on."""
        return [each.name for each in PROBLEMS if self.run(each.name, "explore", AUTO)]

    def base(self, problem, kind, variant):
        return self.folder / "runs" / problem / kind / variant

    def run(self, problem, kind, variant):
        return self.read(self.base(problem, kind, variant))

    def read(self, base):
        """Again only when it has been run again."""
        record = base.with_suffix(".run.json")
        time = record.stat().st_mtime_ns if record.is_file() else None
        if self.cache.get(base, (0,))[0] != time:
            self.cache[base] = time, Run(base)
        return self.cache[base][1] if time else Run(base)

    def runs(self, problem, pattern):
        """(variant, run) of all that are there."""
        files = sorted((self.folder / "runs" / problem).glob(f"{pattern}/*.run.json"))
        named = ((file.name.removesuffix(".run.json"), file) for file in files)
        found = [(name, self.read(file.with_name(name))) for name, file in named]
        return [(name, run) for name, run in found if run]

    def counts(self, problem):
        return load(self.folder / "problems" / (problem + ".json"))

    def best(self, problem):
        """The least cost that anybody found."""
        return min((run.least for _, run in self.runs(problem, "*")), default=math.inf)

    def screened(self, problem, threads, names):
        """{variant: its screening run}, of those that ran at all."""
        found = {name: self.run(problem, f"screen-{threads}", name) for name in names}
        return {name: run for name, run in found.items() if run}

    def chosen_ceres(self, problem, threads):
        """The fastest variant to each target, without repetition; where none gets there, the one
        with the least cost."""
        runs, best = self.screened(problem, threads, CERES), self.best(problem)
        if not runs:
            return []
        names = [min(runs, key=lambda name: (runs[name].seconds_to(factor * best), runs[name].least))
                 for factor in reversed(TARGETS)]
        return list(dict.fromkeys(names))

    def chosen_forced(self, problem, threads):
        """Those that reach a target within the bounds of their screening."""
        bound = TARGETS[-1] * self.best(problem)
        runs = self.screened(problem, threads, FORCED)
        return [name for name, run in runs.items() if run.least <= bound]

    def timed(self, problem, threads, variant):
        return [run for name, run in self.runs(problem, f"timed-{threads}-*") if name == variant]

    def seconds(self, problem, threads, variant, factor):
        """Median over the runs; None where there are none."""
        bound = factor * self.best(problem)
        times = [run.seconds_to(bound) for run in self.timed(problem, threads, variant)]
        return statistics.median(times) if times else None

    def fastest(self, problem, threads, names, factor):
        """(variant, seconds) of the best median; None where nothing was timed."""
        times = {name: self.seconds(problem, threads, name, factor) for name in names}
        times = {name: value for name, value in times.items() if value is not None}
        if not times:
            return None
        name = min(times, key=times.get)
        return name, times[name]

    def ceres(self, problem, threads, factor):
        """(variant, seconds, whether it got there): else the seconds are those it had."""
        found = self.fastest(problem, threads, self.chosen_ceres(problem, threads), factor)
        if not found or math.isfinite(found[1]):
            return found and (*found, True)
        longest = max(run.end for run in self.timed(problem, threads, found[0]))
        return found[0], longest, False

    def forced(self, problem, threads, factor):
        return self.fastest(problem, threads, FORCED, factor)

    def speed_up(self, problem, threads, factor):
        """(Ceres' time over ours, whether Ceres got there), or None. A bound from below where it
        did not."""
        theirs = self.ceres(problem, threads, factor)
        ours = self.seconds(problem, threads, AUTO, factor)
        if not theirs or ours is None:
            return None
        return theirs[1] / ours, theirs[2]

    def over(self, problem, threads, rival, factor):
        """Our default's time over that of another way of ours."""
        ours, theirs = (self.seconds(problem, threads, name, factor) for name in (AUTO, rival))
        return ours / theirs if ours and theirs else None

    def native(self, problem, threads, factor):
        return self.over(problem, threads, NATIVE, factor)

    def final_difference(self, problem):
        """Of the final costs with the defaults of both, relative to that of Ceres; None: not run."""
        ours, theirs = (self.run(problem, "final", name) for name in (AUTO, "ceres"))
        return ours.least / theirs.least - 1 if ours and theirs else None

    def memory(self, problem, threads):
        """(our peak, that of Ceres' fastest variant, the least of any of its variants), bytes. Ours is
        the largest of all runs; of Ceres the least of the fastest variant's."""
        ours = [run.peak for run in self.timed(problem, threads, AUTO)]
        ours += [self.run(problem, "final", AUTO).peak] if ours else []
        theirs = self.ceres(problem, threads, TARGETS[-1])
        if not ours or not theirs:
            return None
        fastest = min(run.peak for run in self.timed(problem, threads, theirs[0]))
        leanest = min(run.peak for run in self.screened(problem, threads, CERES).values())
        return max(ours), fastest, min(leanest, fastest)

    def phase_seconds(self, problem, threads, phase):
        """Median over the runs of our default; None where there are none."""
        return phase_median(self.timed(problem, threads, AUTO), phase)

    def twin_gain(self, problem, phase):
        """What two cores gain for the very work of a phase: twice the time of one process alone over that
        of two at once, each with one thread. None where nothing was measured."""
        alone = self.phase_seconds(problem, 1, phase)
        together = phase_median([run for _, run in self.runs(problem, "twins-*")], phase)
        return 2 * alone / together if alone and together else None

    def phase_gain(self, problem, phase):
        """Time with one thread over that with two, of the same iterations."""
        one, two = (self.phase_seconds(problem, threads, phase) for threads in (1, 2))
        return one / two if one and two else None

    def phase_share(self, problem, phase):
        """Of the time of the whole solve, with one thread."""
        own, whole = (self.phase_seconds(problem, 1, name) for name in (phase, "total"))
        return own / whole if whole else None

    def linear_solver(self, problem):
        """What our default chose on its way to the second target, in its words."""
        runs = self.timed(problem, self.threads[-1], AUTO) or [self.run(problem, "explore", AUTO)]
        return runs[0].summary["linear_solver"]

    def growth(self):
        """(observations, seconds of an iteration, linear solver in its own words), in order."""
        found = []
        for file in (self.folder / "runs").glob("street-*"):
            runs = [run for _, run in self.runs(file.name, "growth-*") if run.iterations > 0]
            if runs:
                found.append((self.counts(file.name)["observations"], per_iteration(runs),
                              runs[0].summary["linear_solver"]))
        return sorted(found)

    def builds(self):
        """Hashes of the programs that left the runs of our default."""
        files = (self.folder / "runs").glob(f"*/*/{AUTO}.run.json")
        return sorted({load(file)["stamp"].split()[0] for file in files})
