"""Results as a table for the console."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.cells import cell_len
from rich.console import JustifyMethod
from rich.table import Table

from dolfingrip.channels import Channel
from dolfingrip.files.table import Columns, branches, numbers, required

BRANCH = "Branch"
"""Heading of the column that tells loading from unloading."""

Key = tuple[float, str, int]


def tabulate(
    *results: tuple[Sequence[Channel], Columns],
    title: str | None = None,
    errors: Mapping[str, Sequence[float]] = MappingProxyType({}),
) -> Table:
    """A table of one result, or of several results side by side.

    Args:
        results: the columns to show of each result, and the result itself. Rows of several
            results are joined by the first column shown; the others are left out if the result
            lacks them.
        title: set above the table.
        errors: of the mesh, by column and row, which stand beside the readings.

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
            off = errors.get(column.name) or np.zeros(len(values))
            for key, value, error in zip(keys, values, off, strict=True):
                if np.isfinite(value):
                    beside = f" (mesh: {error:+z{column.form}})" if error else ""
                    rows[key][column.heading] = f"{float(value):z{column.form}}{beside}"
    if not headings:
        raise ValueError("results: no column to tabulate")
    with_branch = len({branch for _, branch, _ in rows}) > 1
    lead = results[0][0][0]
    columns = {lead.heading: [f"{value:z{lead.form}}" for value, _, _ in rows]}
    if with_branch:
        columns[BRANCH] = [branch for _, branch, _ in rows]
    for heading in headings:
        columns[heading] = [cells.get(heading, "–") for cells in rows.values()]
    return of_columns(columns, title, left=(BRANCH,))


def of_columns(
    columns: Mapping[str, Sequence[str]], title: str | None, left: Collection[str] = ()
) -> Table:
    """A table of columns, as :func:`of_rows` makes it of rows.

    Args:
        columns: cells of equal number by heading.
        title: set above the table.
        left: headings of the columns that are aligned on the left.
    """
    return of_rows(list(columns), list(zip(*columns.values(), strict=True)), title, left)


def of_rows(
    headings: Sequence[str],
    rows: Sequence[Sequence[str]],
    title: str | None = None,
    left: Collection[str] = (),
) -> Table:
    """A table that is as narrow as its longest words and its cells allow.

    Rich shortens columns that do not fit into the terminal by breaking their words. A heading is
    therefore wrapped at its spaces to the width of its column.

    Args:
        headings: of the columns.
        rows: a cell for each heading.
        title: set above the table.
        left: headings of the columns that are aligned on the left.
    """
    # two spaces between columns, none at the edges
    table = Table(title=title, box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    table.show_edge = False
    columns = list(zip(*rows, strict=True)) or [()] * len(headings)
    for heading, cells in zip(headings, columns, strict=True):
        lines = [*heading.split(), *(line for cell in cells for line in cell.splitlines())]
        width = max(map(cell_len, lines), default=1)
        wrapped = "\n".join(textwrap.wrap(heading, width))
        justify: JustifyMethod = "left" if heading in left else "right"
        table.add_column(wrapped, justify=justify, no_wrap=True)
    for row in rows:
        table.add_row(*row)
    return table


def _keys(result: Columns, first: str) -> list[Key]:
    """The key of each row: value, branch, and how many rows before it have both."""
    seen: Counter[tuple[float, str]] = Counter()
    keys = []
    for value, branch in zip(required(result, first), branches(result), strict=True):
        pair = (round(float(value), 3), str(branch))
        keys.append((*pair, seen[pair]))
        seen[pair] += 1
    return keys
