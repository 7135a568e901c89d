"""Runs the experiments of [Liu18]."""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

from reproduce.logs import load
from reproduce.runs import Runs, words

from . import four_poses, streets
from .initialise import Initialising
from .madrid import Averaging
from .theorem_2 import SEEDS, Placing
from .variants import COMMON, DATA_SETS, METHODS, PAPER_METHODS, START


@dataclass
class Settings:
    trials: int = 300
    scales: dict = field(default_factory=lambda: {each.name: each.scale for each in DATA_SETS})
    limits: dict = field(default_factory=lambda: {each.name: each.limit for each in DATA_SETS})
    draws: int = 100
    streets: int = 200
    small_scenes: int = 25  # of each kind
    position_seeds: int = SEEDS
    quick_scenes: bool = False
    threads: int = 1
    seed: int = 1

    @classmethod
    def quick(cls):
        names = [each.name for each in DATA_SETS]
        scales = {**dict.fromkeys(names, 0.002), "fake-pile-135": 0.05, "victoria-cottage": 0.02,
                  "usyd-mainquad": 0.02}
        return cls(trials=6, scales=scales, limits=dict.fromkeys(names, 10), draws=2, streets=2,
                   small_scenes=1, position_seeds=1, quick_scenes=True)


class Work(Initialising, Placing, Averaging, Runs):
    def __init__(self, program, probe, folder, settings, data=None):
        super().__init__(program, probe, folder)
        self.settings, self.data = settings, data

    def simulate(self):
        """Table 3: four iterations of each, with the eigenvalues of H_FF at each; and the same with other
        noise, since the accuracy of one draw says little."""
        for seed in range(1, self.settings.draws + 1):
            self.simulate_draw(self.folder / "four-poses" / str(seed), seed)

    def simulate_draw(self, folder, seed):
        folder.mkdir(parents=True, exist_ok=True)
        start, truth = folder / "start.txt", folder / "truth.txt"
        four_poses.write(seed, start, truth)
        for name in PAPER_METHODS.values():
            solution = folder / (name + ".solution.txt")
            self.run([self.program, "solve", start, "-q", "--log", folder / (name + ".json"), "-o", solution,
                      *METHODS[name].split(), *words({**COMMON, "max-iterations": 4}).split(), "--diagnose"])
            self.evaluate(solution, truth, folder / (name + ".eval.json"))

    def run(self, command, allowed=(0, 4)):
        """The exit code: 0, or 4 of a numerical failure, which is a result."""
        command = [str(word) for word in command]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in allowed:
            sys.exit(f"reproduce: {' '.join(command)}: {done.stderr.strip()}")
        return done.returncode

    def solve(self, data_set):
        """Table 4: all methods on one data set."""
        common = {**COMMON, "max-iterations": self.settings.trials}
        limit = self.settings.limits[data_set.name]
        if data_set.folder:
            self.real(data_set, {**common, "time-limit": limit, "threads": self.settings.threads})
            return
        scale = self.settings.scales[data_set.name]
        scene = f"{data_set.name} --true-lenses {START} --seed {self.settings.seed}"
        self.bench(data_set.name, ["--scene", scene + (f" --scale {scale}" if scale != 1 else "")], METHODS,
                   common, limit, self.settings.threads)

    def real(self, data_set, common):
        """From a folder in ParallaxBA's format, without a detour by BAL files, whose pixels are square."""
        given = self.data / data_set.folder
        if not given.is_dir():
            return
        base = self.folder / data_set.name
        base.mkdir(exist_ok=True)
        truth = self.true_cameras(given, base)
        if truth:
            self.as_bal(given, base / "start.txt")
            self.evaluate(base / "start.txt", truth, base / "start.eval.json")
        before = os.getloadavg()[0]
        for method, options in METHODS.items():
            folder = base / "runs" / data_set.name / method
            stamp = f"{self.hash()} {options} {words(common)}"
            if (load(folder / "1.run.json") or {}).get("stamp") == stamp:
                continue
            folder.mkdir(parents=True, exist_ok=True)
            solution = folder / "solution.txt"
            code = self.run([self.program, "solve", given, "-q", "--log", folder / "1.json", "-o", solution,
                             *words(common).split(), *options.split()])
            if truth:
                self.evaluate(solution, truth, folder / "1.eval.json")
            solution.unlink()
            outcome = {"status": "failed" if code else "ok", "stamp": stamp}
            (folder / "1.run.json").write_text(json.dumps(outcome))
        self.loads[data_set.name] = [before, os.getloadavg()[0]]

    def true_cameras(self, given, base):
        """Where they are known: a BAL file of them."""
        cameras = next(given.glob("GTCam*"), None)
        if cameras is None:
            return None
        folder = base / "true-cameras"
        folder.mkdir(exist_ok=True)
        links = {file.name: file for kind in ("Feature*", "cal*", "intrinsic*") for file in given.glob(kind)}
        for name, file in {**links, "Cam.txt": cameras}.items():
            (folder / name).unlink(missing_ok=True)
            (folder / name).symlink_to(file.resolve())
        self.as_bal(folder, base / "truth.txt")
        return base / "truth.txt"

    def as_bal(self, folder, file):
        self.run([self.program, "solve", folder, "-q", "--lens", "fixed", "--max-iterations", 0, "-o", file])

    def evaluate(self, solution, truth, log):
        self.run([self.program, "eval", solution, "--truth", truth, "--log", log])

    def hash(self):
        """Of the program: its runs are kept as long as it stays as it is."""
        return hashlib.sha256(pathlib.Path(self.program).read_bytes()).hexdigest()[:16]

    def drive(self):
        """The street scenes, two at once: their times are of no interest."""
        folder = self.folder / "streets"
        folder.mkdir(exist_ok=True)
        stamp = {"program": self.hash(), "recipe": streets.recipe()}

        def one(seed):
            file = folder / f"{seed}.json"
            if (load(file) or {}).get("stamp") != stamp:
                file.write_text(json.dumps({"stamp": stamp, **self.street(folder, seed)}))

        with ThreadPoolExecutor(2) as pool:
            list(pool.map(one, range(1, self.settings.streets + 1)))

    def street(self, folder, seed):
        problem, log = folder / f"{seed}.txt", folder / f"{seed}.log.json"
        truth = folder / f"{seed}.truth.txt"
        self.run([self.program, "generate", *streets.SCENE.split(), "--seed", seed, "-o", problem])
        found = {"seed": seed, "kinds": streets.kinds(truth), "runs": {}}
        for name, options in streets.runs().items():
            self.run([self.program, "solve", problem, "-q", "--threads", 1, "--log", log, *options])
            found["runs"][name] = streets.outcome(load(log))
        for file in (problem, truth, log):
            file.unlink()
        return found
