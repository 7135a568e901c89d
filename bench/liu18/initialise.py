"""Runs global initialisation and its rival."""

import json
import os

from reproduce.logs import load

from . import layout
from .initial import FINISH, KINDS, ORDERS, ROBUST, SOURCES, WRONG, shuffled

SCENE_NOISE = "--true-lenses --pixel-noise 1"


def pixel_cost(log):
    """Of the last iteration, in pixels and without a loss."""
    last = load(log)["iterations"][-1]
    return last["cost"] if last["pixel_cost"] is None else last["pixel_cost"]


class Initialising:
    """A part of Work."""

    def initialise(self, name):
        source = next(each for each in SOURCES if each.name == name)
        base = self.folder / "initial" / name
        base.mkdir(parents=True, exist_ok=True)
        problem, reference = self.initial_problem(source, base)
        if problem is None:
            return
        before = os.getloadavg()[0]
        for order in ORDERS:
            folder = base / order.replace(" ", "-")
            stamp = f"{self.hash()} {FINISH}"
            if (load(folder / "found.json") or {}).get("stamp") == stamp:
                continue
            folder.mkdir(exist_ok=True)
            given = folder / "problem.txt"
            if order == ORDERS[0]:
                given.unlink(missing_ok=True)
                given.symlink_to(problem.resolve())
            else:
                shuffled(problem, given)
            found = self.initialise_one(given, folder, reference)
            (folder / "found.json").write_text(json.dumps({"stamp": stamp, **found}))
        self.loads[name] = [before, os.getloadavg()[0]]

    def initial_problem(self, source, base):
        """A BAL file of what is seen, and one whose poses are the reference's start."""
        problem = base / "problem.txt"
        if source.scene:
            truth = base / "problem.truth.txt"
            if not truth.is_file():
                self.run([self.program, "generate", *self.scene(source), *SCENE_NOISE.split(), "--seed",
                          self.settings.seed, "-o", problem])
            return problem, truth
        given = self.data.parent / source.file
        if not given.exists():
            return None, None
        if not problem.is_file():
            self.run([self.program, "convert", given, problem] if given.is_dir() else
                     ["cp", given, problem])
        return problem, problem

    def scene(self, source):
        """Its words; for a test a tiny one of its kind."""
        if not self.settings.quick_scenes:
            return source.scene.split()
        kind = source.scene.split()[0]
        return [kind, "--scale", "0.02"] if "--scale" in source.scene else [kind, "--cameras", "8", "--points", "300"]

    def initialise_one(self, given, folder, reference):
        start, solved = folder / "start.txt", folder / "solved.txt"
        self.run([self.program, "init", given, "-q", "-o", start, "--log", folder / "global.json"])
        self.run([self.program, "solve", start, "-q", *FINISH.split(), "-o", solved, "--log", folder / "solve.json"])
        self.run([self.program, "init", given, "-q", "--pipeline", "incremental", "--log",
                  folder / "incremental.json"])
        best = folder.parent / "reference.json"
        if not best.is_file():
            self.run([self.program, "solve", reference, "-q", *FINISH.split(), "-o", folder.parent / "reference.txt",
                      "--log", best])
        finish = load(folder / "solve.json")
        return {"global": load(folder / "global.json"), "incremental": load(folder / "incremental.json"),
                "finish": finish["summary"]["seconds"]["total"], "cost": pixel_cost(folder / "solve.json"),
                "reference": pixel_cost(best)}

    def initialise_small(self):
        """Scenes of every kind with wrong matches."""
        folder = self.folder / "initial-scenes"
        folder.mkdir(exist_ok=True)
        for kind, scene in KINDS.items():
            for seed in range(1, self.settings.small_scenes + 1):
                file = folder / f"{kind}-{seed}.json"
                stamp = f"{self.hash()} {ROBUST} {scene} {WRONG}"
                if (load(file) or {}).get("stamp") == stamp:
                    continue
                found = self.initialise_scene(folder, scene, seed)
                file.write_text(json.dumps({"stamp": stamp, "kind": kind, "seed": seed, **found}))

    def initialise_scene(self, folder, scene, seed):
        problem, truth, start = (folder / f"scene{end}.txt" for end in ("", ".truth", ".start"))
        logs = [folder / name for name in ("init.log", "found.log", "best.log")]
        self.run([self.program, "generate", *scene.split(), *SCENE_NOISE.split(), "--outliers", WRONG, "--seed", seed,
                  "-o", problem])
        self.run([self.program, "solve", truth, "-q", *ROBUST.split(), "--log", logs[2]])
        failed = self.run([self.program, "init", problem, "-q", "-o", start, "--log", logs[0]], allowed=(0, 3, 4))
        if failed:
            return {"placed": False, "ratio": None}
        placed = load(logs[0])["placed"]["cameras"] == load(logs[0])["problem"]["cameras"]
        self.run([self.program, "solve", start, "-q", *ROBUST.split(), "--log", logs[1]])
        found, best = (load(log)["summary"]["final_cost"] for log in logs[1:])
        return {"placed": placed, "ratio": found / best if placed else None}


def seen_from_above(folder):
    """Short lines from where the reference has a camera to where initialisation and its solve put it."""
    reference, solved = folder / "reference.txt", folder / "sequential/solved.txt"
    if not reference.is_file() or not solved.is_file():
        return []
    places, ours = layout.centres(reference), layout.centres(solved)
    if len(places) != len(ours):
        return []
    there, here = layout.from_above(places, layout.aligned(ours, places))
    return [[*a, *b] for a, b in zip(there, here)]
