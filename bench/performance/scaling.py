"""From one thread to two, phase by phase, and what that lets one expect of more."""

import re

from reproduce.claims import number
from reproduce.text import table

from . import machine
from .claims import observations
from .logs import SCALING_FROM
from .problems import TITLES

MORE = (16, 64)  # cores


def ratio(value):
    return "" if value is None else number(value)


def percent(value):
    return "" if value is None else f"{100 * value:.2g} %"


def short(solver):
    return re.split(r", | \(| with ", solver)[0]


def choice(results, name):
    return short(results.linear_solver(name))


def measured(results, names):
    rows = []
    for name in names:
        row = [TITLES[name], choice(results, name), ratio(results.phase_gain(name, "total"))]
        for phase in machine.PHASES:
            whole = machine.gain(results.rates, phase, results.linear_solver(name))
            row += [percent(results.phase_share(name, phase)), ratio(results.phase_gain(name, phase))]
            row += [ratio(whole)] if results.rates else []
            row += [ratio(results.twin_gain(name, phase))]
        rows.append(row)
    head = ["problem", "linear solver", "whole solve"]
    for phase in machine.PHASES:
        head += [phase + ", share of the time", "gain", *(["machine's"] if results.rates else []), "two at once"]
    return table(head, rows)


def serial_share(gain, whole):
    """Amdahl: the share s of a phase that one core does alone, from 1 / gain = s + (1 - s) / whole. A
    machine that gains nothing shows nothing of it."""
    if not gain or not whole or whole <= 1.1:
        return None
    return min(max((1 / gain - 1 / whole) / (1 - 1 / whole), 0.0), 1.0)


def expected(parts, cores):
    """`parts`: (share of the time on one core, its serial share)."""
    return 1 / sum(share * (serial + (1 - serial) / cores) for share, serial in parts)


def model(results, names):
    rows = []
    for name in names:
        parts, unknown = [], []
        for phase in (*machine.PHASES, "rest"):
            bound = machine.gain(results.rates, phase, results.linear_solver(name))
            bound = results.twin_gain(name, phase) or bound
            serial = serial_share(results.phase_gain(name, phase), bound)
            if serial is None:
                unknown.append(phase)
            parts.append((results.phase_share(name, phase), serial or 0.0))
        alone = sum(share * serial for share, serial in parts)
        rows.append([TITLES[name], percent(alone), *(number(expected(parts, cores)) for cores in MORE),
                     ", ".join(unknown) or "none"])
    return table(["problem", "serial share of the time", *(f"times faster on {cores} cores" for cores in MORE),
                  "phases taken as parallel"], rows)


def machine_text(rates):
    parts = [f"{what} by a factor of {number(rates[key])}" for key, what in
             (("peak", "multiplications and additions"), ("triad", "STREAM triad")) if key in rates]
    return f"The machine gains in {' and in '.join(parts)}." if parts else \
        "What the machine itself gains was not measured in this run."


def text(results):
    names = [name for name in results.names if observations(results, name) > SCALING_FROM
             and results.phase_gain(name, "linear")]
    body = ("Time with one thread over time with two, same iterations, beside what the machine itself gains in "
            "what limits the phase: flops for residuals and factorisations, STREAM triad for Jacobian and inner "
            f"iterations. {machine_text(results.rates)} Last what two solves at once, one thread each, gain over one "
            "after the other: nobody waits for anybody there, and the work is the same.\n\n")
    if not names:
        return body + f"No problem above {SCALING_FROM:,} observations was run with one thread and with two.\n\n"
    body += measured(results, names) + "\n"
    if not results.rates:
        return body
    return body + (
        "On paper: the serial share of each phase from its gain by Amdahl's law, against what two solves at once gain, and from "
        "these the gain on cores that share nothing, memory included. A phase whose limit gains nothing here shows no serial "
        "share and is taken as parallel.\n\n" + model(results, names) + "\n")
