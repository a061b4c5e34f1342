"""The columns of the format of measured data: controls and readings of each experiment."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence
from typing import Final

from dolfingrip.channels import (
    CURVE,
    DISPLACEMENT,
    OBSTACLE,
    PRESSURE,
    TIME,
    WHO,
    at_marker,
    cavity_of_supply,
    readings,
)
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.recorder import columns

EXPERIMENT_NAMES: Final = tuple(name for name, each in EXPERIMENTS.items() if each.measured)
"""Experiments that the format has and the package simulates."""

NOT_SIMULATED: Final = ("grasp", "pick_up")
"""Experiments that the format has and the package does not simulate."""

CONTROL: Final[Mapping[str, str]] = {
    name: EXPERIMENTS[name].control.name for name in EXPERIMENT_NAMES
}
"""Column of what each experiment controls."""

READINGS: Final[Mapping[str, tuple[str, ...]]] = {
    name: tuple(each.name for each in readings(*EXPERIMENTS[name].parts))
    for name in EXPERIMENT_NAMES
}
"""Columns that each experiment reads; any of them may be absent. Markers have further ones."""

READING_COLUMNS: Final = tuple(sorted({name for own in READINGS.values() for name in own}))
"""All columns of readings."""

NUMBERS: Final = (TIME.name, PRESSURE.name, DISPLACEMENT.name, *READING_COLUMNS)
"""All columns of numbers."""

MEASURED: Final = (*WHO, *NUMBERS)
"""All columns of the format."""

IGNORED: Final = frozenset(
    {name for each in EXPERIMENTS.values() for name in columns(each)}
    | {CURVE.name, *(each.name for each in OBSTACLE)}
) - {*MEASURED}
"""Further columns of a simulation's ``result.csv``, which no instrument reads."""


def of_markers(names: Iterable[str]) -> tuple[str, ...]:
    """List the columns of markers among some names, of which a table has as many as were seen.

    Args:
        names: of columns.
    """
    return tuple(name for name in names if at_marker(name) is not None)


def of_any_number(names: Iterable[str]) -> tuple[str, ...]:
    """List the columns of markers and of single cavities' supplies among some names.

    Args:
        names: of columns.
    """
    names = tuple(names)
    return (*of_markers(names), *filter(cavity_of_supply, names))


def read_by(experiment: str, names: Iterable[str] = ()) -> tuple[str, ...]:
    """List the columns that an experiment reads, with those of markers among some names.

    Args:
        experiment: its name.
        names: of columns.
    """
    sees = "finger" in EXPERIMENTS[experiment].parts
    return (*READINGS[experiment], *(of_markers(names) if sees else ()))


def near(name: str, known: Sequence[str]) -> str:
    """Return ``did you mean …? `` if a known name is like another, else "".

    Args:
        name: as it is written.
        known: names that there are.
    """
    found = difflib.get_close_matches(name, known, 1, 0.6)
    return f"did you mean {found[0]}? " if found else ""


def allowed(name: str, known: Sequence[str]) -> str:
    """Tell what is allowed in place of a name, the nearest first.

    Args:
        name: of a column or an experiment.
        known: names that are allowed.
    """
    return f"{near(name, known)}allowed: {', '.join(known)}"
