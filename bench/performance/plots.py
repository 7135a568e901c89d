"""Plots of the report, as specifications for the probe."""

import math

from reproduce.text import lines_plot

from .claims import MEAN, SINGLE, slope
from .logs import TARGETS
from .variants import AUTO, CERES

NOTHING = 1e-6  # above the best, where a course ends


def speed_ups(results, threads):
    names = [name for name in results.names if results.speed_up(name, threads, TARGETS[0])]
    if not names:
        return None
    series = []
    for factor in TARGETS:
        values = [results.speed_up(name, threads, factor) for name in names]
        series.append({"name": f"to {factor} of the best", "y": [each and each[0] for each in values]})
    return {"kind": "bars", "name": f"speed-up-{threads}",
            "title": f"Times faster than Ceres' best variant, {threads} thread{'s' * (threads > 1)}",
            "y_label": "Ceres' time / raybundle's", "groups": names, "series": series, "log_y": True,
            "levels": [1, SINGLE, MEAN]}


def course(results, name, title, threads):
    """Cost above the best over time; of Ceres every variant that was tried."""
    best, runs = results.best(name), {"raybundle": results.run(name, "explore", AUTO)}
    unit = runs["raybundle"].seconds_to(TARGETS[-1] * best)
    if math.isinf(unit):
        unit = runs["raybundle"].end
    for variant, run in results.screened(name, threads, CERES).items():
        runs["Ceres " + variant] = run
    series = []
    for label, run in runs.items():
        kept = [each for each in run.kept if each["seconds"] > 0]
        end = next((k for k, each in enumerate(kept) if each["cost"] <= (1 + NOTHING) * best), len(kept))
        kept = kept[:end + 1]
        series.append({"name": label, "x": [each["seconds"] / unit for each in kept],
                       "y": [each["cost"] / best - 1 for each in kept], "dashed": label != "raybundle"})
    return lines_plot(f"course-{name}", f"{title}: cost above the best, {threads} thread{'s' * (threads > 1)}",
                      ("time / raybundle's to 1.001", "cost / best - 1"), series, log_x=True, log_y=True)


def growth(results):
    points = results.growth()
    if len(points) < 2:
        return None
    (x0, y0, _), exponent = points[0], slope(points)
    x, y = [each[0] for each in points], [each[1] / y0 for each in points]
    return lines_plot("growth", "Time of an outer iteration over the length of a street",
                      ("observations", "time / that of the shortest"), [
                          {"name": f"measured, exponent {exponent:.3f}", "x": x, "y": y},
                          {"name": "exponent 1", "x": x, "y": [each / x0 for each in x], "dashed": True}],
                      log_x=True, log_y=True)
