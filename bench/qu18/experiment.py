"""How a comparison of the thesis is written down."""

from dataclasses import dataclass, field


@dataclass
class Row:
    quantity: str  # of logs.Run
    thesis: list  # numbers, or text such as "> 5000"; None: not printed
    label: str = ""


@dataclass
class Table:
    number: str
    columns: list  # (label of the thesis, name of the variant; None: only in the thesis)
    rows: list
    problem: str = "ladybug"


@dataclass
class Figure:
    number: str
    y: str  # "cost" or "gradient_norm"
    curves: list  # (label, name of the variant), dashed ones with a third entry True
    x: str = "steps"  # or "seconds"
    problem: str = "ladybug"

    @property
    def name(self):
        chapter, place = self.number.split(".")
        return f"fig-{chapter}-{int(place):02d}-{'cost' if self.y == 'cost' else 'gradient'}"

    @property
    def caption(self):
        what = "cost above the least" if self.y == "cost" else "gradient norm"
        return f"Figure {self.number}: {what} over {'accepted steps' if self.x == 'steps' else 'seconds'}"


@dataclass
class Experiment:
    name: str
    title: str
    problem: str = "ladybug"
    tables: list = field(default_factory=list)
    figures: list = field(default_factory=list)
    claims: list = field(default_factory=list)
    note: str = ""
    probes: list = field(default_factory=list)  # names of measurements
    extra: object = None  # results -> Extra, for what is no table of runs

    def variants(self):
        """Names of the runs it needs."""
        names = [name for table in self.tables for _, name in table.columns if name]
        names += [curve[1] for figure in self.figures for curve in figure.curves]
        return list(dict.fromkeys(names))


@dataclass
class Extra:
    """Text, and the plots it shows as specifications for the probe."""
    text: str
    plots: list = field(default_factory=list)


def pair(numbers, curves, **more):
    """The usual two figures: cost and gradient norm."""
    return [Figure(number, y, curves, **more)
            for number, y in zip(numbers, ("cost", "gradient_norm"))]
