"""A campaign: a folder of designs that share their settings, computed where they are missing."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs import run as jobs
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool
from dolfingrip.jobs.run import Progress, Standing, silent
from dolfingrip.jobs.store import Store

RESULT: Final = ("outputs", "gradients", "curve", "iterations", "versions")
"""What a design's row has of its result; None where it is not done, but for the curve up to a
failure."""


@dataclass(frozen=True, slots=True)
class Stored:
    """The designs in a campaign's folder.

    Attributes:
        facts: what all designs share, see :meth:`Plan.facts`; None before the first design.
        rows: every design in the order of entry: its ``key``, ``inputs``, ``config``, ``status``,
            :data:`RESULT`, ``failure_class``, ``failure``, ``started_at``, ``wall_s``, ``worker``.
    """

    facts: dict[str, Any] | None
    rows: list[dict[str, Any]]

    def by_key(self) -> dict[str, dict[str, Any]]:
        """Rows by their keys."""
        return {row["key"]: row for row in self.rows}


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
    with Pool(where) as pool:
        return jobs.run(
            plan.jobs(where.ranks), out, pool, plan.shared,
            retry_failed=retry_failed, spared=spared, progress=progress,
        )  # fmt: skip


def read(folder: Path) -> Stored:
    """Read the designs in a campaign's folder.

    Args:
        folder: of the campaign.

    Returns:
        Its designs, and what they share.

    Raises:
        ConfigError: one line, where there is no campaign.
    """
    with Store(folder) as store:
        return Stored(store.facts(), [_of_design(row) for row in store.rows()])


def _of_design(row: dict[str, Any]) -> dict[str, Any]:
    """A job's row as a design's."""
    found = row.pop("result") or row.pop("partial") or {}
    config = row.pop("arguments")["config"]
    return {**row, "config": config, **{name: found.get(name) for name in RESULT}}
