"""What tools/reproduce asks of a paper: its options, its runs, its report."""

import dataclasses
import pathlib

from reproduce.logs import machine

from . import report
from .initial import SOURCES
from .logs import Results
from .variants import DATA_SETS
from .work import Settings, Work

TITLE = "L. Liu et al., Parallax Bundle Adjustment on Manifold with Improved Global Initialization"
TIME = "All of it takes about 40 minutes."
INITIAL = {"init-" + each.name: each for each in SOURCES}
NAMES = ["four-poses", *(each.name for each in DATA_SETS), "streets", *INITIAL, "init-scenes", "theorem-2", "madrid"]


def add_options(parser):
    parser.add_argument("--data", metavar="FOLDER", type=pathlib.Path,
                        help="where the folders Malaga and fake-pile of ParallaxBA are "
                             "[../shared/data/parallaxba; what is not there is not run]")


    parser.add_argument("--scale", metavar="X", type=float, default=1,
                        help="size of the larger scenes, times that of a whole run [1]")


def run(args, program, probe, data):
    """Runs what is asked for; returns what the report has to know of it. `data`: where data sets are."""
    settings = Settings.quick() if args.quick else Settings()
    for data_set in DATA_SETS:
        settings.scales[data_set.name] *= 1 if data_set.small else args.scale
    work = Work(program, probe, args.output, settings, args.data or data / "parallaxba")
    wanted = args.only or NAMES
    if "four-poses" in wanted:
        work.simulate()
    for data_set in DATA_SETS:
        # A test runs on scenes alone, wherever it is.
        if data_set.name in wanted and not (args.quick and data_set.folder and not args.data):
            work.solve(data_set)
    if "streets" in wanted:
        work.drive()
    for name, source in INITIAL.items():
        # Two of the scenes are enough for a test.
        if name in wanted and (not args.quick or source.name in ("sphere", "trafalgar-126")):
            work.initialise(source.name)
    if "init-scenes" in wanted:
        work.initialise_small()
    if "theorem-2" in wanted:
        work.place()
    if "madrid" in wanted and not args.quick:
        work.average()
    return {"settings": dataclasses.asdict(settings), "machine": machine(args.output), "load": work.loads}


def write(args, program, probe, meta):
    """The report; what could not be drawn, or nothing."""
    settings = Settings(**meta["settings"])
    work = Work(program, probe, args.output, settings)
    return report.write(Results(args.output, settings), meta, work, args.docs)
