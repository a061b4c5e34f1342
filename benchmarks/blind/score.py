"""Figures of a table, by the rules of the package."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from scipy.stats import beta

from benchmarks.blind.case import SEEN

Row = dict[str, str]
CLAIM = 0.9


def interval(hits: int, count: int) -> tuple[float, float]:
    """Central 90 % interval of a share, by Clopper and Pearson (1934); NaN of none."""
    if not count:
        return float("nan"), float("nan")
    low = 0.0 if hits == 0 else float(beta.ppf(0.05, hits, count - hits + 1))
    high = 1.0 if hits == count else float(beta.ppf(0.95, hits + 1, count - hits))
    return low, high


def named(row: Row) -> bool:
    """Tell if the answer is a cause, and a hidden one is in one of its sets."""
    said = {*row["first"].split(), *row["second"].split()}
    return row["answer"] == "cause" and bool(said & set(row["hidden"].split()))


def wrong(row: Row) -> bool:
    """Tell if a claim has a set without any hidden cause."""
    if row["answer"] != "cause" or float(row["probability"]) < CLAIM:
        return False
    hidden = set(row["hidden"].split())
    sets = [set(row[key].split()) for key in ("first", "second") if row[key]]
    return any(not each & hidden for each in sets)


def exactly(row: Row) -> bool:
    """Tell if exact evidence names a hidden cause."""
    said = {*row["exact_first"].split(), *row["exact_second"].split()}
    return bool(said & set(row["hidden"].split()))


def both(row: Row, first: str = "first", second: str = "second") -> bool:
    """Tell if two sets hold a hidden cause each."""
    a, b = row["hidden"].split()
    one, other = set(row[first].split()), set(row[second].split())
    return (a in one and b in other) or (b in one and a in other)


def counts(row: Row) -> bool:
    """Tell if an outsider alone is seen: the best single cause of the catalogue leaves enough."""
    return row["kind"] != "outsider" or float(row["sigma"].split()[0]) >= SEEN


def table(rows: Sequence[Row]) -> str:
    """In Markdown; exact evidence's figures where the rows have some."""
    rows = list(filter(counts, rows))
    held = any(row["exact_first"] for row in rows)
    lines = ["| figure | target | " + " | ".join([*_protocols(rows), "together"]) + " |"]
    lines.append("|" + "---|" * (len(_protocols(rows)) + 3))

    def add(figure: str, target: str, kind: str, hit: Callable[[Row], bool]) -> None:
        parts = []
        for protocol in [*_protocols(rows), None]:
            own = [r for r in rows if r["kind"] == kind and protocol in (None, r["protocol"])]
            hits = sum(map(hit, own))
            low, high = interval(hits, len(own))
            parts.append(f"{hits} of {len(own)} ({low:.2f}–{high:.2f})" if own else "–")
        lines.append(f"| {figure} | {target} | " + " | ".join(parts) + " |")

    add("one cause: named", "", "one", named)
    add("wrong", "", "one", wrong)
    add("cause and outsider: named", "≥ 0.80", "with_outsider", named)
    add("wrong", "≤ 0.03", "with_outsider", wrong)
    add("outsider alone: claimed as of the catalogue", "≤ 0.03", "outsider", wrong)
    add("nuisance 3 to 5 σ out: named", "≥ 0.80", "nuisance", named)
    if held:
        add("named by exact evidence", "", "nuisance", exactly)
    add("wrong", "≤ 0.03", "nuisance", wrong)
    add("two causes: both named", "exact evidence's", "two", both)
    if held:
        add("both named by exact evidence", "", "two",
            lambda row: both(row, "exact_first", "exact_second"))  # fmt: skip
    add("two causes: one of them named", "", "two", named)
    add("wrong", "", "two", wrong)
    add("nothing hidden: alarm", "≤ 0.05", "none", lambda row: row["answer"] != "none")
    covers = [int(each) for row in rows for each in (row["covers"] or "").split()]
    if covers:
        low, high = interval(sum(covers), len(covers))
        lines.append(
            f"| 90 % intervals hold the truth | 0.85 to 0.95 |{' |' * len(_protocols(rows))} "
            f"{sum(covers) / len(covers):.2f} ({low:.2f}–{high:.2f}), {len(covers)} |"
        )
    spent = [float(row["processor_s"]) for row in rows]
    told = Counter(row["commit"] for row in rows)
    lines.append(
        "\nCases by the commit whose package answered: "
        + ", ".join(f"{commit} {count}" for commit, count in told.items())
        + "."
    )
    lines.append(f"\n{len(rows)} cases, {sum(spent) / max(len(spent), 1):.1f} s of processor each.")
    return "\n".join(lines)


def _protocols(rows: Sequence[Row]) -> list[str]:
    return list(dict.fromkeys(row["protocol"] for row in rows))
