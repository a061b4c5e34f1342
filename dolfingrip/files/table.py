"""Tables: columns of a dict, a DataFrame or a CSV file, read the same way, and written as CSV."""

from __future__ import annotations

import csv
import io
import logging
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from dolfingrip.files import whole

_LOG = logging.getLogger(__name__)


class Columns(Protocol):
    """The common interface of a dict of columns and a pandas DataFrame."""

    def __contains__(self, key: object, /) -> bool: ...

    def __getitem__(self, key: str, /) -> Any: ...

    def __iter__(self) -> Iterator[Any]: ...


def numbers(table: Columns, name: str) -> npt.NDArray[np.float64] | None:
    """One column as floats.

    Args:
        table: columns by name.
        name: the column wanted, e.g. ``force_N``.

    Returns:
        Shape (rows,), in the unit that the name carries; empty entries are NaN. None where the
        column is absent or holds no number at all.
    """
    if name not in table:
        return None
    entries = [_number(entry) for entry in table[name]]
    values = np.array(entries, dtype=np.float64)
    return values if np.isfinite(values).any() else None


def required(table: Columns, name: str) -> npt.NDArray[np.float64]:
    """One column as floats, as :func:`numbers` reads it; it must be there.

    Args:
        table: columns by name.
        name: the column wanted.

    Returns:
        Shape (rows,), in the unit that the name carries; empty entries are NaN.

    Raises:
        ValueError: One line naming the missing column.
    """
    values = numbers(table, name)
    if values is None:
        raise ValueError(f"results have no column {name}")
    return values


def branches(table: Columns) -> npt.NDArray[np.str_]:
    """The branch of each row.

    Args:
        table: columns by name.

    Returns:
        Shape (rows,), of ``loading``, ``unloading``, ``hold`` and ``lift``. Every row counts as
        ``loading`` if the table has no such column.
    """
    if "branch" not in table:
        rows = len(next((list(table[name]) for name in table), ()))
        return np.array(["loading"] * rows, dtype=np.str_)
    names = [entry if isinstance(entry, str) and entry else "loading" for entry in table["branch"]]
    return np.array(names, dtype=np.str_)


def read_csv(path: Path, *, ours: bool = False) -> dict[str, list[str]]:
    """The columns of a CSV file with one header line, as text.

    Args:
        path: file.
        ours: each row was written with its end, so a last row that has none is cut; it is left
            out.

    Returns:
        Entries by the name of their column.

    Raises:
        OSError: where it cannot be opened.
        ValueError: One line naming the file where it is empty, or no CSV in UTF-8.
    """
    try:
        text = path.read_bytes().decode()
        rows = list(csv.reader(io.StringIO(text, newline="")))
    except (UnicodeDecodeError, csv.Error) as error:
        raise ValueError(f"{path}: not a CSV in UTF-8: {error}") from None
    if ours and text and not text.endswith("\n"):
        _LOG.warning("%s: the last row is cut; it is left out", path)
        rows.pop()
    if not rows:
        raise ValueError(f"{path}: empty, no header line")
    header, body = rows[0], [row for row in rows[1:] if row]
    return {name: [row[i] if i < len(row) else "" for row in body] for i, name in enumerate(header)}


def select_rows(table: Columns, column: str, wanted: str) -> Columns:
    """The rows whose ``column`` is ``wanted``; all rows if the table has no such column.

    Args:
        table: columns by name.
        column: name of the column that is compared.
        wanted: its entry in the rows that are taken.

    Returns:
        Columns by name.
    """
    if column not in table:
        return table
    keep = [i for i, entry in enumerate(table[column]) if entry == wanted]
    columns = {str(name): list(table[name]) for name in table}
    return {name: [entries[i] for i in keep] for name, entries in columns.items()}


def _number(entry: Any) -> float:
    if entry is None or (isinstance(entry, str) and not entry.strip()):
        return float("nan")
    return float(entry)


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
