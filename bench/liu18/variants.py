"""The methods of [Liu18, Section 4] as options of `raybundle solve`, and the data they ran on."""

from dataclasses import dataclass

# Lenses are known; every method starts from the same poses and from points taken from their rays. No
# tolerance is printed; this one lets the slow ones go on through their long flat valleys. A radius that is far
# too large at first is halved many times in a row.
COMMON = {"lens": "fixed", "point-start": "rays", "gradient-tolerance": "0", "parameter-tolerance": "0",
          "function-tolerance": "1e-8", "max-consecutive-failures": "100"}
RAYS = "--points pmba --objective ray --ray-weight unit"
POINTS = {"PMBA": RAYS, "PBA": "--points pba", "IDP": "--points idp", "XYZ": "--points xyz"}
# Every point takes its part of a step, as in the paper.
SOLVERS = {"DL": "--method dogleg --point-steps all", "LM": "--method lm-cholesky"}
# Our own defaults: rays weighted to pixels, and points that a step makes worse stay.
OWN = {"PMBA-own": "--points pmba --objective ray --method dogleg"}
METHODS = {f"{points}-{solver}": f"{POINTS[points]} {SOLVERS[solver]}"
           for points, solver in (("PMBA", "DL"), ("PBA", "LM"), ("IDP", "LM"), ("XYZ", "LM"),
                                  ("PMBA", "LM"), ("PBA", "DL"), ("IDP", "DL"), ("XYZ", "DL"))} | OWN
# What the paper lists: DL for PMBA, LM for the others.
PAPER_METHODS = {"PMBA": "PMBA-DL", "PBA": "PBA-LM", "IDP": "IDP-LM", "XYZ": "XYZ-LM"}


@dataclass
class Published:
    """A row of [Liu18, Table 4]; chi2 is half the sum of squared pixels."""
    solves: int
    iterations: int
    chi2: float
    seconds: float


@dataclass
class DataSet:
    name: str
    title: str
    limit: float  # seconds of each run
    folder: str = ""  # in ParallaxBA's format; else a scene, the preset of this name
    counts: str = ""  # of the paper, for a scene
    note: str = ""  # on the data
    published: tuple = ()  # in the order of PAPER_METHODS
    authors: str = ""  # what ParallaxBA 1.0 does with the same file
    scale: float = 1  # of a scene, that a whole run takes less than an hour
    small: bool = False  # a scene that is never made smaller


def rows(*numbers):
    return tuple(Published(*each) for each in numbers)


# Of the scenes: far enough off that some of the far features start on the wrong side of infinity.
START = "--start-rotation 0.005 --start-position 0.01"
FAKE_PILE = rows((9, 9, 1.7e2, 0.7), (23, 23, 1.7e2, 1.9), (104, 102, 1.7e2, 6.0), (116, 108, 1.2e3, 4.7))
DATA_SETS = [
    DataSet("fake-pile", "Fake-pile, the public one", 30, folder="fake-pile", published=FAKE_PILE,
            note="The paper's table has 135 / 12,741 / 53,878, but its chi2 of 1.7E+2 is half the authors' Σ here.",
            authors="LM 21 / 20, Σ/n 506.1 to 0.01321183; GN 8 / 8, the same"),
    DataSet("fake-pile-135", "A scene with the counts of Fake-pile", 30, small=True,
            counts="135 / 12,741 / 53,878", published=FAKE_PILE),
    DataSet("malaga", "Malaga", 100, folder="Malaga",
            note="The counts that the paper's table has for it are those of Village.",
            published=rows((44, 31, 9.1e3, 21.6), (64, 47, 9.1e3, 35.4), (230, 170, 5.8e5, 93.8),
                           (110, 85, 3.3e5, 39.0)),
            authors="LM 80 / 61, Σ/n 337.457532 to 0.10920870, at or below 0.1093 from iteration 46; "
                    "GN NaN from iteration 1 on"),
    DataSet("village", "A scene with the counts of Village", 100, counts="90 / 305,719 / 779,268",
            published=rows((12, 12, 3.3e4, 31.8), (13, 13, 3.3e4, 36.0), (19, 19, 3.3e4, 35.2),
                           (18, 18, 3.3e4, 26.3))),
    DataSet("college", "A scene with the counts of College", 100, scale=0.5,
            counts="468 / 1,236,502 / 3,107,524",
            published=rows((33, 33, 1.1e6, 334.4), (31, 31, 1.1e6, 370.5), (34, 34, 1.1e6, 255.3),
                           (295, 193, 1.0e7, 1361.0))),
    DataSet("victoria-cottage", "A scene with the counts of Victoria-cottage", 90,
            counts="400 / 153,632 / 890,057",
            published=rows((19, 16, 1.1e6, 70.5), (88, 66, 1.2e6, 301.4), (49, 48, 1.1e6, 157.9),
                           (47, 44, 1.2e6, 124.3))),
    DataSet("usyd-mainquad", "A scene with the counts of Usyd-Mainquad", 90, scale=0.5,
            counts="424 / 227,615 / 1,607,082",
            published=rows((25, 25, 2.4e6, 214.5), (101, 57, 3.6e6, 642.6), (301, 191, 4.6e6, 1994.7),
                           (76, 58, 2.8e6, 423.7))),
]
# [Liu18, Table 3]: the condition number of H_FF at iterations 0 to 3, and the final error.
TABLE_3 = {"PMBA": ["9.74", "5.68", "8.80", "5.74", "2.58E-3"],
           "PBA": ["1.46E+4", "1.46E+4", "1.46E+4", "1.46E+4", "5.37E-2"],
           "XYZ": ["1.22E+94", "1.22E+94", "1.22E+94", "3.53E+95", "3.43E-2"]}
