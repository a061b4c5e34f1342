"""The figures as a table for people, a table for programs, and a picture of what is confused.

    scripts/run python -m benchmarks.blind.report TABLE.csv… --title TEXT --out FOLDER

writes those of several tables of cases together.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from benchmarks.blind import outcomes
from benchmarks.blind.opinions import Judged
from benchmarks.blind.score import Figure, by_protocol, confusion, figures


def write(judged: Sequence[Judged], title: str, folder: Path) -> str:
    """``figures.md``, ``figures.csv``, ``cases.csv`` and ``confusion.png``.

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
    text = markdown(found, by_protocol(judged), title, len(judged))
    (folder / "figures.md").write_text(text, encoding="utf-8")
    if judged:
        draw(confusion(judged), folder / "confusion.png")
    return text


def markdown(found: Sequence[Figure], protocols: pd.DataFrame, title: str, count: int) -> str:
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
    lines += ["", "Class named first, visible single effects:", ""]
    lines += ["| " + " | ".join(protocols.columns) + " |", "|" + "---|" * len(protocols.columns)]
    for row in protocols.to_dict("records"):
        lines.append("| " + " | ".join(_number(value) for value in row.values()) + " |")
    return "\n".join(lines) + "\n"


def _number(value: object) -> str:
    if isinstance(value, float):
        return "–" if np.isnan(value) else f"{value:.2f}"
    return str(value)


def draw(table: pd.DataFrame, path: Path) -> None:
    """What was answered for what was hidden, by share of the hidden ones."""
    counts = table.to_numpy(dtype=float)
    shares = counts / counts.sum(axis=1, keepdims=True)
    width = 2.5 + 0.32 * len(table.columns)
    figure, axes = plt.subplots(
        figsize=(width, 2.0 + 0.28 * len(table.index)), layout="constrained"
    )
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="auto")
    axes.set_xticks(range(len(table.columns)), table.columns, rotation=90)
    axes.set_yticks(range(len(table.index)), table.index)
    axes.set_xlabel("answered")
    axes.set_ylabel("hidden")
    for i, row in enumerate(counts):
        for j, count in enumerate(row):
            if count:
                colour = "white" if shares[i, j] > 0.6 else "black"
                axes.text(j, i, f"{count:.0f}", ha="center", va="center", color=colour, fontsize=8)
    figure.savefig(path, dpi=150)
    plt.close(figure)


def main() -> None:
    """Figures of several tables together."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.blind.report")
    parser.add_argument("tables", nargs="+", type=Path, metavar="TABLE.csv")
    parser.add_argument("--title", required=True, metavar="TEXT")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER")
    asked = parser.parse_args()
    judged = [case for file in asked.tables for case in outcomes.read(file)]
    print(write(judged, asked.title, asked.out))


if __name__ == "__main__":
    main()
