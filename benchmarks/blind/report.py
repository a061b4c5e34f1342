"""The figures as a table for people and a table for programs.

    scripts/run python -m benchmarks.blind.report TABLE.csv… --title TEXT --out FOLDER

writes those of several tables of cases together, and

    scripts/run python -m benchmarks.blind.report --compare NAME=TABLE.csv[+TABLE.csv…] …

prints those of several sets of cases as the columns of one table.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.blind import outcomes
from benchmarks.blind.opinions import Judged
from benchmarks.blind.score import Figure, figures


def write(judged: Sequence[Judged], title: str, folder: Path) -> str:
    """``figures.md``, ``figures.csv`` and ``cases.csv``.

    Args:
        judged: cases with both opinions.
        title: of the table.
        folder: where they are written.

    Returns:
        The text of ``figures.md``.
    """
    folder.mkdir(parents=True, exist_ok=True)
    found = figures(judged)
    pd.DataFrame([asdict(each) for each in found]).to_csv(folder / "figures.csv", index=False)
    outcomes.table(judged).to_csv(folder / "cases.csv", index=False)
    text = markdown(found, title, len(judged))
    (folder / "figures.md").write_text(text, encoding="utf-8")
    return text


def markdown(found: Sequence[Figure], title: str, count: int) -> str:
    """The figures as a page."""
    lines = [
        f"# {title}",
        "",
        f"{count} cases; 90 % intervals; the bound is exact evidence on the same cases.",
        "",
        "| figure | target | value | 90 % | bound | cases | met |",
        "|---|---|---|---|---|---|---|",
    ]
    for each in found:
        met = {True: "yes", False: "**no**", None: "–"}[each.met]
        inside = "–" if np.isnan(each.low) else f"{each.low:.2f}–{each.high:.2f}"
        lines.append(
            f"| {each.name} | {each.target} | {_number(each.value)} | {inside} | "
            f"{_number(each.bound)} | {each.count} | {met if each.target else '–'} |"
        )
    return "\n".join(lines) + "\n"


def comparison(sets: Mapping[str, Sequence[Judged]]) -> str:
    """Figures of several sets of cases, a column each: value (90 % interval) / bound, cases."""
    found = [figures(judged) for judged in sets.values()]
    lines = [f"| figure | target | {' | '.join(sets)} |", "|" + "---|" * (len(sets) + 2)]
    for row in zip(*found, strict=True):
        cells = " | ".join(_cell(each) for each in row)
        lines.append(f"| {row[0].name} | {row[0].target} | {cells} |")
    return "\n".join(lines) + "\n"


def _cell(figure: Figure) -> str:
    if not figure.count:
        return "–"
    inside = "" if np.isnan(figure.low) else f" ({figure.low:.2f}–{figure.high:.2f})"
    bound = "" if np.isnan(figure.bound) else f" / {figure.bound:.2f}"
    missed = " **no**" if figure.target and figure.met is False else ""
    return f"{figure.value:.2f}{inside}{bound}, {figure.count}{missed}"


def _number(value: float) -> str:
    return "–" if np.isnan(value) else f"{value:.2f}"


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the figures of several tables together, or compare several sets of tables."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind.report")
    parser.add_argument("tables", nargs="*", type=Path, metavar="TABLE.csv")
    parser.add_argument("--title", default="Blind benchmark", metavar="TEXT")
    parser.add_argument("--out", type=Path, metavar="FOLDER")
    parser.add_argument("--compare", nargs="+", default=[], metavar="NAME=TABLE.csv[+TABLE.csv…]")
    asked = parser.parse_args(arguments)
    if bool(asked.tables and asked.out) == bool(asked.compare):
        parser.error("either TABLE.csv… with --out FOLDER, or --compare NAME=TABLE.csv…")
    if asked.compare:
        parts = [text.partition("=") for text in asked.compare]
        sets = {name: _together(_tables(files)) for name, _, files in parts}
        print(comparison(sets), end="")
    else:
        print(write(_together(asked.tables), asked.title, asked.out))


def _tables(files: str) -> list[str]:
    """Names of tables between plus signs; one that follows no ".csv" is part of a name."""
    return [name if name.endswith(".csv") else f"{name}.csv" for name in files.split(".csv+")]


def _together(files: Sequence[str | Path]) -> list[Judged]:
    return [case for file in files for case in outcomes.read(Path(file))]


if __name__ == "__main__":
    main()
