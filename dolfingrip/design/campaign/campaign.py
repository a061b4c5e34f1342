"""A campaign: a folder of designs that share their settings, computed where they are missing.

Its flat table is written as CSV and Parquet.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import pyarrow
import pyarrow.csv
import pyarrow.parquet

from dolfingrip.design.campaign.plan import Plan
from dolfingrip.experiments.results.sensitivity_table import COLUMNS
from dolfingrip.files import whole
from dolfingrip.files.campaign import CampaignDesign, CampaignFile
from dolfingrip.jobs import run as jobs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool, Unfinished
from dolfingrip.jobs.run import Progress, Standing, silent
from dolfingrip.jobs.store import NAME, Store


def run(
    plan: Plan,
    out: Path,
    where: Where,
    *,
    retry_failed: bool = False,
    spared: Collection[str] = (),
    progress: Progress = silent,
) -> Standing:
    """Compute the designs that are missing.

    Args:
        plan: designs to have; the folder keeps others of the same settings too.
        out: folder of the campaign.
        where: workers.
        retry_failed: compute failed designs anew.
        spared: classes of failures that are not computed anew.
        progress: called at the start and with each answer stored.

    Raises:
        ConfigError: one line, where the folder is another campaign's or there are no workers.
        SchedulerGone: all workers are gone.
    """
    try:
        with Pool(where) as pool:
            standing = jobs.run(
                plan.jobs(where.ranks), out, pool, plan.shared,
                retry_failed=retry_failed, spared=spared, progress=progress,
            )  # fmt: skip
    except (KeyboardInterrupt, Unfinished):
        read(out).write(out)
        raise
    read(out).write(out)
    return standing


def check(plan: Plan, out: Path) -> None:
    """Refuse designs that do not belong into a campaign, before anything else is computed.

    Args:
        plan: designs that will be asked for.
        out: folder of the campaign, which need not be there.

    Raises:
        ConfigError: one line.
    """
    if (out / NAME).exists():
        with Store(out) as store:
            store.agreed(plan.shared)


def read(folder: Path) -> CampaignFile:
    """Read the designs in a campaign's store, which may be ahead of its ``campaign.json``.

    Args:
        folder: of the campaign.

    Returns:
        Contents of ``campaign.json``.

    Raises:
        ConfigError: one line, where there is no campaign, or its store is damaged.
    """
    with Store(folder) as store:
        facts = store.facts() or {"parameters": (), "quantities": ()}
        designs = tuple(_design(row, facts["parameters"]) for row in store.rows())
    return CampaignFile(designs=designs, **facts)


def _design(row: dict[str, Any], parameters: Sequence[str]) -> CampaignDesign:
    """A job's row as a design; its curve is that up to a failure."""
    outcome = row["result"] or row["partial"] or {}
    config = row["arguments"]["config"]
    inputs = {key: value for key in parameters if (value := _value(config, key)) is not None}
    return CampaignDesign.model_validate({**row, **outcome, "inputs": inputs})


def _value(data: Any, key: str) -> Any:
    for name in key.split("."):
        data = (data or {}).get(name)
    return data


_TEXT, _NUMBER, _COUNT = pyarrow.string(), pyarrow.float64(), pyarrow.int64()
_KEPT = {
    "failure_class": _TEXT, "failure": _TEXT, "iterations": _COUNT, "started_at": _TEXT,
    "wall_s": _NUMBER, "worker": _TEXT,
}  # fmt: skip
_LONG = pyarrow.schema(zip(COLUMNS, (_COUNT, _TEXT, _TEXT, _NUMBER), strict=True))


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
    campaign = read(source.parent if source.name == NAME else source)
    designs = campaign.designs

    def get(name: str) -> list[Any]:
        return [getattr(design, name) for design in designs]

    columns: dict[str, tuple[list[Any], pyarrow.DataType | None]] = {
        "key": (get("key"), _TEXT), "status": (get("status"), _TEXT),
    }  # fmt: skip
    for key in campaign.parameters:
        columns[key] = [design.inputs.get(key) for design in designs], None
    for quantity in campaign.quantities:
        columns[quantity] = [(design.outputs or {}).get(quantity) for design in designs], _NUMBER
    columns |= {name: (get(name), kind) for name, kind in _KEPT.items()}
    for name in ("curve", "gradients", "versions"):
        columns[name] = [None if cell is None else json.dumps(cell) for cell in get(name)], _TEXT
    return pyarrow.table({name: pyarrow.array(*column) for name, column in columns.items()})


def sensitivities(source: Path) -> pyarrow.Table:
    """All derivatives of a campaign, one row each: a long table as ``sensitivity.csv``.

    Columns: ``row`` of :func:`table` from 0 on, ``column`` there, ``parameter`` (the
    configuration's key), and ``derivative`` in the column's unit for each unit of the parameter.

    Args:
        source: folder of the campaign.

    Raises:
        ConfigError: one line, where there is no campaign.
    """
    rows = [
        dict(zip(COLUMNS, (row, column, parameter, derivative), strict=True))
        for row, design in enumerate(read(source).designs)
        for column, slopes in (design.gradients or {}).items()
        for parameter, derivative in slopes.items()
    ]
    return pyarrow.Table.from_pylist(rows, _LONG)


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
    read(source).write(source)
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
