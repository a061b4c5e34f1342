"""A campaign: a folder of designs that share their settings, computed where they are missing."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from dolfingrip.design.campaign.plan import Plan
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
    found = row["result"] or row["partial"] or {}
    config = row["arguments"]["config"]
    inputs = {key: value for key in parameters if (value := _value(config, key)) is not None}
    return CampaignDesign.model_validate({**row, **found, "inputs": inputs})


def _value(data: Any, key: str) -> Any:
    for name in key.split("."):
        data = (data or {}).get(name)
    return data
