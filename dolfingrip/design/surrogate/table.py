"""The table a surrogate learns from: designs that were computed, their inputs and outputs."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow
import pyarrow.csv
import pyarrow.parquet

from dolfingrip.design.campaign import campaign as computed
from dolfingrip.jobs.store import NAME, Store
from dolfingrip.sections.errors import ConfigError

STATUS, DONE, FAILED = "status", "done", "failed"
"""The column of a design's status, and its values."""

Matrix = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Table:
    """Designs with every number present; failed ones are counted, never kept as numbers.

    Attributes:
        inputs: shape (designs, input names), in the unit each name carries.
        outputs: shape (designs, output names), likewise.
        failed: designs whose simulation failed.
        incomplete: others without all numbers, e.g. because they are still to be computed.
    """

    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    inputs: Matrix
    outputs: Matrix
    failed: int = 0
    incomplete: int = 0

    def __len__(self) -> int:
        return len(self.inputs)

    def sha256(self) -> str:
        """A fingerprint of the names and numbers, the same on every machine."""
        digest = hashlib.sha256(repr((self.input_names, self.output_names)).encode())
        for numbers in (self.inputs, self.outputs):
            digest.update(np.ascontiguousarray(numbers, dtype="<f8").tobytes())
        return digest.hexdigest()


def read(source: Path, inputs: Sequence[str], outputs: Sequence[str]) -> Table:
    """Read the computed designs of a campaign's folder, or of a CSV or Parquet table.

    Args:
        source: folder or store of a campaign, ``.csv`` or ``.parquet``.
        inputs, outputs: names of the columns wanted.

    Returns:
        The designs that are done, with all numbers.

    Raises:
        ConfigError: one line, where the table is unreadable, lacks a column, or holds text
            where numbers should be.
    """
    columns = _columns(source)
    for name in (*inputs, *outputs):
        if name not in columns.column_names:
            allowed = ", ".join(columns.column_names)
            raise ConfigError(f"{source}: no column {name}; allowed: {allowed}")
    numbers = {name: _numbers(source, columns, name) for name in (*inputs, *outputs)}
    x = np.column_stack([numbers[name] for name in inputs])
    y = np.column_stack([numbers[name] for name in outputs])
    done: npt.NDArray[np.bool_] = np.full(len(x), True)
    failed = 0
    if STATUS in columns.column_names:
        statuses = columns[STATUS].to_pylist()
        done = np.array([status == DONE for status in statuses])
        failed = statuses.count(FAILED)
    complete = np.isfinite(x).all(axis=1) & np.isfinite(y).all(axis=1)
    keep = done & complete
    return Table(
        tuple(inputs),
        tuple(outputs),
        x[keep],
        y[keep],
        failed=failed,
        incomplete=int((~keep).sum()) - failed,
    )


def campaign(source: Path) -> dict[str, Any] | None:
    """Return what all designs of a campaign share (``Plan.facts``).

    Args:
        source: folder or store of a campaign, or a table.

    Returns:
        The facts; None where the source is a table.

    Raises:
        ConfigError: one line, where the folder holds no campaign.
    """
    if not (source.is_dir() or source.name == NAME):
        return None
    with Store(source.parent if source.name == NAME else source) as store:
        return store.facts()


def _columns(source: Path) -> pyarrow.Table:
    try:
        if source.suffix == ".csv":
            return pyarrow.csv.read_csv(source)
        if source.suffix == ".parquet":
            return pyarrow.parquet.read_table(source)
        if source.is_dir() or source.name == NAME:
            return computed.table(source)
    except OSError as error:
        reason = os.strerror(error.errno) if error.errno else "not readable"
        raise ConfigError(f"{source}: {reason}") from None
    except pyarrow.ArrowInvalid as error:
        raise ConfigError(f"{source}: no table: {str(error).splitlines()[0]}") from None
    raise ConfigError(
        f"{source}: unknown kind of table; allowed: .csv, .parquet, a campaign's folder"
    )


def _numbers(source: Path, columns: pyarrow.Table, name: str) -> npt.NDArray[np.float64]:
    """One column, shape (rows,); NaN where the table has nothing."""
    try:
        return np.array(
            [
                np.nan if entry is None or entry == "" else float(entry)
                for entry in columns[name].to_pylist()
            ]
        )
    except (TypeError, ValueError):
        raise ConfigError(f"{source}: column {name} holds text; allowed: numbers") from None
