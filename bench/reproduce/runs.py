"""Runs programs into a folder; what is there already is not repeated by `raybundle bench`."""

import json
import os
import subprocess
import sys


def words(options):
    return " ".join(f"--{name} {value}" for name, value in options.items())


class Runs:
    def __init__(self, program, probe, folder):
        self.program, self.probe_program, self.folder = str(program), str(probe), folder
        self.loads = {}  # of the machine, before and after the runs on each problem
        folder.mkdir(parents=True, exist_ok=True)

    def call(self, *arguments, **more):
        return subprocess.run([str(a) for a in arguments], check=True, text=True, **more)

    def bench(self, problem, source, chosen, common, limit, threads, runs=1):
        """One call of `raybundle bench`; it carries on when single runs could not be carried out.
        `source`: ["FILE[:TRUTH]"] or ["--scene", "WORDS"]."""
        command = [self.program, "bench", "-o", self.folder / problem, "--ceres", "none",
                   "--runs", runs, "--threads", threads, "--time-limit", limit, "--common", words(common)]
        command += [*source[:-1], f"{problem}={source[-1]}"]
        for name, options in chosen.items():
            command += ["--variant", f"{name}={options}"]
        before = os.getloadavg()[0]
        code = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL).returncode
        self.loads[problem] = [before, os.getloadavg()[0]]
        if code not in (0, 1):
            sys.exit(f"reproduce: raybundle bench ended with {code} on {problem}")

    def draw(self, plots):
        """Draws all plots; the complaint of the program, or nothing."""
        folder = self.folder / "plots"
        folder.mkdir(exist_ok=True)
        specification = self.folder / "plots.json"
        specification.write_text(json.dumps(plots))
        done = subprocess.run([self.probe_program, "draw", str(specification), "-o", str(folder)],
                              text=True, capture_output=True)
        return "" if done.returncode == 0 else done.stderr.strip()
