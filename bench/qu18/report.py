"""The report: docs/results/qu18.md with its plots."""

from reproduce.claims import FAILS, HOLDS, MISSING, TIE, count, judged, number
from reproduce.text import claim_lines, failures, image, lines_plot, table, write_page

from .claims import digits_of
from .experiment import Row


def ratios(row):
    """Numbers as text, those of times with the ratio to the least of the row."""
    plain = [value for value in row if isinstance(value, (int, float))]
    low = min(plain, default=0)
    texts = []
    for value in row:
        if not isinstance(value, (int, float)):
            texts.append("" if value is None else str(value))
        else:
            texts.append(number(value) + (f" ({value / low:.2g})" if low > 0 and len(plain) > 1 else ""))
    return texts


def at_start(spec, results, quantity):
    """What the column of the thesis without a run of its own holds: the start."""
    data = results.probe("truth-" + spec.problem)
    if not data:
        return None
    return {"camera": data["truth"]["camera_rmse"], "point": data["truth"]["point_rmse"],
            "median": data["truth"]["point_median"], "cost": data["cost"]}.get(quantity)


def table_text(spec, results):
    runs = [results.run(spec.problem, name) if name else None for _, name in spec.columns]
    rows = []
    shown = [row.quantity for row in spec.rows]
    also = [Row(quantity, [None] * len(runs), label) for quantity, label in
            (("cost", "final cost"), ("gradient", "final gradient norm")) if quantity not in shown]
    for row in spec.rows + also:
        label = row.label or row.quantity
        with_ratio = row.quantity in ("per_solve", "total", "inner")
        digits = digits_of(row.quantity)
        shape = ratios if with_ratio else lambda cells, digits=digits: [
            number(c, digits) if isinstance(c, (int, float)) else (c or "") for c in cells]
        if any(value is not None for value in row.thesis):
            rows.append([label + ", thesis"] + shape(row.thesis))
        ours = [getattr(run, row.quantity) if run else None for run in runs]
        if not spec.columns[0][1]:
            ours[0] = at_start(spec, results, row.quantity)
        rows.append([label + ", ours"] + shape(ours))
    text = f"Table {spec.number}\n\n" + table([""] + [label for label, _ in spec.columns], rows)
    odd = [note for (label, name), run in zip(spec.columns, runs)
           if name and (note := remark(label, run, spec.problem, results))]
    return text + ("\n" + "; ".join(odd) + ".\n" if odd else "")


def remark(label, run, problem, results):
    """Why a run is shorter than asked for."""
    if run.outcome["status"] == "not run":
        return f"{label}: not run"
    if not run:
        return f"{label}: {run.outcome['status']} {run.outcome['message']}".strip()
    long = results.settings.steps if problem == "ladybug" else 0
    if run.failed or run.steps < long or run.status == "time_limit" and not long:
        return (f"{label}: {run.steps} steps, {run.rejected} rejected trials "
                f"({run.status.replace('_', ' ')})")
    return ""


def least_cost(figure, results):
    """Of all runs on the problem that minimise the same."""
    names = results.names(figure.problem)
    runs = [results.run(figure.problem, name) for name in names if not name.endswith("IRLS")]
    return min((run.log["summary"]["final_cost"] for run in runs if run), default=1.0)


def figure_plot(figure, results):
    """Costs are shown above the least found: as such, all curves look the same after a few steps."""
    series, best = [], least_cost(figure, results)
    for label, name, *dashed in figure.curves:
        run = results.run(figure.problem, name)
        if not run:
            continue
        x, y = run.curve(figure.x, figure.y)
        if figure.y == "cost":
            own = name.endswith("IRLS")
            base = min(y) if own else best
            y = [value / base - 1 for value in y]
            label += ", above its own least" if own else ""
        series.append({"name": label, "x": x, "y": y, "dashed": bool(dashed and dashed[0])})
    if not series:
        return None
    label = "seconds" if figure.x == "seconds" else "accepted steps"
    y = "cost / least cost found - 1" if figure.y == "cost" else "gradient norm"
    return lines_plot(figure.name, figure.caption, (label, y), series, log_y=True,
                      log_x=figure.x == "seconds")


def section(experiment, results, plots):
    text = f"## {experiment.title}\n\n"
    if experiment.extra:
        extra = experiment.extra(results)
        text += extra.text + "\n"
        for plot in extra.plots:
            plots.append(plot)
            text += image("qu18", plot["name"], plot["title"])
    for each in experiment.tables:
        text += table_text(each, results) + "\n"
    for figure in experiment.figures:
        plot = figure_plot(figure, results)
        if plot:
            plots.append(plot)
            text += image("qu18", figure.name, figure.caption)
        else:
            text += f"{figure.caption}: not run.\n\n"
    rows = judged(experiment.claims, results)
    text += claim_lines(rows)
    if experiment.note:
        text += "\n" + experiment.note + "\n"
    return text + "\n", rows


def heading(meta, counts):
    settings = meta["settings"]
    limits = ", ".join(f"{name} {seconds:g} s" for name, seconds in settings["limits"].items())
    loads = ", ".join(f"{name} {a:.1f} and {b:.1f}" for name, (a, b) in meta["load"].items())
    return f"""# The thesis reproduced

Every comparison of [Qu18] (Tables 3.1 to 5.4, Figures 3.1 to 5.19), with the thesis' numbers, ours, and whether
what it claims holds here. `tools/reproduce qu18` runs it all and writes this page; `--report-only`
writes it again from the runs that are there.

Of {sum(counts.values())} claims {counts[HOLDS]} hold, {counts[FAILS]} fail, {counts[TIE]} cannot be told
(no difference beyond 2 %, of costs 0.01 %, of gradient norms a factor of 1.5; a gradient norm below 1e-9 of that of
the start counts as vanished), {counts[MISSING]} were not run.

- Problem of chapters 3 and 4: {meta["ladybug"]}.
- Machine: {meta["machine"]}. The thesis' times are of Matlab on an i7-6600U: only order and
  ratios (in brackets, to the least of the row) can be compared.
- An iteration of the thesis is an accepted step: runs of chapters 3 and 4 have up to {settings["trials"]} trials (LMA-CD 130) and
  are read up to accepted step {settings["steps"]}, within {settings["ladybug_limit"]:g} s. Figures 5.6 and 5.7: up to {settings["long_trials"]} trials,
  the same limit. Balls: up to {settings["ball_trials"]} trials, within {limits}; one seed, noise of 1 pixel,
  no outliers.
- Runs of each: {settings["runs"]}, of which the fastest counts; {settings["threads"]} threads; load of the machine (1 is one core) before and
  after the runs of each problem: {loads}. More than {settings["threads"]} means that others disturbed the times.
- The methods as the thesis has them: additive poses unless local, no
  preconditioner unless said, PCG to min(0.1, |b|) |b|, at most 1000 inner iterations unless said.
  What it does not print is ours: damping 1 at the start (1e-4 with diag(H)), the length of the
  first step as first radius, the scale of the loss 1 pixel, per component.
- Cost is ½ Σ |r|² in pixels²; figures show it relative to the least cost that any run on the problem found. IRLS' cost is that of its loss and not compared with others'.
- Fluctuation of the gradient norm: the decades by which it rises, all rises added.
- Names: CD-C, CD-H, CD-B are LMA-CD with the points, nothing or the cameras eliminated; the options of every run are in
  `bench/qu18/variants.py` and in its log.

"""


def write(experiments, results, meta, work, docs):
    """Writes qu18.md and qu18/*.svg into `docs`; what could not be drawn, or nothing."""
    plots, rows, body = [], [], ""
    for each in experiments:
        text, claims = section(each, results, plots)
        body += text
        rows.append((each.title, claims))
    counts = count([row for _, claims in rows for row in claims])
    return write_page("qu18", heading(meta, counts) + failures(rows) + body, plots, work, docs)
