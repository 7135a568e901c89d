"""Runs what the experiments need; what is there already is not repeated by `raybundle bench`."""

import json
import subprocess
import sys
from dataclasses import dataclass, field

from reproduce.runs import Runs, words

from . import variants

SIZES = {"sphere-10": 1000, "sphere-50": 2000, "sphere-100": 3000, "sphere-500": 5000}  # inner iterations


@dataclass
class Settings:
    steps: int = 50  # accepted ones, of chapters 3 and 4
    trials: int = 80
    long_trials: int = 150
    ladybug_limit: float = 60  # seconds of each run
    limits: dict = field(default_factory=lambda: {"sphere-10": 20, "sphere-50": 30, "sphere-100": 40,
                                                  "sphere-500": 80})
    ball_trials: int = 300
    scales: dict = field(default_factory=dict)  # of the four sizes, where not 1
    frames: int = 10
    systems: int = 50
    threads: int = 2
    runs: int = 1
    seed: int = 1

    @classmethod
    def quick(cls):
        return cls(steps=4, trials=5, long_trials=6, ladybug_limit=5, ball_trials=5, frames=4, systems=3,
                   limits=dict.fromkeys(SIZES, 5),
                   scales={"sphere-50": 0.2, "sphere-100": 0.1, "sphere-500": 0.02})


class Work(Runs):
    def __init__(self, program, probe, folder, settings, ladybug):
        super().__init__(program, probe, folder)
        self.settings, self.ladybug = settings, ladybug
        (folder / "probe").mkdir(parents=True, exist_ok=True)

    def solves(self, experiments):
        wanted = {}
        for each in experiments:
            wanted.setdefault(each.problem, set()).update(each.variants())
        for problem, names in wanted.items():
            if names and problem == "ladybug":
                trials = self.settings.long_trials
                known = {**variants.ladybug(),
                         **{name: f"{options} --max-iterations {trials}"
                            for name, options in variants.evaluation().items()}}
                chosen = {name: options for name, options in known.items() if name in names}
                self.solve(problem, [self.ladybug], chosen, self.settings.trials,
                           self.settings.ladybug_limit)
            elif names:
                scale = self.settings.scales.get(problem)
                scene = f"{problem} --seed {self.settings.seed}" + (f" --scale {scale}" if scale else "")
                known = variants.ball(SIZES[problem])
                self.solve(problem, ["--scene", scene],
                           {name: known[name] for name in known if name in names},
                           self.settings.ball_trials, self.settings.limits[problem])

    def solve(self, problem, source, chosen, trials, limit):
        common = {**variants.ROOT_OPTIONS, "max-iterations": trials}
        self.bench(problem, source, chosen, common, limit, self.settings.threads, self.settings.runs)

    def measure(self, experiments):
        for name in dict.fromkeys(name for each in experiments for name in each.probes):
            print(f"reproduce: {name}", file=sys.stderr)
            if name.startswith("geometry-"):
                self.ball(name.removeprefix("geometry-"))
            elif name.startswith("residuals-"):
                self.residuals(name.removeprefix("residuals-"))
            elif name == "increments":
                self.increments()
            else:
                self.keep(name, self.probe(name, self.ladybug, "--frames", self.settings.frames,
                                           "--seed", self.settings.seed, "--systems",
                                           self.settings.systems))

    def probe(self, *arguments):
        return self.call(self.probe_program, *arguments, stdout=subprocess.PIPE).stdout

    def keep(self, name, text):
        (self.folder / "probe" / (name + ".json")).write_text(text)

    def ball(self, name):
        problem = self.folder / name / "problems" / (name + ".txt")
        truth = problem.with_name(name + ".truth.txt")
        self.keep("geometry-" + name, self.probe("geometry", problem))
        self.keep("truth-" + name, self.call(self.program, "eval", problem, "--truth", truth, "--log", "-",
                                             stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)

    def residuals(self, which):
        """The residuals of a start, or of what a method made of it."""
        small = self.folder / "probe" / "small.txt"
        if which == "small-start":
            self.call(self.program, "generate", "sphere", "--cameras", 10, "--points", 253,
                      "--observations", 1326, "--pixel-noise", 0.17, "--seed", self.settings.seed,
                      "--start-rotation", 0.05, "--start-position", 0.07, "--start-focal", 0.02,
                      "--start-point", 0.02, "-o", small, stdout=subprocess.DEVNULL)
        source = small if which.startswith("small") else self.ladybug
        if which in ("start", "small-start"):
            self.keep("residuals-" + which, self.probe("residuals", source))
            return
        method = variants.dinm(method="adinm", max_inner_iterations=3000) if which == "adinm" \
            else variants.dinm(**variants.increments(variants.BALL_INC if which == "small" else {}))
        steps = self.settings.steps * (2 if which == "small" else 1)
        solution = self.folder / "probe" / (which + ".solution.txt")
        self.call(self.program, "solve", source, "-q", "-o", solution, *method.split(),
                  *words({**variants.ROOT_OPTIONS, "max-iterations": steps,
                          "threads": self.settings.threads}).split(), stdout=subprocess.DEVNULL)
        self.keep("residuals-" + which, self.probe("residuals", solution))

    def increments(self):
        """Of Ladybug and, where they are there, of Trafalgar and the balls."""
        files = [self.ladybug, self.ladybug.with_name("problem-21-11315-pre.txt")]
        files += [self.folder / ball / "problems" / (ball + ".txt") for ball in ("sphere-10", "sphere-50")]
        found = {}
        for name, file in ((file.name, file) for file in files):
            if file.is_file():
                found[name] = self.call(self.program, "increments", file, stdout=subprocess.PIPE).stdout
        self.keep("increments", json.dumps(found))
