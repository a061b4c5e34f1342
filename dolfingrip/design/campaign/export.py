"""A campaign as one flat table, and that table as CSV and Parquet."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow
import pyarrow.csv
import pyarrow.parquet

from dolfingrip.design.campaign import campaign
from dolfingrip.files import whole
from dolfingrip.jobs.store import NAME

_KEPT = ("failure_class", "failure", "iterations", "started_at", "wall_s", "worker")
LONG = ("row", "column", "parameter", "derivative")
"""Columns of ``sensitivity.csv``, as of a single experiment's."""
_TEXTS = ("curve", "gradients", "versions")


def table(source: Path) -> pyarrow.Table:
    """All designs of a campaign, one row each, in the order they were asked for.

    Columns: ``key``, ``status``, every key of the configuration that the campaign varies, every
    quantity (empty unless ``status`` is ``done``), then class and sentence of a failure,
    iterations, timing, worker, and the curve, gradients and versions as JSON.

    Args:
        source: folder of the campaign, or its ``campaign.sqlite``.

    Raises:
        ConfigError: one line, where there is no campaign.
    """
    found = campaign.read(source.parent if source.name == NAME else source)
    designs = found.designs
    columns: dict[str, pyarrow.Array] = {
        name: pyarrow.array([getattr(each, name) for each in designs], pyarrow.string())
        for name in ("key", "status")
    }
    for key in found.parameters:
        columns[key] = pyarrow.array([each.inputs.get(key) for each in designs])
    for quantity in found.quantities:
        values = [(each.outputs or {}).get(quantity) for each in designs]
        columns[quantity] = pyarrow.array(values, pyarrow.float64())
    kinds = {"iterations": pyarrow.int64(), "wall_s": pyarrow.float64()}
    for name in _KEPT:
        entries = [getattr(each, name) for each in designs]
        columns[name] = pyarrow.array(entries, kinds.get(name, pyarrow.string()))
    for name in _TEXTS:
        entries = [getattr(each, name) for each in designs]
        texts = [None if each is None else json.dumps(each) for each in entries]
        columns[name] = pyarrow.array(texts, pyarrow.string())
    return pyarrow.table(columns)


def sensitivities(source: Path) -> pyarrow.Table:
    """All derivatives of a campaign, one row each: a long table as ``sensitivity.csv``.

    Columns: ``row`` of :func:`table` from 0 on, ``column`` there, ``parameter`` (the
    configuration's key), and ``derivative`` in the column's unit for each unit of the parameter.

    Args:
        source: folder of the campaign.

    Raises:
        ConfigError: one line, where there is no campaign.
    """
    found = [
        (row, column, parameter, derivative)
        for row, design in enumerate(campaign.read(source).designs)
        for column, slopes in (design.gradients or {}).items()
        for parameter, derivative in slopes.items()
    ]
    kinds = (pyarrow.int64(), pyarrow.string(), pyarrow.string(), pyarrow.float64())
    return pyarrow.table(
        {
            name: pyarrow.array([each[i] for each in found], kind)
            for i, (name, kind) in enumerate(zip(LONG, kinds, strict=True))
        }
    )


def write(source: Path, paths: list[Path]) -> int:
    """Write a campaign's table, and its ``campaign.json`` anew; the suffix determines the format.

    Args:
        source: folder of the campaign.
        paths: files that end in ``.csv`` or ``.parquet``.

    Returns:
        Number of designs.

    Raises:
        ConfigError: one line, where there is no campaign.
        WriteError: one line.
    """
    content = table(source)
    for path in paths:
        _write(content, path)
    campaign.read(source).write(source)
    return int(content.num_rows)


def write_sensitivities(source: Path, path: Path) -> int:
    """Write a campaign's derivatives as CSV, where it has any.

    Args:
        source: folder of the campaign.
        path: file to be written.

    Returns:
        Number of derivatives.

    Raises:
        ConfigError: one line, where there is no campaign.
        WriteError: one line.
    """
    content = sensitivities(source)
    if content.num_rows:
        _write(content, path)
    return int(content.num_rows)


def _write(content: pyarrow.Table, path: Path) -> None:
    kind = pyarrow.parquet.write_table if path.suffix == ".parquet" else pyarrow.csv.write_csv
    with whole.stream(path) as file:
        kind(content, file)
