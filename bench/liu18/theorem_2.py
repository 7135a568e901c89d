"""Positions of images whose rotations are known ([Liu18, Theorem 2]): without noise exact, collinear motion
included, and with it off in proportion.

Rotations are those of the truth (`raybundle init --rotations problem`), everything else comes from the
observations. Errors are the RMSE of the camera centres after alignment with the truth, over how far the centres
are from their mean (RMS)."""

import json
import math
import statistics

from reproduce.claims import FAILS, HOLDS, MISSING, Claim, number
from reproduce.logs import load
from reproduce.text import table

from . import layout

SCENES = {"street": "street --cameras 30 --points 1500",
          "street, a third of the points along the way": "street --cameras 30 --points 1500 --collinear 0.3",
          "sphere": "sphere --cameras 15 --points 800 --region 0.5",
          "aerial": "aerial --cameras 30 --points 1500",
          "photos": "photos --cameras 30 --points 1500 --observations 9000"}
NOISES = (0, 0.25, 0.5, 1, 2)  # pixels
SEEDS = 5
EXACT = 1e-6
PROPORTION = 1.3  # of the errors per pixel, most over least
START = "--true-lenses --start-rotation 0"


class Placing:
    """A part of Work."""

    def place(self):
        folder = self.folder / "theorem-2"
        folder.mkdir(exist_ok=True)
        for at, (name, scene) in enumerate(SCENES.items()):
            for noise in NOISES:
                for seed in range(1, self.settings.position_seeds + 1):
                    file = folder / f"{at}-{noise:g}-{seed}.json"
                    stamp = f"{self.hash()} {scene} {START}"
                    if (load(file) or {}).get("stamp") != stamp:
                        error = self.place_one(folder, scene, noise, seed)
                        file.write_text(json.dumps({"stamp": stamp, "scene": name, "noise": noise, "error": error}))

    def place_one(self, folder, scene, noise, seed):
        problem, truth, start, log = (folder / name for name in (
            "problem.txt", "problem.truth.txt", "start.txt", "eval.log"))
        self.run([self.program, "generate", *scene.split(), *START.split(), "--pixel-noise", noise, "--seed", seed,
                  "-o", problem])
        self.run([self.program, "init", problem, "-q", "--rotations", "problem", "-o", start])
        self.evaluate(start, truth, log)
        return load(log)["truth"]["camera_rmse"] / spread(layout.centres(truth))


def spread(centres):
    middle = layout.mean(centres)
    return math.sqrt(sum(math.dist(each, middle) ** 2 for each in centres) / len(centres))


def medians(results):
    """{scene: {noise: error}} of those that were run."""
    found = {}
    for each in results.positions():
        found.setdefault(each["scene"], {}).setdefault(each["noise"], []).append(each["error"])
    return {scene: {noise: statistics.median(errors) for noise, errors in rows.items()} for scene, rows in found.items()}


def exact(results):
    errors = {scene: rows[0] for scene, rows in medians(results).items() if 0 in rows}
    if not errors:
        return MISSING, ""
    worst = max(errors, key=errors.get)
    return HOLDS if errors[worst] <= EXACT else FAILS, f"the largest error without noise is {number(errors[worst])} ({worst})"


def proportional(results):
    per_pixel = {scene: [error / noise for noise, error in rows.items() if noise] for scene, rows in
                 medians(results).items()}
    ratios = {scene: max(values) / min(values) for scene, values in per_pixel.items() if values}
    if not ratios:
        return MISSING, ""
    text = ", ".join(f"{scene} {number(ratio)}" for scene, ratio in ratios.items())
    return (HOLDS if max(ratios.values()) <= PROPORTION else FAILS,
            f"error per pixel of noise, most over least from 0.25 to 2 pixels: {text}")


CLAIMS = [
    Claim("With true rotations and without noise positions are exact (Theorem 2), to 1e-6", exact),
    Claim("With noise they are off in proportion to it", proportional),
]


def report(results):
    rows = [[scene, *(number(found[noise]) if noise in found else "" for noise in NOISES)]
            for scene, found in medians(results).items()]
    text = " ".join(__doc__.split("\n\n", 1)[1].split())
    head = ["", *(f"{noise:g} px" for noise in NOISES)]
    return text + f" Medians of {results.settings.position_seeds} seeds.\n\n" + (table(head, rows) if rows else "Not run.\n")
