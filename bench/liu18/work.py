"""Runs the experiments of [Liu18]."""

import hashlib
import json
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

from reproduce.logs import load
from reproduce.runs import Runs, words

from . import four_poses, streets
from .variants import COMMON, DATA_SETS, METHODS


@dataclass
class Settings:
    trials: int = 300
    scales: dict = field(default_factory=lambda: {each.name: each.scale for each in DATA_SETS})
    limits: dict = field(default_factory=lambda: {each.name: each.limit for each in DATA_SETS})
    streets: int = 200
    threads: int = 1
    seed: int = 1

    @classmethod
    def quick(cls):
        names = [each.name for each in DATA_SETS]
        scales = {**dict.fromkeys(names, 0.002), "fake-pile-135": 0.05, "victoria-cottage": 0.02,
                  "usyd-mainquad": 0.02}
        return cls(trials=6, scales=scales, limits=dict.fromkeys(names, 10), streets=2)


class Work(Runs):
    def __init__(self, program, probe, folder, settings, data=None):
        super().__init__(program, probe, folder)
        self.settings, self.data = settings, data

    def simulate(self):
        """Table 3: four iterations of each, with the eigenvalues of H_FF at each."""
        folder = self.folder / "four-poses"
        folder.mkdir(exist_ok=True)
        start, truth = folder / "start.txt", folder / "truth.txt"
        four_poses.write(self.settings.seed, start, truth)
        for name in ("PMBA-DL", "PBA-LM", "IDP-LM", "XYZ-LM"):
            solution = folder / (name + ".solution.txt")
            self.run([self.program, "solve", start, "-q", "--log", folder / (name + ".json"), "-o", solution,
                      *METHODS[name].split(), *words({**COMMON, "max-iterations": 4}).split(), "--diagnose"])
            self.run([self.program, "eval", solution, "--truth", truth, "--log",
                      folder / (name + ".eval.json")])

    def run(self, command):
        """A numerical failure (exit code 4) is a result."""
        command = [str(word) for word in command]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode not in (0, 4):
            sys.exit(f"reproduce: {' '.join(command)}: {done.stderr.strip()}")

    def solve(self, data_set):
        """Table 4: all methods on one data set."""
        if data_set.folder:
            source = self.real(data_set)
            if source is None:
                return
        else:
            scale = self.settings.scales[data_set.name]
            source = ["--scene", f"{data_set.name} --true-lenses {data_set.start} --seed {self.settings.seed}"
                      + (f" --scale {scale}" if scale != 1 else "")]
        self.bench(data_set.name, source, METHODS, {**COMMON, "max-iterations": self.settings.trials},
                   self.settings.limits[data_set.name], self.settings.threads)

    def real(self, data_set):
        """A folder in ParallaxBA's format as a BAL file, and as its truth, where the cameras' is known, the
        same with these cameras. None where the data are not there."""
        given = self.data / data_set.folder
        if not given.is_dir():
            return None
        file = self.folder / data_set.name / "problems" / (data_set.name + ".txt")
        truth = file.with_suffix(".truth.txt")
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.is_file():  # a new file would make all runs be repeated
            self.as_bal(given, file)
        cameras = next(given.glob("GTCam*"), None)
        if cameras is None:
            return [file]
        if not truth.is_file():
            self.as_bal(self.with_cameras(given, cameras), truth)
            self.run([self.program, "eval", file, "--truth", truth, "--log", file.with_suffix(".eval.json")])
        return [f"{file}:{truth}"]

    def as_bal(self, folder, file):
        self.run([self.program, "solve", folder, "-q", "--lens", "fixed", "--max-iterations", 0, "-o", file])

    def with_cameras(self, given, cameras):
        folder = self.folder / "with-true-cameras"
        folder.mkdir(exist_ok=True)
        for file in [*given.glob("Feature*"), *given.glob("cal*"), *given.glob("intrinsic*"), cameras]:
            link = folder / (file.name if file != cameras else "Cam.txt")
            link.unlink(missing_ok=True)
            link.symlink_to(file.resolve())
        return folder

    def drive(self):
        """The street scenes, two at once: their times are of no interest."""
        folder = self.folder / "streets"
        folder.mkdir(exist_ok=True)
        program = hashlib.sha256(pathlib.Path(self.program).read_bytes()).hexdigest()[:16]
        stamp = [program, streets.SCENE, {name: " ".join(options) for name, options in streets.runs().items()}]

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
