"""Tables as CSV files."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from dolfingrip.files import whole


def write(path: Path, rows: Sequence[Mapping[str, Any]], columns: Sequence[str] = ()) -> None:
    """Write a table as CSV.

    Args:
        path: target; an existing file is replaced.
        rows: values by column; None and columns that a row lacks become empty entries.
        columns: names in their order; (): those of the first row, which all rows have.

    Raises:
        WriteError: one line.
    """
    names = columns or (list(rows[0]) if rows else [])
    whole.write(path, lines([dict(zip(names, names, strict=True)), *rows], names))


def lines(rows: Iterable[Mapping[str, Any]], columns: Sequence[str]) -> str:
    """Write rows as lines of a CSV file, without a head.

    Args:
        rows: values by column.
        columns: names in their order.

    Returns:
        A line for each row, each with its end.
    """
    text = io.StringIO()
    csv.DictWriter(text, columns, lineterminator="\n").writerows(rows)
    return text.getvalue()
