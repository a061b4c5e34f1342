"""Results as a table for the console."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from rich.table import Table

from dolfingrip.experiments.description import Column
from dolfingrip.report.columns import Columns, branches, numbers, required

Key = tuple[float, str, int]


def tabulate(*results: tuple[Sequence[Column], Columns], title: str | None = None) -> Table:
    """Columns of one result or of several, side by side.

    Args:
        results: of each the columns to show and the result itself. The first column shown is
            that by which rows of several results are joined; the others are left out where the
            result lacks them.
        title: set above the table.

    Returns:
        A table with one row for each value of the first column and each branch in any result,
        in their order; a dash where a result has no value. The branch has a column only where
        there is more than one.

    Raises:
        ValueError: One line where there is nothing to show or a result lacks the first column.
    """
    rows: dict[Key, dict[str, str]] = {}
    headings: list[str] = []
    for (first, *shown), result in results:
        keys = _keys(result, first.name)
        for key in keys:
            rows.setdefault(key, {})
        for column in shown:
            values = numbers(result, column.name)
            if values is None:
                continue
            headings.append(column.heading)
            for key, value in zip(keys, values, strict=True):
                if np.isfinite(value):
                    rows[key][column.heading] = _format(float(value), column.form)
    if not headings:
        raise ValueError("results: no column to tabulate")
    with_branch = len({branch for _, branch, _ in rows}) > 1
    lead = results[0][0][0]
    table = Table(title=title)
    table.add_column(lead.heading, justify="right")
    if with_branch:
        table.add_column("Branch")
    for heading in headings:
        table.add_column(heading, justify="right")
    for (value, branch, _), cells in rows.items():
        first_cells = [_format(value, lead.form), *([branch] if with_branch else [])]
        table.add_row(*first_cells, *(cells.get(heading, "–") for heading in headings))
    return table


def _format(value: float, form: str) -> str:
    text = format(value, form)
    return text.lstrip("-") if float(text) == 0 else text  # no "-0.00"


def _keys(result: Columns, first: str) -> list[Key]:
    """Value, branch and how often both were there before: what rows of two results share."""
    seen: Counter[tuple[float, str]] = Counter()
    keys = []
    for value, branch in zip(required(result, first), branches(result), strict=True):
        pair = (round(float(value), 3), str(branch))
        keys.append((*pair, seen[pair]))
        seen[pair] += 1
    return keys
