"""The problems, and how each comes to be a BAL file, which every solver reads alike."""

import json
import shutil
import subprocess
import sys
from dataclasses import dataclass

from reproduce.logs import load


@dataclass
class Problem:
    name: str
    title: str
    file: str = ""  # beneath the folder of the data
    scene: str = ""  # arguments of `raybundle generate`
    quick: float = 1  # the scale in a test; data is left out of one
    sized: bool = False  # a preset, which --scale makes smaller
    part: float = 1  # of the counts of a preset, in a whole run
    calibrate: str = ""  # of a folder: options of the solve with its lens that gives the start


# A folder has a known lens and no points. Its problem is what comes of it when its lens is let go.
CALIBRATE = "--points pmba --objective ray --method dogleg --max-iterations 200"


def preset(name, quick, part=1, **more):
    title = name if part == 1 else f"{name}, times {part:g}"
    return Problem(name, title, scene=name, quick=quick, sized=True, part=part, **more)


PROBLEMS = [
    Problem("bal-21", "BAL Trafalgar 21", "bal/problem-21-11315-pre.txt"),
    Problem("bal-49", "BAL Ladybug 49", "bal/problem-49-7776-pre.txt"),
    Problem("bal-16", "BAL Dubrovnik 16", "bal/problem-16-22106-pre.txt"),
    Problem("fake-pile", "Fake-pile", "parallaxba/fake-pile", calibrate=CALIBRATE),
    Problem("malaga", "Malaga", "parallaxba/Malaga", calibrate=CALIBRATE),
    preset("trafalgar-257", 0.03),
    preset("ladybug-1723", 0.006),
    preset("dubrovnik-356", 0.02),
    preset("venice-1778", 0.004),
    # Of all of it the iterative solver of Ceres took ten minutes for an attempt that was to end after two.
    preset("final-4585", 0.008, part=0.25),
]
TITLES = {each.name: each.title for each in PROBLEMS}
# The same as they come: solvers end in minima of their own, so that no time to a common cost is had.
FAR = [
    Problem("fake-pile-far", "Fake-pile", "parallaxba/fake-pile"),
    Problem("malaga-far", "Malaga", "parallaxba/Malaga"),
]
LARGEST = preset("largest", 0.002, part=1.1)  # only whether and in how much memory it is solved
LARGEST.scene, LARGEST.title = "final-4585", "10 million observations"

GROWTH = [30_000, 100_000, 300_000, 1_000_000, 3_000_000]
QUICK_GROWTH = [3_000, 6_000, 12_000]
TRACK, PER_CAMERA = 4.337, 394  # observations of a point and of a camera: those of ladybug-1723


def street(observations):
    """A longer way at the same density."""
    cameras, points = round(observations / PER_CAMERA) + 2, round(observations / TRACK)
    scene = f"street --cameras {cameras} --points {points} --observations {observations}"
    return Problem(f"street-{observations}", f"{observations:,}", scene=scene)


class Makers:
    """Makes files, each once. What a file was made from stands beside it; another recipe makes it
    anew, and runs on the former one are no longer of interest."""

    def __init__(self, program, folder, data, scale, quick):
        self.program, self.folder, self.data = program, folder, data
        self.scale, self.quick = scale, quick

    def file(self, problem):
        """Where the BAL file is, or None where the data is not there."""
        recipe = self.recipe(problem)
        if recipe is None:
            return None
        file = self.folder / "problems" / (problem.name + ".txt")
        record = file.with_suffix(".json")
        known = load(record)
        if known and known["recipe"] == recipe and file.is_file():
            return file
        if known and known["recipe"] != recipe:
            shutil.rmtree(self.folder / "runs" / problem.name, ignore_errors=True)
        file.parent.mkdir(parents=True, exist_ok=True)
        self.make(problem, recipe, file)
        with open(file, encoding="utf-8") as text:
            counts = dict(zip(("cameras", "points", "observations"), map(int, text.readline().split())))
        record.write_text(json.dumps({"recipe": recipe, **counts}))
        return file

    def recipe(self, problem):
        if not problem.file:
            scale = self.quick_scale(problem) * (self.scale if problem.sized else 1)
            return problem.scene + " --seed 1" + (f" --scale {scale:g}" if scale != 1 else "")
        source = self.data / problem.file
        # A test runs on scenes alone, wherever it is.
        if self.quick or not source.exists():
            return None
        files = sorted(source.iterdir()) if source.is_dir() else [source]
        return " ".join([problem.file, *(str(each.stat().st_size) for each in files), problem.calibrate])

    def quick_scale(self, problem):
        return problem.quick if self.quick else problem.part

    def make(self, problem, recipe, file):
        print(f"reproduce: making {problem.name}", file=sys.stderr)
        source = self.data / problem.file if problem.file else None
        if source is None:
            truth = file.with_suffix(".truth")
            command = ["generate", *recipe.split(), "-o", file, "--truth", truth]
        elif problem.calibrate:
            command = ["solve", source, "-q", *problem.calibrate.split(), "-o", file]
        elif source.is_dir():
            command = ["convert", source, file]
        else:
            shutil.copyfile(source, file)
            return
        subprocess.run([self.program, *map(str, command)], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        if source is None:
            truth.unlink()
