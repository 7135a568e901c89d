"""What tools/reproduce asks of a paper: its options, its runs, its report."""

import dataclasses
import pathlib
import subprocess
import sys

from reproduce.logs import machine

from . import chapter3, chapter45, report
from .logs import Results
from .work import Settings, Work

TITLE = "Z. Qu, Efficient Optimization for Robust Bundle Adjustment"
TIME = "All of it takes about half an hour on two cores."
EXPERIMENTS = chapter3.EXPERIMENTS + chapter45.EXPERIMENTS
NAMES = [each.name for each in EXPERIMENTS]


def add_options(parser):
    parser.add_argument("--ladybug", metavar="FILE", type=pathlib.Path,
                        help="problem-49-7776-pre.txt of BAL [../shared/data/bal, else a look-alike scene]")
    parser.add_argument("--runs", metavar="N", type=int, default=1,
                        help="runs of each, of which the fastest counts [1]")


def run(args, program, probe, data):
    """Runs what is asked for; returns what the report has to know of it. `data`: where data sets are."""
    settings = Settings.quick() if args.quick else Settings()
    settings.runs = max(args.runs, 1)
    file, description = ladybug(args, program, data)
    work = Work(program, probe, args.output, settings, file)
    chosen = [each for each in EXPERIMENTS if not args.only or each.name in args.only]
    work.solves(chosen)
    work.measure(chosen)
    return {"ladybug": description, "settings": dataclasses.asdict(settings),
            "machine": machine(args.output), "load": work.loads}


def write(args, program, probe, meta):
    """The report; what could not be drawn, or nothing."""
    work = Work(program, probe, args.output, Settings(**meta["settings"]), None)
    return report.write(EXPERIMENTS, Results(args.output, work.settings), meta, work, args.docs)


def ladybug(args, program, data):
    """The file, and what the report says of it."""
    given = args.ladybug or data / "bal/problem-49-7776-pre.txt"
    if args.ladybug and not given.is_file():
        sys.exit(f"reproduce: {given}: no file")
    if given.is_file() and (args.ladybug or not args.quick):
        return given.resolve(), f"`{given.name}`"
    scene = args.output / "problems" / "look-alike.txt"
    scene.parent.mkdir(parents=True, exist_ok=True)
    counts = ["--cameras", "10", "--points", "200"] if args.quick else ["--cameras", "49", "--points", "7776"]
    command = ["generate", "street", *counts, "--seed", "1"]
    if not scene.is_file():  # a new file would make all runs be repeated
        subprocess.run([program, *command, "-o", scene], check=True, stdout=subprocess.DEVNULL)
    return scene.resolve(), f"a look-alike scene, `raybundle {' '.join(command)}`"
