"""What became of a grasp."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

LETTERS = "ABC"
"""Of the thumb and the fingers."""

COLUMNS = (
    *("table_z_mm", "object_x_mm", "object_y_mm", "object_z_mm", "object_turn_deg"),
    *(f"object_turn_{axis}_deg" for axis in "xyz"),
    *(f"angle_{letter}_deg" for letter in LETTERS),
    *(f"normal_{letter}_N" for letter in LETTERS),
    *(f"lift_{letter}_N" for letter in LETTERS),
    *("table_N", "slip_mm", "contact_pressure_kPa", "force_closure"),
    *("friction_mJ", "momentum_error_N"),
)
"""Of a grasp alone; ``GraspReadings.read`` in ``rigs/grasp_readings.py`` tells what they mean."""

HELD_MM = 1.0
"""Way by which a held object may sink against the fingers, and rise from the table unnoticed."""

AWAY_MM = 15.0
"""Way out of the fingers' middle, beyond which an object that no finger touches has left them."""

BORNE = 0.01
"""Part of the weight on the table below which the fingers bear it."""


class Kind(StrEnum):
    """The classes."""

    PICKED_UP = "picked up"
    SLIPPED = "slipped"
    DROPPED = "dropped"
    EJECTED = "ejected"
    NOT_LIFTED = "not lifted"


@dataclass(frozen=True, slots=True)
class Moment:
    """One accepted step of a grasp.

    Attributes:
        time_s: of it.
        lifting: whether the lift has begun.
        centre_mm: (3,) of the object, seen from the gripper.
        rise_mm: of the object above where it stood on the table.
        fingers_N: (k,) normal force of each finger.
        table_part: part of the weight that the table bears.
    """

    time_s: float
    lifting: bool
    centre_mm: np.ndarray
    rise_mm: float
    fingers_N: np.ndarray
    table_part: float


@dataclass(frozen=True, slots=True)
class Outcome:
    """A class with its time and a sentence.

    Attributes:
        kind: the class.
        time_s: when it was decided.
        sentence: what happened.
    """

    kind: Kind
    time_s: float
    sentence: str


def ejected(moments: Sequence[Moment]) -> Outcome | None:
    """Whether the object has left the fingers sideways or upwards, before or in the lift."""
    touched = [moment for moment in moments if moment.fingers_N.any()]
    if not touched or not moments:
        return None
    last, start = moments[-1], moments[0]
    way = last.centre_mm - start.centre_mm
    sideways = float(np.linalg.norm(way[:2]))
    if last.fingers_N.any() or max(sideways, way[2]) < AWAY_MM:
        return None
    left = touched[-1].time_s
    direction = "sideways" if sideways >= way[2] else "upwards"
    far = max(sideways, float(way[2]))
    said = f"squeezed out {direction} at {left:.2f} s; it is {far:.0f} mm away"
    return Outcome(Kind.EJECTED, left, said)


def judge(moments: Sequence[Moment], *, complete: bool) -> Outcome | None:
    """The class of a grasp; None where it ended early and nothing is decided.

    Args:
        moments: all accepted steps, in order.
        complete: whether the last one is the end of the lift.
    """
    out = ejected(moments)
    if out is not None or not moments:
        return out
    lift = [moment for moment in moments if moment.lifting]
    up = [m for m in lift if m.rise_mm > HELD_MM and m.table_part < BORNE and m.fingers_N.any()]
    last = moments[-1]
    if up and (last.table_part >= BORNE or not last.fingers_N.any()):
        time_s = up[-1].time_s
        return Outcome(Kind.DROPPED, time_s, f"lost at {time_s:.2f} s, {up[-1].rise_mm:.0f} mm up")
    if not complete:
        return None
    if not up:
        said = "stayed on the table; " + (
            f"the fingers bore {100 * (1 - last.table_part):.0f} % of its weight at the end"
            if last.fingers_N.any()
            else "no finger touched it at the end"
        )
        return Outcome(Kind.NOT_LIFTED, lift[0].time_s if lift else last.time_s, said)
    before = [moment for moment in moments if not moment.lifting][-1]
    sunk = [m for m in lift if before.centre_mm[2] - m.centre_mm[2] > HELD_MM]
    fallen = float(before.centre_mm[2] - last.centre_mm[2])
    if sunk:
        said = f"sank by {fallen:.1f} mm against the fingers, and is held"
        return Outcome(Kind.SLIPPED, sunk[0].time_s, said)
    said = f"lifted by {last.rise_mm:.0f} mm; it moved by {abs(fallen):.2g} mm against the fingers"
    return Outcome(Kind.PICKED_UP, up[0].time_s, said)
