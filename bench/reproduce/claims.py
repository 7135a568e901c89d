"""Claims of a paper as functions of results: (verdict, sentence with our numbers)."""

HOLDS, FAILS, TIE, MISSING = "holds", "fails", "no difference", "not run"


class Claim:
    def __init__(self, text, check):
        self.text, self.check = text, check


def number(value, digits=3):
    if value is None:
        return "?"
    if value == float("inf"):
        return "never"
    if 1000 <= value < 1e6 and digits == 3:
        return f"{value:.0f}"
    return f"{value:.{digits}g}"


def judged(claims, results):
    """Rows (text, verdict, sentence)."""
    return [(claim.text, *claim.check(results)) for claim in claims]


def count(rows):
    """How many rows have each verdict."""
    counts = dict.fromkeys((HOLDS, FAILS, TIE, MISSING), 0)
    for _, verdict, _ in rows:
        counts[verdict] += 1
    return counts
