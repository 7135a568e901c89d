"""What tools/reproduce asks of a subject: its options, its runs, its report."""

import dataclasses
import os
import pathlib
import sys

from . import machine, report
from .logs import Results
from .problems import FAR, PROBLEMS
from .variants import processor_value
from .work import Settings, Work

TITLE = "Speed and memory beside Ceres"
TIME = "All of it takes about two hours on two cores, nearly all of them Ceres'."
TARGETS = ["bench_ceres", "bench_micro"]  # of the build, where there are such
NAMES = [*(each.name for each in PROBLEMS + FAR), "growth", "largest", "machine"]


def add_options(parser):
    parser.add_argument("--data", metavar="FOLDER", type=pathlib.Path,
                        help="with the folders bal and parallaxba [../shared/data; what is not there is not run]")
    parser.add_argument("--ceres", metavar="FILE", type=pathlib.Path,
                        help="bench_ceres, the driver of Ceres [of the same build as the program]")
    parser.add_argument("--skip-ceres", action="store_true", help="without Ceres")
    parser.add_argument("--native", metavar="FILE", type=pathlib.Path,
                        help="the program built with -march=native, to compare with the portable one")
    parser.add_argument("--machine", metavar="FILE", type=pathlib.Path,
                        help="what bench_micro wrote with --benchmark_out [it is run, where it was built]")
    parser.add_argument("--runs", metavar="N", type=int, default=3, help="rounds of interleaved runs [3]")
    parser.add_argument("--threads", metavar="N", type=int, nargs="+", default=[1, 2],
                        help="numbers of threads [1 2]")
    parser.add_argument("--scale", metavar="X", type=float, default=1, help="size of the generated scenes [1]")
    parser.add_argument("--limit", metavar="S", type=float, default=150,
                        help="seconds of each run that finds out what a solver can do [150]")


def run(args, program, probe, data):
    """Runs what is asked for; returns what the report has to know of it. `data`: where data sets are."""
    settings = Settings.quickly() if args.quick else Settings(max(args.runs, 1), limit=args.limit)
    settings.threads, settings.scale = sorted(set(args.threads)), args.scale
    ceres = None if args.skip_ceres else args.ceres or pathlib.Path(program).parent.parent / "bench/bench_ceres"
    if ceres and not ceres.is_file():
        print(f"reproduce: no Ceres driver {ceres}: going on without", file=sys.stderr)
        ceres = None
    work = Work(program, probe, args.output, settings, args.data or data, ceres, args.native)
    wanted = args.only or NAMES
    for problem in PROBLEMS:
        if problem.name in wanted:
            work.measure(problem)
    for problem in FAR:
        if problem.name in wanted:
            work.measure_far(problem)
    if "growth" in wanted:
        work.grow()
    if "largest" in wanted:
        work.largest()
    micro, file = pathlib.Path(program).parent.parent / "bench/bench_micro", args.output / "machine.json"
    if "machine" in wanted and micro.is_file() and not args.machine and not args.quick:
        machine.measure(micro, file)
    processor = f"{processor_value('model name') or 'unknown processor'}, {os.cpu_count()} cores"
    return {"settings": dataclasses.asdict(settings), "machine": processor, "load": work.loads}


def write(args, program, probe, meta):
    """The report; what could not be drawn, or nothing."""
    settings = Settings(**meta["settings"])
    work = Work(program, probe, args.output, settings)
    rates = machine.rates(args.machine or args.output / "machine.json")
    return report.write(Results(args.output, settings.threads, rates), settings, meta, work, args.docs)
