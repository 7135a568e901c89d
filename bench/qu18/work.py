"""Runs what the experiments need; what is there already is not repeated by `raybundle bench`."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass, field

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


def words(options):
    return " ".join(f"--{name} {value}" for name, value in options.items())


class Work:
    def __init__(self, program, probe, folder, settings, ladybug):
        self.program, self.probe_program = str(program), str(probe)
        self.folder, self.settings, self.ladybug = folder, settings, ladybug
        self.loads = {}  # of the machine, before and after the runs on each problem
        (folder / "probe").mkdir(parents=True, exist_ok=True)

    def call(self, *arguments, **more):
        return subprocess.run([str(a) for a in arguments], check=True, text=True, **more)

    def bench(self, problem, chosen, common, limit, scene=None):
        """One call of `raybundle bench`; it carries on when single runs could not be carried out."""
        command = [self.program, "bench", "-o", self.folder / problem, "--ceres", "none",
                   "--runs", self.settings.runs, "--threads", self.settings.threads, "--time-limit", limit,
                   "--common", words({**variants.ROOT_OPTIONS, **common})]
        command += ["--scene", f"{problem}={scene}"] if scene else [f"{problem}={self.ladybug}"]
        for name, options in chosen.items():
            command += ["--variant", f"{name}={options}"]
        before = os.getloadavg()[0]
        code = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL).returncode
        self.loads[problem] = [before, os.getloadavg()[0]]
        if code not in (0, 1):
            sys.exit(f"reproduce: raybundle bench ended with {code} on {problem}")

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
                self.bench(problem, chosen, {"max-iterations": self.settings.trials},
                           self.settings.ladybug_limit)
            elif names:
                scale = self.settings.scales.get(problem)
                scene = f"{problem} --seed {self.settings.seed}" + (f" --scale {scale}" if scale else "")
                known = variants.ball(SIZES[problem])
                self.bench(problem, {name: known[name] for name in known if name in names},
                           {"max-iterations": self.settings.ball_trials}, self.settings.limits[problem],
                           scene)

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

    def draw(self, plots):
        """Draws all plots; the complaint of the program, or nothing."""
        folder = self.folder / "plots"
        folder.mkdir(exist_ok=True)
        specification = self.folder / "plots.json"
        specification.write_text(json.dumps(plots))
        done = subprocess.run([self.probe_program, "draw", str(specification), "-o", str(folder)],
                              text=True, capture_output=True)
        return "" if done.returncode == 0 else done.stderr.strip()
