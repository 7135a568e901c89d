"""One run of a solver in a process of its own, and whether an earlier one can stand for it."""

import hashlib
import json
import mmap
import os
import pathlib
import resource
import subprocess
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

from reproduce.logs import load

from .logs import Run

USABLE = (0, 4)  # raybundle ends with 4 where tolerances this tight stall; the log tells what counts
GRACE = 30  # seconds beyond one and a half times the limit, for an iteration that takes for ever


@dataclass
class Bounds:
    seconds: float
    iterations: int
    target: float = 0  # a run that has come to this cost is complete
    stop: float = 0  # Ceres ends once the cost is at most this


class Solver:
    """A program with its options."""

    def __init__(self, kind, program, options, environment):
        self.kind, self.program, self.options = kind, str(program), options.split()
        self.environment = environment

    def command(self, problem, log, threads, bounds):
        limits = ["--threads", threads, "--time-limit", f"{bounds.seconds:g}",
                  "--max-iterations", bounds.iterations]
        if self.kind == "ceres":
            words = [self.program, problem, "--output", log, "--stop-cost", repr(bounds.stop)]
        else:
            words = [self.program, "solve", problem, "-q", "--log", log]
        return [str(word) for word in [*words, *limits, *self.options]]

    def stamp(self, threads):
        """What a run depends on, bounds aside. The problem is that of the folder."""
        words = [program_hash(self.program), f"threads {threads}", *self.options,
                 *(f"{name}={value}" for name, value in sorted(self.environment.items()))]
        return " ".join(words)


HASHES = {}


def program_hash(program):
    if program not in HASHES:
        HASHES[program] = hashlib.sha256(pathlib.Path(program).read_bytes()).hexdigest()[:16]
    return HASHES[program]


def ensure(solver, problem, base, threads, bounds):
    """Runs it unless that has been done; returns whether it ran. `base`: of its files, no ending."""
    if stands(solver, base, threads, bounds):
        return False
    execute(solver, problem, base, threads, bounds)
    return True


def stands(solver, base, threads, bounds):
    """An earlier run that reached the target, or would come no further within these bounds."""
    run = Run(base)
    if run.outcome.get("stamp") != solver.stamp(threads):
        return False
    if bounds.target and run.least <= bounds.target or run.outcome["status"] == "failed":
        return True
    if run.outcome["status"] == "too long":
        return run.outcome["seconds"] >= bounds.seconds
    if run.outcome["stop"] and run.least <= run.outcome["stop"]:
        return False
    if run.end >= 0.98 * run.outcome["seconds"]:
        return run.outcome["seconds"] >= bounds.seconds
    return run.iterations < run.outcome["iterations"] or run.outcome["iterations"] >= bounds.iterations


def touch_memory(size):
    """Writes to so many bytes and frees them, so that all runs start alike: a virtual machine returns what has
    been free for a while to its host, and gets it back page by page, at seconds per GB; and huge pages have to
    be gathered after a run that left small ones."""
    if size <= 0:
        return
    piece = b"\1" * (1 << 20)
    with mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS) as memory:
        memory.madvise(mmap.MADV_HUGEPAGE)
        for _ in range(size // len(piece)):
            memory.write(piece)


def execute_together(solver, problem, bases, threads, bounds):
    """As many at once as there are bases."""
    with ThreadPoolExecutor(len(bases)) as together:
        list(together.map(lambda base: execute(solver, problem, base, threads, bounds), bases))


def execute(solver, problem, base, threads, bounds):
    base.parent.mkdir(parents=True, exist_ok=True)
    log, record = base.with_suffix(".json"), base.with_suffix(".run.json")
    for file in (log, record):
        file.unlink(missing_ok=True)
    start = time.monotonic()
    status, message = call(solver.command(problem, log, threads, bounds), solver.environment,
                           1.5 * bounds.seconds + GRACE)
    if status == "ok" and load(log) is None:
        status, message = "failed", "left no log"
    record.write_text(json.dumps({
        "stamp": solver.stamp(threads), "status": status, "message": message, "seconds": bounds.seconds,
        "iterations": bounds.iterations, "stop": bounds.stop, "wall": time.monotonic() - start}))


def call(command, environment, most):
    """("ok" | "failed" | "too long", the last line of what it complained about)"""
    try:
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                              errors="replace", timeout=most, env={**os.environ, **environment},
                              preexec_fn=limit_memory, check=False)
    except subprocess.TimeoutExpired:
        return "too long", f"ended after {most:.0f} s"
    lines = done.stderr.strip().splitlines()
    last = next((line for line in reversed(lines) if not line.startswith("  --")), "")
    return ("ok" if done.returncode in USABLE else "failed"), f"{done.returncode}: {last}"


def limit_memory():
    """A solver that needs more than the machine has fails, and takes nothing else with it."""
    most = int(0.92 * os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    resource.setrlimit(resource.RLIMIT_DATA, (most, most))
