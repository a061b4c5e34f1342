"""Figures of the loop's table, by the rules of :mod:`benchmarks.blind.score`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Final

from benchmarks.blind import frozen, score
from benchmarks.blind.loop import cases
from benchmarks.blind.said import rows
from benchmarks.blind.score import Row

LARGEST: Final = 3
"""Members of a set that tells enough."""


def named(row: Row) -> bool:
    """Tell if a hidden cause is in a set of few."""
    few = max(len(row[key].split()) for key in ("first", "second")) <= LARGEST
    return few and score.named(row)


def answers(table: Path) -> Iterator[Row]:
    """Read answers with what is hidden.

    Args:
        table: folder of the tables.
    """
    for protocol in cases.PROTOCOLS:
        file = table / f"{protocol}.csv"
        hidden = {(case.kind, case.number): case for case in frozen.cases(protocol, cases.FOLDER)}
        for row in rows(file) if file.exists() else ():
            case = hidden[row["kind"], int(row["number"])]
            yield row | {"hidden": " ".join(case.hidden)}


def _after(every: Sequence[Row], turn: int) -> list[Row]:
    """The answers of cases that came so far: after some advice, or after the last of it."""
    return [
        row for row in every
        if int(row["round"]) == turn or (int(row["round"]) < turn and not row["advised"])
    ]  # fmt: skip


def table(every: Sequence[Row], protocols: Sequence[str], rounds: int = 2) -> str:
    """Write the figures of some protocols in Markdown.

    Args:
        every: rows of all tables.
        protocols: their names.
        rounds: of advice.
    """
    turns = range(rounds + 1)
    mine = [row for row in every if row["protocol"] in protocols]
    lines = [
        "| figure | target | " + " | ".join(f"after {turn}" for turn in turns) + " |",
        "|---|---|" + "---|" * len(turns),
    ]

    def add(figure: str, target: str, shown: Callable[[list[Row]], str]) -> None:
        cells = [shown(_after(mine, turn)) for turn in turns]
        lines.append(f"| {figure} | {target} | " + " | ".join(cells) + " |")

    def hits(which: Callable[[Row], bool]) -> Callable[[list[Row]], str]:
        return lambda answered: _share([which(row) for row in answered])

    def spent(name: str) -> Callable[[list[Row]], str]:
        def mean(answered: list[Row]) -> str:
            values = [float(row[name] or 0) for row in answered]
            return f"{sum(values) / max(len(values), 1):.0f}"

        return mean

    add("named in a set of at most three", "≥ 0.80 after 2", hits(named))
    add("wrong at 0.9 or more", "0", hits(score.wrong))
    add(
        "modulus and walls in their 90 % intervals",
        "0.85 to 0.95",
        lambda answered: _share(
            [held == "1" for row in answered for held in row["covers"].split()]
        ),
    )
    add("processor (s), mean of the last diagnosis", "", spent("processor_s"))
    add("new simulations, mean of the last diagnosis", "", spent("simulations"))
    total = sum(cases.COUNTS[name] for name in protocols)
    finished = f"{', '.join(protocols)}: {len(_after(mine, rounds))} of {total} cases are finished."
    return "\n".join([*lines, "", finished])


def _share(hits: Sequence[bool]) -> str:
    if not hits:
        return "–"
    low, high = score.interval(sum(hits), len(hits))
    return f"{sum(hits)} of {len(hits)} ({low:.2f}–{high:.2f})"
