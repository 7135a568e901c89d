"""Rotation averaging on relative rotations of photographs (1DSfM's Madrid_Metropolis)."""

from reproduce.claims import FAILS, HOLDS, MISSING, Claim, number
from reproduce.logs import load
from reproduce.text import table

FILE = "rotavg/Madrid_Metropolis/EGs.txt"
STAGES = {"tree": "along a spanning tree", "chordal": "chordal start", "before": "averaged",
          "after": "pruned and averaged again"}


class Averaging:
    """A part of Work."""

    def average(self):
        given, log = self.data.parent / FILE, self.folder / "madrid.json"
        stamp, stamped = self.hash(), self.folder / "madrid.stamp"
        if not given.is_file() or (stamped.is_file() and stamped.read_text() == stamp):
            return
        self.run([self.program, "rotations", given, "--log", log])
        stamped.write_text(stamp)


def log(results):
    return load(results.folder / "madrid.json")


def converges(results):
    found = log(results)
    if not found:
        return MISSING, ""
    before, after = (found["angles"][stage]["median"] for stage in ("chordal", "after"))
    good = after < 0.5 * before and found["known"] > 0.9 * found["images"]
    return (HOLDS if good else FAILS, f"median disagreement {number(before)} degrees at the chordal start, {number(after)} in the "
            f"end, {found['known']} of {found['images']} images")


CLAIMS = [Claim("Rotation averaging converges on Madrid_Metropolis: the median halves, nine of ten images stay", converges)]


def report(results):
    found = log(results)
    if not found:
        return "Not run.\n"
    rows = [[title, *(number(found["angles"][stage][what]) for what in ("mean", "median", "upper_decile", "largest"))]
            for stage, title in STAGES.items()]
    return (f"`raybundle rotations EGs.txt`: {found['images']} images, {found['pairs']:,} pairs, of which "
            f"{found['pruned']:,} are off by more than {number(found['prune'])} degrees and left out; {found['known']} images stay; "
            f"{found['iterations']} iterations, {number(found['seconds'])} s. How far pairs are from the rotations, degrees:\n\n"
            + table(["", "mean", "median", "nine of ten below", "largest"], rows))
