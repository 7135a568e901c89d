"""Claims of the thesis as functions of results: (verdict, sentence with our numbers)."""

from reproduce.claims import FAILS, HOLDS, MISSING, TIE, number

QUANTITIES = {
    "cost": "final cost",
    "gradient": "final gradient norm",
    "least_gradient": "least gradient norm",
    "total": "seconds in all",
    "per_solve": "seconds per linear solve",
    "settled": "steps to a gradient norm of 10",
    "settled_seconds": "seconds to a gradient norm of 100",
    "inner": "inner iterations per solve",
    "rises": "decades of gradient rises",
    "camera": "RMSE of the cameras",
    "point": "RMSE of the points",
}
# Factors that are no difference; 1.02 where nothing is said.
SAME = {"cost": 1.0001, "gradient": 1.5, "least_gradient": 1.5}


def digits_of(quantity):
    return 8 if quantity == "cost" else 3


def values(results, problem, names, quantity):
    """Of the runs that are there and have it: {name: value}. A run that broke off has no time."""
    found = {}
    for name in names:
        run = results.run(problem, name)
        if run and quantity in ("total", "per_solve", "inner", "rises") and run.failed:
            continue
        value = getattr(run, quantity) if run else None
        if value is not None and quantity in ("gradient", "least_gradient"):
            value = max(value, 1e-9 * run.kept[0]["gradient_norm"])  # what is beneath has vanished
        if value is not None:
            found[name] = value
    return found


def listed(found, digits=3):
    return ", ".join(f"{name.removeprefix('long-')} {number(value, digits)}"
                     for name, value in sorted(found.items(), key=lambda item: item[1]))


def least(problem, quantity, winners, names):
    """`winners` have the least value among `names` (all of them below all others)."""
    factor = SAME.get(quantity, 1.02)

    def check(results):
        found = values(results, problem, names, quantity)
        ours = [found[name] for name in winners if name in found]
        others = [value for name, value in found.items() if name not in winners]
        sentence = f"{QUANTITIES[quantity]}: {listed(found, digits_of(quantity))}"
        if any(results.run(problem, name) and name not in found for name in winners):
            return FAILS, "broke off; " + sentence
        if len(ours) < len(winners) or not others:
            return MISSING, ""
        if max(ours) * factor < min(others):
            return HOLDS, sentence
        return (TIE if max(ours) <= min(others) * factor else FAILS), sentence
    return check


def similar(problem, names, within):
    """The final costs are all within a share of the least."""
    def check(results):
        found = values(results, problem, names, "cost")
        if len(found) < 2:
            return MISSING, ""
        low = min(found.values())
        away = {name: 100 * (value / low - 1) for name, value in found.items()
                if value > low * (1 + within)}
        if not away:
            worst = max(found.values()) / low - 1
            return HOLDS, f"final costs are within {100 * worst:.2g} % of the least, {number(low, 8)}"
        return FAILS, f"above the least cost, {number(low, 8)}, by per cent: {listed(away)}"
    return check


def faster_to(problem, fast, slow, excess=0.01, unit="steps"):
    """Each of `fast` comes to within a share of the least cost before its partner of `slow`."""
    def check(results):
        found = values(results, problem, fast + slow, "cost")
        if len(found) < len(set(fast + slow)):
            return MISSING, ""
        target = min(found.values()) * (1 + excess)
        to = {name: getattr(results.run(problem, name), unit + "_to")(target) for name in found}
        sentence = f"{unit} to within {100 * excess:g} % of the least cost: {listed(to)}"
        pairs = [(to[a], to[b]) for a, b in zip(fast, slow) if min(to[a], to[b]) < float("inf")]
        if all(a == b for a, b in pairs):
            return TIE, sentence
        return (HOLDS if all(a <= b for a, b in pairs) else FAILS), sentence
    return check


def below(problem, quantity, bound, names):
    def check(results):
        found = values(results, problem, names, quantity)
        if len(found) < len(names):
            return MISSING, ""
        good = all(value < bound for value in found.values())
        return (HOLDS if good else FAILS), f"{QUANTITIES[quantity]}: {listed(found)}"
    return check


def times_faster(problem, quantity, fast, slow, factor):
    """`fast` takes at most 1 / factor of the time of each of `slow`."""
    def check(results):
        found = values(results, problem, [fast] + slow, quantity)
        if len(found) < 1 + len(slow):
            return MISSING, ""
        ratios = {name: found[name] / found[fast] for name in slow}
        good = all(ratio >= factor for ratio in ratios.values())
        return (HOLDS if good else FAILS), f"times of others over that of {fast}: {listed(ratios)}"
    return check


def falling(problem, names, quantity, slack=1.0):
    """The quantity does not grow along `names`; `slack` is a factor that counts as no growth."""
    def check(results):
        found = values(results, problem, names, quantity)
        if len(found) < len(names):
            return MISSING, ""
        row = [found[name] for name in names]
        good = all(b <= a * slack for a, b in zip(row, row[1:]))
        text = ", ".join(f"{name} {number(found[name])}" for name in names)
        return (HOLDS if good else FAILS), f"{QUANTITIES[quantity]}: {text}"
    return check


def breaks_down(problem, names):
    """The thesis saw NaN; a claim about its own program rather than about the method."""
    def check(results):
        runs = {name: results.run(problem, name) for name in names}
        if not all(runs.values()):
            return MISSING, ""
        text = ", ".join(f"{name.removeprefix('long-')} {run.steps} steps, {run.status.replace('_', ' ')}"
                         for name, run in runs.items())
        good = any(run.failed for run in runs.values())
        return (HOLDS if good else FAILS), f"with us: {text}"
    return check


def identical_start(problem, a, b):
    """Two runs take the same first steps."""
    def check(results):
        first, second = results.run(problem, a), results.run(problem, b)
        if not first or not second:
            return MISSING, ""
        pairs = list(zip(first.kept, second.kept))
        same = next((k for k, (x, y) in enumerate(pairs) if x["cost"] != y["cost"]), len(pairs))
        switches = sum(each["eliminated"] == "cameras" for each in second.trials[1:])
        sentence = (f"the first {max(same - 1, 0)} of {len(pairs) - 1} steps are the same to the last "
                    f"bit; {b} eliminated the cameras in {switches} of {len(second.trials) - 1} trials")
        return (HOLDS if same > 1 else FAILS), sentence
    return check


def ranking(problem, quantity, order):
    """The names in ascending order of the quantity, as the thesis' table has them."""
    def check(results):
        found = values(results, problem, order, quantity)
        if len(found) < len(order):
            return MISSING, ""
        row = [found[name] for name in order]
        good = all(a <= b for a, b in zip(row, row[1:]))
        return (HOLDS if good else FAILS), f"{QUANTITIES[quantity]}: {listed(found)}"
    return check
