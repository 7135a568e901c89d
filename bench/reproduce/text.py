"""Markdown of a report, and the specifications of its plots."""

import shutil

from .claims import FAILS


def table(head, rows):
    lines = ["| " + " | ".join(str(cell) for cell in row) + " |" for row in [head] + rows]
    lines.insert(1, "|---" + "|--:" * (len(head) - 1) + "|")
    return "\n".join(lines) + "\n"


def lines_plot(name, title, labels, series, **more):
    return {"kind": "lines", "name": name, "title": title, "x_label": labels[0],
            "y_label": labels[1], "series": series, **more}


def image(paper, name, title):
    return f"![{title}]({paper}/{name}.svg)\n\n"


def claim_lines(rows):
    return "".join(f"- **{verdict}**: {claim}" + (f". {capital(sentence)}" if sentence else "") + ".\n"
                   for claim, verdict, sentence in rows)


def failures(rows):
    """`rows`: (title of the section, its claims)."""
    text = "## What does not hold\n\n"
    for title, claims in rows:
        for claim, verdict, sentence in claims:
            if verdict == FAILS:
                text += f"- {title.split(' (')[0]}: \"{claim}\". {capital(sentence)}.\n"
    return text + "\n"


def capital(sentence):
    return sentence[:1].upper() + sentence[1:]


def write_page(paper, text, plots, runs, docs):
    """Draws all plots and writes the page and its pictures into `docs`; what could not be drawn."""
    complaint = runs.draw(plots)
    target = docs / paper
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for plot in plots:
        drawn = runs.folder / "plots" / (plot["name"] + ".svg")
        if drawn.is_file():
            shutil.copyfile(drawn, target / drawn.name)
    (docs / (paper + ".md")).write_text(text)
    return complaint
