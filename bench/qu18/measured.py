"""What is measured without a solve, or looked at after one: text, tables and plots."""

import math
import random
import re

from reproduce.claims import FAILS, HOLDS, MISSING, number
from reproduce.text import lines_plot, table

from .experiment import Extra

NOT_RUN = Extra("Not run.\n")
KINDS = ("rotation", "translation", "focal", "k1", "k2", "point")


def taylor(results):
    data = results.probe("taylor")
    if not data:
        return NOT_RUN
    first = data["remainder"][0]
    ideal = [first * (tau / data["tau"][0]) ** 2 for tau in data["tau"]]
    plot = lines_plot("fig-3-01-taylor", "Remainder of the linearisation", ("tau", "norm"), [
        {"name": "remainder", "x": data["tau"], "y": data["remainder"]},
        {"name": "slope 2", "x": data["tau"], "y": ideal, "dashed": True}], log_x=True, log_y=True)
    return Extra(f"At a random point, along a random direction, the remainder has slope "
                 f"{data['slope']:.4f} (thesis: 2) until it meets rounding.\n", [plot])


def taylor_claim(results):
    data = results.probe("taylor")
    if not data:
        return MISSING, ""
    return (HOLDS if abs(data["slope"] - 2) < 0.02 else FAILS), f"slope {data['slope']:.4f}"


def found_increments(text):
    return [re.search(rf"--inc-{kind} (\S+)", text).group(1) for kind in KINDS]


def increments(results):
    data = results.probe("increments")
    if not data:
        return NOT_RUN
    # The print of (3.38) that we have lists twelve values beside damaged names.
    rows = [["thesis", "1e-8", "1e-5", "1e-3", "1e-7", "1e-7", "1e-8"]]
    rows += [[name] + found_increments(text) for name, text in data.items()]
    return Extra("The steps that approximate the derivatives best. The vector is damaged in our copy of "
                 "the thesis; the row is our reading of it. The thesis holds its vector to fit other data "
                 "sets as well. The search shows that it moves by orders of magnitude with the data, and "
                 "with it the ratios between its entries, which are what the scaling sees; the balls of "
                 "chapter 5 show what comes of a vector from elsewhere.\n\n"
                 + table(["", *KINDS], rows))


def matrix_forms(results):
    data = results.probe("matrix-forms")
    if not data:
        return NOT_RUN
    thesis = {"ES": (201, 7.31), "ES-sparse": (194, 3.02), "IS-sparse": (1.32, 2.84), "IS-cell": (0.37, 2.82)}
    ours = {each["form"]: each for each in data["forms"]}
    rows = []
    for name, (seconds, megabytes) in thesis.items():
        rows.append([name, seconds, number(ours[name]["seconds"]),
                     number(ours[name]["seconds"] / ours["IS-cell"]["seconds"]), megabytes,
                     number(ours[name]["bytes"] / 1e6)])
    return Extra(
        f"J is {data['rows']} x {data['columns']} (thesis: 14670 x 6720; which ten frames it drew is not "
        "said). ES: dense J, dense product. ES-sparse: dense J made sparse, sparse product. IS-sparse: "
        "sparse J from its blocks, sparse product. IS-cell: the blocks alone, E left as a product, as "
        "everywhere here. Time from the problem to H, evaluation of the derivatives included.\n\n"
        "Table 3.1\n\n"
        + table(["form", "thesis, s", "ours, s", "ours, over IS-cell", "thesis, MB", "ours, MB"], rows)
        + f"\nAll forms agree (relative difference of H {data['relative_difference']:.1g}).\n")


def forms_claim(key):
    def check(results):
        data = results.probe("matrix-forms")
        if not data:
            return MISSING, ""
        ours = {each["form"]: each[key] for each in data["forms"]}
        row = [ours[name] for name in ("ES", "ES-sparse", "IS-sparse", "IS-cell")]
        text = ", ".join(f"{name} {number(value)}" for name, value in ours.items())
        return (HOLDS if all(a >= b for a, b in zip(row, row[1:])) else FAILS), f"{key}: {text}"
    return check


def linear_solvers(results):
    data = results.probe("linear-solvers")
    if not data:
        return NOT_RUN
    time, difference = data["seconds"], data["difference"]
    return Extra(
        f"{data['systems']} systems of order {data['order']} along a solve on the sub-dataset, identity "
        f"damping; CG to 0.1 of the right-hand side, {data['cg_iterations']:.3g} steps on average, without "
        "forming S_C.\n\nTable 3.3\n\n"
        + table(["s per system", "CG", "Cholesky", "LU"],
                [["thesis", 0.322, 0.338, 0.348], ["ours"] + [number(t) for t in time]])
        + "\nTable 3.4, |p - q|² / s of (3.83)\n\n"
        + table(["", "CG and Cholesky", "CG and LU", "Cholesky and LU"],
                [["thesis", "0.010", "0.010", "0.000"], ["ours"] + [number(d) for d in difference]])
        + f"\nThe steps themselves have |p|² / s of {number(data['cholesky_step'])}; the steps of CG and of "
        f"Cholesky differ by {100 * data['relative_cg_cholesky']:.2g} % of their length on average.\n")


def cg_fastest(results):
    data = results.probe("linear-solvers")
    if not data:
        return MISSING, ""
    cg, cholesky, lu = data["seconds"]
    return (HOLDS if cg <= min(cholesky, lu) else FAILS), \
        f"CG {1e3 * cg:.3g} ms, Cholesky {1e3 * cholesky:.3g} ms, LU {1e3 * lu:.3g} ms"


def cg_inexact(results):
    data = results.probe("linear-solvers")
    if not data:
        return MISSING, ""
    a, b, c = data["difference"]
    return (HOLDS if c < 1e-6 * min(a, b) else FAILS), \
        f"CG differs by {number(a)} and {number(b)}, the decompositions by {number(c)}"


def conditions(results):
    run = results.run("ladybug", "ADINM3000-inc-I")
    if not run:
        return NOT_RUN
    trials = [t for t in run.trials[1:] if t["condition_points"] and t["condition_cameras"]]
    if not trials:
        return Extra("The log has no condition numbers.\n")
    picks = sorted({0, len(trials) // 4, len(trials) // 2, 3 * len(trials) // 4, len(trials) - 1})
    rows = [[trials[k]["iteration"], f"{trials[k]['damping']:.1e}", f"{trials[k]['condition_cameras']:.1e}",
             f"{trials[k]['condition_points']:.1e}", trials[k]["eliminated"]] for k in picks]
    return Extra("Condition numbers of the worst block of the damped B and C in ADINM:inc-I, unscaled. The "
                 "thesis speaks of more than 1e7 for C and of about 1e4 for B, which fits scaled unknowns.\n\n"
                 + table(["trial", "damping", "B", "C", "eliminated"], rows))


def normal_share(mean, deviation, bound):
    """Probability of |x| > bound."""
    def tail(z):
        return 0.5 * math.erfc(z / math.sqrt(2))
    return tail((bound - mean) / deviation) + tail((bound + mean) / deviation)


def distribution(values):
    mean = sum(values) / len(values)
    return mean, math.sqrt(sum((v - mean) ** 2 for v in values) / len(values))


def histogram(name, title, label, values, bins=80):
    mean, deviation = distribution(values)
    reach = 5 * deviation or 1.0
    width = 2 * reach / bins
    counts = [0] * bins
    for value in values:
        k = int((value - mean + reach) // width)
        if 0 <= k < bins:
            counts[k] += 1
    centres = [mean - reach + (k + 0.5) * width for k in range(bins)]
    scale = len(values) * width / (deviation * math.sqrt(2 * math.pi) or 1.0)
    gauss = [scale * math.exp(-0.5 * ((x - mean) / deviation) ** 2) for x in centres]
    series = [{"name": "frequency", "x": centres, "y": [c or None for c in counts]},
              {"name": "Gaussian", "x": centres, "y": [y if y > 0.1 else None for y in gauss],
               "dashed": True}]
    return lines_plot(name, title, (label, "frequency"), series, log_y=True)


def samples(results):
    """Residual components and gradient entries after ADINM, or None."""
    data = results.probe("residuals-adinm")
    if not data:
        return None
    components = [d for _, ox, oy, ux, uy in data["rows"] for d in (ux - ox, uy - oy)]
    return components, data["gradient"]


def shares(values, bound):
    return sum(abs(v) > bound for v in values) / len(values), normal_share(*distribution(values), bound)


def histograms(results):
    found = samples(results)
    if not found:
        return NOT_RUN
    components, gradient = found
    mean, deviation = distribution(components)
    _, spread = distribution(gradient)
    a, b = shares(components, 2)
    c, d = shares(gradient, 0.01)
    e, f = shares(gradient, 5 * spread)
    rows = [["residual component, |.| > 2", "1.60 %", "0.2 %", f"{100 * a:.2f} %", f"{100 * b:.2g} %"],
            ["gradient entry, |.| > 0.01", "0.45 %", "0.05 %", f"{100 * c:.2f} %", f"{100 * d:.2g} %"],
            ["gradient entry, |.| > 5 deviations", "", "", f"{100 * e:.2f} %", f"{100 * f:.2g} %"]]
    return Extra(
        f"After 50 steps of ADINM: residuals have mean {mean:.2g} and deviation {deviation:.3g} pixels, "
        f"entries of the gradient deviation {spread:.2g}. Gaussian: the share that one of the same mean "
        "and variance has there.\n\n"
        + table(["share of", "thesis", "thesis, Gaussian", "ours", "ours, Gaussian"], rows),
        [histogram("fig-4-05-residuals", "Residual components after ADINM", "pixels", components),
         histogram("fig-4-06-gradient", "Gradient entries after ADINM", "value", gradient)])


def tails_claim(which):
    def check(results):
        found = samples(results)
        if not found:
            return MISSING, ""
        values = found[which]
        bound = 2 if which == 0 else 5 * distribution(values)[1]
        share, gauss = shares(values, bound)
        return (HOLDS if share > 2 * gauss else FAILS), \
            f"{100 * share:.2f} % beyond {bound:.2g}, a Gaussian has {100 * gauss:.2g} %"
    return check


def image_plot(name, title, before, after, frame, most=250):
    """The observations (dots) joined to their projections, before on the left, after on the right."""
    reach = max((abs(x) for rows in (before, after) for c, *xy in rows if c == frame for x in xy[:2]),
                default=1)
    segments, dropped = [], 0
    for shift, rows in ((0, before), (2.3 * reach, after)):
        own = [row for row in rows if row[0] == frame]
        for _, ox, oy, ux, uy in own[::max(1, math.ceil(len(own) / most))]:
            if abs(ux) + abs(uy) > 4 * reach:
                dropped += 1  # far outside: it would only shrink the rest
                continue
            segments.append([ox + shift, oy, ux + shift, uy])
    if dropped:
        title += f" ({dropped} far outside not shown)"
    return {"kind": "segments", "name": name, "title": title, "x_label": "pixels; on the left before, on the right after",
            "y_label": "pixels", "segments": segments}


def mean_errors(rows):
    return math.sqrt(sum((ux - ox) ** 2 + (uy - oy) ** 2 for _, ox, oy, ux, uy in rows) / len(rows))


def reprojections(results):
    text, plots = "", []
    for figure, label, a, b in (("5.4", "Ladybug, two frames, 50 steps", "residuals-start", "residuals-dinm"),
                                ("5.5", "ball of 10 frames, 253 points, 1326 observations, 100 steps",
                                 "residuals-small-start", "residuals-small")):
        before, after = results.probe(a), results.probe(b)
        if not before or not after:
            text += f"Figure {figure}: not run.\n\n"
            continue
        frames = sorted({row[0] for row in before["rows"]})
        if figure == "5.4":
            frames = sorted(random.Random(1).sample(frames, 2))
        norms = [math.sqrt(sum(g * g for g in data["gradient"])) for data in (before, after)]
        text += (f"Figure {figure} ({label}): RMSE {mean_errors(before['rows']):.3g} -> "
                 f"{mean_errors(after['rows']):.3g} pixels, cost {number(before['cost'], 4)} -> "
                 f"{number(after['cost'], 4)}, gradient norm {number(norms[0])} -> {number(norms[1])}"
                 + (" (thesis: cost 2.44e5 -> 25.2, gradient norm 4.12e12 -> 6.53).\n\n" if figure == "5.5"
                    else ".\n\n"))
        for frame in frames:
            name = f"fig-{figure.replace('.', '-0')}-frame-{frame:02d}"
            plots.append(image_plot(name, f"Figure {figure}, frame {frame}", before["rows"],
                                    after["rows"], frame, 180 if figure == "5.4" else 120))
    return Extra(text, plots)


def fits_claim(a, b):
    def check(results):
        before, after = results.probe(a), results.probe(b)
        if not before or not after:
            return MISSING, ""
        first, last = mean_errors(before["rows"]), mean_errors(after["rows"])
        return (HOLDS if last < 0.5 * first else FAILS), f"RMSE {first:.3g} -> {last:.3g} pixels"
    return check


def flat(x, y, z):
    """A view along (1, 1, 1)."""
    return [(x - y) / math.sqrt(2), (2 * z - x - y) / math.sqrt(6)]


def diagram(name, figure):
    def extra(results):
        data = results.probe("geometry-" + name)
        if not data:
            return NOT_RUN
        def places(key):
            v = data[key]
            return [flat(*v[i:i + 3]) for i in range(0, len(v), 3)]
        cameras, points = places("cameras"), places("points")
        points = points[::max(1, math.ceil(len(points) / 300))]
        every = max(1, math.ceil(len(cameras) / 120))
        cameras = cameras[::every]
        segments = [[*p, *p] for p in points] + [[*a, *b] for a, b in zip(cameras, cameras[1:])]
        chapter, place = figure.split(".")
        plot = {"kind": "segments", "name": f"fig-{chapter}-{int(place):02d}-scene",
                "title": f"Figure {figure}: some points, and the cameras' centres joined in their order"
                + (f", every {every}th" if every > 3 else " (every second)" if every == 2 else ""),
                "x_label": "", "y_label": "", "segments": segments}
        plots = [plot]
        if name == "sphere-100":  # Figure 5.2 shows such a scene, too
            plots.insert(0, {**plot, "name": "fig-5-02-scene",
                             "title": plot["title"].replace(figure, "5.2")})
        scene, start = results.probe("truth-" + name) or {}, ""
        if scene:
            truth, sizes = scene["truth"], scene["problem"]
            start = (f"{sizes['cameras']} frames, {sizes['points']} points, {sizes['observations']} "
                     f"observations; at the start RMSE of the cameras {number(truth['camera_rmse'])}, of "
                     f"the points {number(truth['point_rmse'])}, cost {number(scene['cost'])}.\n")
        return Extra(start, plots)
    return extra
