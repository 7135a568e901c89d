"""The report: docs/results/liu18.md with its plots."""

import statistics

from reproduce.claims import FAILS, HOLDS, MISSING, TIE, count, judged, number
from reproduce.text import claim_lines, failures, image, lines_plot, table, write_page

from . import claims, four_poses, initial, madrid, streets, theorem_2
from .variants import COMMON, DATA_SETS, METHODS, PAPER_METHODS, START, TABLE_3


def blank(value, digits=3):
    return "" if value is None else number(value, digits)


def simulation(results):
    rows = []
    for points, method in PAPER_METHODS.items():
        run = results.simulated(method)
        if not run:
            return "Not run.\n"
        if points in TABLE_3:
            rows.append([points + ", paper", *TABLE_3[points], "", ""])
        ours = [blank(each) for each in run.conditions[:4]]
        draws = results.draws(method)
        rows.append([f"{method}, ours", *ours, *[""] * (4 - len(ours)), number(run.chi2, 5),
                     *(number(statistics.median(getattr(draw, what) for draw in draws))
                       for what in ("camera", "point"))])
    setting = " ".join(four_poses.__doc__.split("\n\n", 1)[1].split())
    return (setting + "\n\nPMBA minimises rays with Dogleg, the others pixels with LM. The condition number is the "
            "largest over the smallest eigenvalue of the undamped H_FF at accepted iterations; a method without "
            "four of them had trials rejected. What the paper's final error measures it does not say; ours are "
            "chi2 in pixels and, as the median of all draws of the noise, the RMSE of the camera centres and "
            "the median error of the points, in steps.\n\nTable 3\n\n"
            + table(["", "iteration 0", "1", "2", "3", "final chi2", "cameras", "points"], rows))


def method_row(data_set, method, results, bound):
    run = results.run(data_set.name, method)
    names = list(PAPER_METHODS.values())
    published = None
    if data_set.published and method in names:
        published = data_set.published[names.index(method)]
    paper = ["", "", ""] if not published else [
        f"{published.solves} / {published.iterations}", f"{published.chi2:.1e}", f"{published.seconds:g}"]
    if not run:
        return [method, *paper, *[""] * 7, run.termination, ""]
    return [method, *paper, f"{run.solves} / {run.iterations}", run.trials, number(run.chi2, 7),
            f"{run.mse:.6g}", number(run.seconds), number(run.first_below(bound)),
            number(run.seconds_to(bound)), run.termination, blank(run.camera)]


def data_set_text(data_set, results, plots):
    if not results.runs(data_set.name, METHODS):
        return f"### {data_set.title}\n\nNot run.\n\n"
    bound = claims.SAME * claims.least_chi2(results, data_set.name)
    rows = [method_row(data_set, method, results, bound) for method in METHODS]
    head = ["", "paper: solves / iterations", "paper: chi2", "paper: s", "solves / iterations", "trials",
            "chi2", "Σ/n", "s", "iterations to 1.01", "s to 1.01", "ended by", "RMSE of cameras"]
    title = f"Figure 8: chi2 over iterations, {data_set.title}"
    plot = curves(data_set, results, title)
    plots.append(plot)
    return (f"### {data_set.title}\n\n{about(data_set, results)}\n\n{table(head, rows)}\n"
            + image("liu18", plot["name"], title))


def about(data_set, results):
    first = next(iter(results.runs(data_set.name, METHODS).values()))
    problem = first.log["problem"]
    text = (f"{problem['cameras']} poses, {problem['points']:,} features, {problem['observations']:,} "
            f"observations; Σ/n at the start {2 * first.start / problem['observations']:.7g}. ")
    if data_set.folder:
        text += f"{data_set.note} The authors' ParallaxBA 1.0, PBA and pixels (solves / iterations): {data_set.authors}."
    else:
        scale = results.settings.scales[data_set.name]
        words, part = (f" --scale {scale}", f", times {scale}") if scale != 1 else ("", "")
        text += (f"`raybundle generate {data_set.name} --true-lenses {START}{words}`: only the counts "
                 f"({data_set.counts}{part}) are the paper's.")
    start = results.start_camera(data_set.name)
    return text + (f" RMSE of the cameras at the start {number(start)}." if start is not None else "")


def curves(data_set, results, title):
    series = []
    for method, run in results.runs(data_set.name, METHODS).items():
        x, y = run.curve()
        series.append({"name": method, "x": x, "y": y, "dashed": method not in PAPER_METHODS.values()})
    return lines_plot(f"fig-8-{data_set.name}", title, ("accepted iterations", "chi2"), series, log_y=True)


def heading(meta, counts):
    settings = meta["settings"]
    loads = ", ".join(f"{name} {a:.1f} and {b:.1f}" for name, (a, b) in meta["load"].items())
    common = " ".join(f"--{name} {value}" for name, value in COMMON.items())
    return f"""# Parallax bundle adjustment reproduced

Tables 3 to 5 and Figures 8 and 9 of [Liu18], with the paper's numbers, ours, and whether what it claims holds here;
and what becomes of each way to describe points on many small scenes. `tools/reproduce liu18` runs it all and
writes this page; `--report-only` writes it again from the runs that are there.

Of {sum(counts.values())} claims {counts[HOLDS]} hold, {counts[FAILS]} fail, {counts[TIE]} cannot be told (a difference below 2 %),
{counts[MISSING]} were not run.

- PMBA: points by parallax on the manifold, rays weighted alike; PBA, IDP, XYZ: pixels. DL: Dogleg, LM: Levenberg
  and Marquardt with Cholesky. The paper lists PMBA with DL and the others with LM. PMBA-own: with our
  own defaults, Dogleg, rays weighted to pixels, and `--point-steps better`.
- All with `{common}`, up to {settings["trials"]} iterations; one seed.
- chi2 is half the sum Σ of the squared pixel residuals: that is what the paper's 9.1E+3 for Malaga is, beside the
  authors' own Σ/n of 0.1092. Σ/n: per observation.
- Solves: factorisations of the reduced camera system; iterations: accepted ones; trials: rejected ones too.
- "To 1.01": until chi2 is at most 1.01 times the least that any method found.
- RMSE of cameras: of their centres after alignment, in units of the truth (scenes: a step from image to image).
- Machine: {meta["machine"]}; {settings["threads"]} thread, as in the paper, whose times are of an Intel i7. Load of the machine (1 is
  one core) before and after the runs of each data set: {loads or "none"}. Well above 1, others disturbed the times.

"""


def write(results, meta, work, docs):
    plots, sections = [], []
    sections.append(("Problem features in a simulation (Table 3)", simulation(results) + "\n",
                     judged(claims.SIMULATION, results)))
    body = "".join(data_set_text(each, results, plots) for each in DATA_SETS)
    sections.append(("Convergence (Table 4, Figure 8)", body, judged(claims.CONVERGENCE, results)))
    sections.append(("Global initialisation (Table 5, Figure 9)", initial.report(results, plots) + "\n",
                     judged(initial.CLAIMS, results)))
    sections.append(("Positions from true rotations (Theorem 2)", theorem_2.report(results) + "\n",
                     judged(theorem_2.CLAIMS, results)))
    sections.append(("Averaged rotations", madrid.report(results) + "\n", judged(madrid.CLAIMS, results)))
    sections.append(("Street scenes with far and collinear points", streets.report(results) + "\n", []))
    counts = count([row for _, _, rows in sections for row in rows])
    text = heading(meta, counts) + failures([(title, rows) for title, _, rows in sections])
    for title, own, rows in sections:
        text += f"## {title}\n\n{claim_lines(rows)}\n{own}" if rows else f"## {title}\n\n{own}"
    return write_page("liu18", text.rstrip() + "\n", plots, work, docs)
