#!/usr/bin/env python3
"""Checks tools/roofline: medians, roofs and gains of a made-up run, and one kernel for real.

Usage: check_roofline.py PROJECT [BENCH_MICRO]
"""

import pathlib
import subprocess
import sys
import tempfile


def require(good, what):
    if not good:
        sys.exit(f"check_roofline: {what}")


def run(name, milliseconds, **counters):
    return {"name": name + "/min_time:0.2/real_time", "run_type": "iteration", "time_unit": "ms",
            "real_time": milliseconds, **counters}


def check_made_up(roofline):
    moved = {"GB/s": 6.0, "of_triad": 0.6, "GFlop/s": 1.0, "of_peak": 0.01}
    product = "implicit Schur product/observations:200000/threads:"
    data = {"context": {"triad_1": "10", "triad_2": "19", "peak_1": "100", "peak_2": "101"},
            "benchmarks": [run(product + "1", 4.0, **moved), run(product + "1", 9.0, **moved),
                           run(product + "1", 5.0, **moved), run(product + "2", 2.5, **moved),
                           {**run(product + "1", 77.0), "run_type": "aggregate"},
                           run("dense Cholesky/order:900/threads:1", 2.0, **{"GFlop/s": 70.0, "of_peak": 0.7})]}
    require(roofline.machine(data)["triad_2"] == 19, "the machine's figures")
    require(abs(roofline.gains(data)["triad"] - 1.9) < 1e-12, "the machine's gains")
    rows = roofline.kernels(data)
    require([row["threads"] for row in rows] == [1, 2, 1], "a row by kernel and threads")
    require(abs(rows[0]["seconds"] - 0.005) < 1e-12, "the median of the runs, without aggregates")
    require(roofline.bound(rows[0]) == "triad" and roofline.bound(rows[2]) == "peak", "what limits a kernel")
    lines = roofline.table(data).splitlines()
    # twice as fast with two threads, where the machine gains 1.9
    require("| implicit Schur product | 5 | 6.0 | 60 % | 1.0 | 1 % | 60 % | 2.00 | 105 % |" in lines, "its line")
    require("| dense Cholesky, order 900 | 2 |  |  | 70.0 | 70 % | 70 % |  |  |" in lines, "a line with gaps")


def check_real(roofline, program):
    with tempfile.TemporaryDirectory() as folder:
        data = roofline.measure(program, pathlib.Path(folder) / "out.json", 1,
                                "^(cost|explicit assembly)/observations:200000/threads:1")
    rows = {row["kernel"]: row for row in roofline.kernels(data)}
    require(set(rows) == {"cost", "explicit assembly"}, f"the kernels asked for, not {set(rows)}")
    for row in rows.values():
        require(row["seconds"] > 0 and row["of_triad"] > 0 and row["of_peak"] > 0, f"figures: {row}")
        most = roofline.machine(data)  # shares are those of the machine's figures
        require(abs(row["of_peak"] * most["peak_1"] / row["GFlop/s"] - 1) < 1e-4, f"share of peak: {row}")
        require(abs(row["of_triad"] * most["triad_1"] / row["GB/s"] - 1) < 1e-4, f"share of triad: {row}")
    require("| cost |" in roofline.table(data), "a table")


def main():
    project = pathlib.Path(sys.argv[1])
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(project / "bench"))
    from performance import roofline
    check_made_up(roofline)
    if len(sys.argv) > 2:
        check_real(roofline, sys.argv[2])
    done = subprocess.run([project / "tools/roofline", "--report", "/dev/null"], capture_output=True, text=True)
    require(done.returncode == 1 and done.stderr.startswith("roofline: "), "what is no run is refused")
    print("check_roofline: ok")


if __name__ == "__main__":
    main()
