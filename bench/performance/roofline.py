"""The kernels beside what the machine can do: runs bench_micro and reads what it found.

Of each kernel bench_micro knows the bytes that must be moved and the flops of its formulas (derivations
in bench/micro/work.cc), and of the machine, in the same run, the STREAM triad (GB/s) and the peak of
multiplications and additions (GFlop/s), with one thread and with two. The roof of a kernel is the
shorter of the times that its bytes and its flops would take at those rates.
"""

import json
import re
import statistics
import subprocess

MACHINE = ("triad_1", "triad_2", "peak_1", "peak_2")
NAME = re.compile(r"([^/]+)/(observations|order):(\d+)/threads:(\d+)")
SECONDS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def measure(program, output, repetitions=3, pattern="."):
    """Runs bench_micro, which writes JSON to `output`; returns what load() would."""
    done = subprocess.run([str(program), f"--benchmark_out={output}", "--benchmark_out_format=json",
                           f"--benchmark_repetitions={repetitions}", f"--benchmark_filter={pattern}"],
                          check=False, capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"{program} ended with {done.returncode}: {done.stderr.strip()}")
    return load(output)


def load(path):
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def machine(data):
    """{"triad_1": GB/s, "triad_2": ..., "peak_1": GFlop/s, "peak_2": ...}"""
    return {name: float(data["context"][name]) for name in MACHINE}


def gains(data):
    """What two threads gain over one on this machine: {"triad": ..., "peak": ...}"""
    most = machine(data)
    return {kind: most[kind + "_2"] / most[kind + "_1"] for kind in ("triad", "peak")}


def kernels(data):
    """One dictionary per kernel, size and number of threads, in the order of the run: kernel, measure
    ("observations" or "order"), size, threads, and medians of seconds, GB/s, GFlop/s, of_triad and of_peak
    (None where a kernel has none)."""
    runs = {}
    for run in data["benchmarks"]:
        name = NAME.match(run["name"])
        if name and run.get("run_type", "iteration") == "iteration" and not run.get("error_occurred"):
            runs.setdefault(name.groups(), []).append(run)
    found = []
    for (kernel, measure_name, size, threads), repeated in runs.items():
        row = {"kernel": kernel, "measure": measure_name, "size": int(size), "threads": int(threads),
               "seconds": statistics.median(r["real_time"] * SECONDS[r["time_unit"]] for r in repeated)}
        for counter in ("GB/s", "GFlop/s", "of_triad", "of_peak"):
            known = [r[counter] for r in repeated if counter in r]
            row[counter] = statistics.median(known) if known else None
        found.append(row)
    return found


def of_roof(row):
    return max(row["of_triad"] or 0, row["of_peak"] or 0)


def bound(row):
    """What limits a kernel at its best: "triad" or "peak"."""
    return "triad" if (row["of_triad"] or 0) >= (row["of_peak"] or 0) else "peak"


def table(data):
    """Markdown: the machine, then a table for each size of problem and one of the dense orders."""
    most = machine(data)
    text = (f"Triad {most['triad_1']:.1f} GB/s with one thread, {most['triad_2']:.1f} with two; peak "
            f"{most['peak_1']:.0f} and {most['peak_2']:.0f} GFlop/s "
            f"({data['context'].get('instructions', 'unknown')} instructions).\n")
    rows = kernels(data)
    sizes = sorted({row["size"] for row in rows if row["measure"] == "observations"})
    for size in sizes:
        chosen = [row for row in rows if row["measure"] == "observations" and row["size"] == size]
        text += f"\n{size:,} observations:\n\n" + one_table(data, chosen, lambda row: row["kernel"])
    orders = [row for row in rows if row["measure"] == "order"]
    if orders:
        text += "\nDense factorisation:\n\n"
        text += one_table(data, orders, lambda row: f"{row['kernel']}, order {row['size']}")
    return text


def one_table(data, rows, title):
    head = ["kernel", "ms", "GB/s", "of triad", "GFlop/s", "of peak", "of its roof", "gain of 2 threads",
            "of the machine's"]
    by_two = {title(row): row for row in rows if row["threads"] == 2}
    lines = ["| " + " | ".join(head) + " |", "|---" + "|--:" * (len(head) - 1) + "|"]
    for row in rows:
        if row["threads"] != 1:
            continue
        cells = [title(row), f"{1e3 * row['seconds']:.3g}", number(row["GB/s"]), share(row["of_triad"]),
                 number(row["GFlop/s"]), share(row["of_peak"]), share(of_roof(row))]
        two = by_two.get(title(row))
        gain = row["seconds"] / two["seconds"] if two else None
        cells += [f"{gain:.2f}", share(gain / gains(data)[bound(row)])] if two else ["", ""]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def number(value):
    return "" if value is None else f"{value:.1f}"


def share(value):
    return "" if value is None else f"{100 * value:.0f} %"
