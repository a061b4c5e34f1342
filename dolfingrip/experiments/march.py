"""Lead a model from reading to reading and keep what each yields."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from dolfingrip.config import Branch
from dolfingrip.experiments.keeper import Keeper, Row
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.mechanics.path.path import LoadPath


@dataclass(frozen=True, slots=True)
class Stop:
    """Where to read: the controls to go to, by name, and what the row says of it."""

    controls: Mapping[str, float]
    branch: Branch
    cycle: int


def march(
    kind: str,
    path: LoadPath,
    stops: Iterable[Stop],
    read: Callable[[], Mapping[str, float]],
    *,
    rows: list[Row],
    keep: Keeper | None,
    progress: Callable[[Row], None],
    profile: Profile,
) -> Failure | None:
    """Append a row for each stop that is reached to ``rows``.

    Args:
        kind: the experiment's name.
        path: leads the model.
        stops: in order.
        read: readings at the present state, by column.
        rows: grows.
        keep: where rows are written, if anywhere.
        progress: called with each new row.
        profile: where the time is booked.

    Returns:
        Why a stop was not reached, where one was not.
    """
    for stop in stops:
        arrival = path.advance(stop.controls)
        if arrival.failure is not None:
            return arrival.failure
        with profile.phase("observation"):
            readings = dict(read())
        row: dict[str, Any] = {
            "experiment": kind,
            "specimen": "simulated",
            "cycle": stop.cycle,
            "branch": stop.branch,
            **readings,
            "iterations": arrival.iterations,
            "load_steps": arrival.steps,
        }
        rows.append(row)
        if keep is not None:
            keep.append(row)
        progress(row)
    return None
