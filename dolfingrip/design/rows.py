"""Rows of a table as a CSV file, written whole or not at all."""

from __future__ import annotations

import csv
import os
from collections.abc import Mapping, Sequence
from pathlib import Path


def write(file: Path, rows: Sequence[Mapping[str, object]]) -> None:
    """Write rows that all have the keys of the first; None becomes an empty entry."""
    partial = file.with_name(f"{file.name}.{os.getpid()}.part")
    with partial.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]) if rows else [], lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    partial.replace(file)
