"""The outcome of a grasp: one of five classes, its time, and a sentence."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.files.run import GraspKind, GraspOutcome

HELD_MM: Final = 1.0
"""Way by which a held object may sink against the fingers; a lower rise is no lift."""

AWAY_MM: Final = 15.0
"""Distance from the start beyond which an object that no finger touches has left the fingers."""

LOST_MM: Final = 5.0
"""Way since a finger touched it last beyond which an object is lost in the lift; one that bounces
between fingers is touched again on a shorter way."""

BORNE: Final = 0.01
"""The fingers bear an object if the table bears a smaller part of its weight than this."""

PUSHED: Final = 0.5
"""Fingers only push an object if the table bears a larger part of its weight than this."""

LEAVING_MM_PER_S: Final = 20.0
"""Smallest speed of an object that is being squeezed out."""

LEAVING_STEPS: Final = 2
"""Number of steps that show that speed."""

AHEAD: Final = 0.5
"""A finger stands in an object's way if the cosine of the angle between both is larger."""


EARLY = " (the computation ended there)"
"""Added to the sentence if the class follows from the last step of a run that ended early."""


@dataclass(frozen=True, slots=True)
class Moment:
    """One accepted step of a grasp.

    Attributes:
        time_s: time of the step.
        lifting: whether the lift has begun.
        centre_mm: (3,) centre of the object, seen from the gripper.
        rise_mm: height of the object above where it stood on the table.
        fingers_N: (k,) normal force of each finger.
        table_part: part of the weight that the table bears.
    """

    time_s: float
    lifting: bool
    centre_mm: np.ndarray
    rise_mm: float
    fingers_N: np.ndarray
    table_part: float


@dataclass(frozen=True)
class Ring:
    """The places of the fingers around the object, seen from above.

    Attributes:
        radius_mm: distance of the nearest finger's clamp from the middle. An object on the table
            that lies farther out has left the fingers, even if one of them still pushes it.
        outward: (k, 2) unit vectors from the middle to the fingers.
    """

    radius_mm: float
    outward: np.ndarray

    def is_open(self, way: np.ndarray) -> bool:
        """Tell if no finger stands in the way of an object that moves along (2,) ``way``."""
        length = float(np.linalg.norm(way))
        return bool((self.outward @ way < AHEAD * length).all())


NOWHERE = Ring(np.inf, np.zeros((1, 2)))
"""Fingers whose places are not known."""


def ejected(moments: Sequence[Moment], ring: Ring = NOWHERE) -> GraspOutcome | None:
    """Tell if the object has left the fingers sideways or upwards, before or in the lift.

    It has left them if no finger touches it any more and it is far away, if it lies outside of them
    on the table, or if it rolls out between them ever faster.

    Args:
        moments: all accepted steps so far, in order.
        ring: where the fingers stand.
    """
    touched = [moment for moment in moments if moment.fingers_N.any()]
    if not touched:
        return None
    last, way = moments[-1], moments[-1].centre_mm - moments[0].centre_mm
    sideways, upwards = float(np.linalg.norm(way[:2])), float(way[2])
    on_table = last.table_part > PUSHED
    away = max(sideways, upwards) >= AWAY_MM
    gone = away and not last.fingers_N.any()
    pushed = on_table and sideways >= ring.radius_mm
    speed = _speed_mm_per_s(moments)
    rolls = on_table and sideways >= AWAY_MM and speed > 0 and ring.is_open(way[:2])
    if not (gone or pushed or (rolls and ring is not NOWHERE)):
        return None
    left = touched[-1].time_s
    direction = "sideways" if sideways >= upwards else "upwards"
    said = f"squeezed out {direction} at {left:.2f} s; it is {max(sideways, upwards):.0f} mm away"
    return GraspOutcome(GraspKind.EJECTED, left, said)


def _speed_mm_per_s(moments: Sequence[Moment]) -> float:
    """Speed of an object that leaves the middle of the fingers ever faster; 0 if it does not."""
    last = moments[-LEAVING_STEPS - 1 :]
    if len(last) <= LEAVING_STEPS:
        return 0.0
    places = np.array([moment.centre_mm[:2] - moments[0].centre_mm[:2] for moment in last])
    rates = np.diff(np.linalg.norm(places, axis=1)) / np.diff([m.time_s for m in last])
    faster = rates.min() >= LEAVING_MM_PER_S and rates[-1] >= rates[0]
    return float(rates[-1]) if faster else 0.0


def judge(
    moments: Sequence[Moment], *, complete: bool, ring: Ring = NOWHERE
) -> GraspOutcome | None:
    """The outcome of a grasp; None if it ended early and its class is not decided.

    If the computation ended early, the last accepted step decides the class. It can do so if the
    object is being squeezed out, or if the lift has begun.

    Args:
        moments: all accepted steps, in order.
        complete: whether the last one is the end of the lift.
        ring: where the fingers stand.
    """
    out = ejected(moments, ring)
    if out is not None or not moments:
        return out
    if not complete:
        leaving = _leaving(moments)
        if leaving is not None:
            return leaving
    lift = [moment for moment in moments if moment.lifting]
    up = [moment for moment in lift if _is_up(moment) and moment.fingers_N.any()]
    last = moments[-1]
    if up and (last.table_part >= BORNE or not last.fingers_N.any()):
        time_s = up[-1].time_s
        return GraspOutcome(
            GraspKind.DROPPED, time_s, f"lost at {time_s:.2f} s, {up[-1].rise_mm:.0f} mm up"
        )
    if not complete and not (up or _left_behind(moments)):
        return None
    early = "" if complete else EARLY
    if not up:
        said = "stayed on the table; " + (
            f"the fingers bore {100 * (1 - last.table_part):z.0f} % of its weight at the end"
            if last.fingers_N.any()
            else "no finger touched it at the end"
        )
        time_s = lift[0].time_s if lift else last.time_s
        return GraspOutcome(GraspKind.NOT_LIFTED, time_s, said + early)
    return _borne(moments, up[0].time_s, early)


def decided(moments: Sequence[Moment], ring: Ring = NOWHERE) -> bool:
    """Tell if the class will not change any more, as the object has left the fingers.

    Args:
        moments: all accepted steps so far, in order.
        ring: where the fingers stand.
    """
    if ejected(moments, ring) is not None:
        return True
    touched = [moment for moment in moments if moment.fingers_N.any()]
    if not touched or not any(_is_up(moment) for moment in moments if moment.lifting):
        return False
    since_mm = float(np.linalg.norm(moments[-1].centre_mm - touched[-1].centre_mm))
    return since_mm > LOST_MM


def _is_up(moment: Moment) -> bool:
    """Tell if the object is off the table, and the table bears nothing of it."""
    return moment.rise_mm > HELD_MM and moment.table_part < BORNE


def _borne(moments: Sequence[Moment], up_s: float, early: str) -> GraspOutcome:
    """The outcome if the fingers bear the object at the end: picked up or slipped."""
    last, before = moments[-1], [moment for moment in moments if not moment.lifting][-1]
    fallen = float(before.centre_mm[2] - last.centre_mm[2])
    lift = [moment for moment in moments if moment.lifting]
    sunk = [m for m in lift if before.centre_mm[2] - m.centre_mm[2] > HELD_MM]
    if sunk:
        said = f"sank by {fallen:z.1f} mm against the fingers, and is held"
        return GraspOutcome(GraspKind.SLIPPED, sunk[0].time_s, said + early)
    said = f"lifted by {last.rise_mm:.0f} mm; it moved by {abs(fallen):.2g} mm against the fingers"
    return GraspOutcome(GraspKind.PICKED_UP, up_s, said + early)


def _leaving(moments: Sequence[Moment]) -> GraspOutcome | None:
    """The outcome if the object was leaving the fingers ever faster at the last step, else None."""
    way = moments[-1].centre_mm - moments[0].centre_mm
    sideways, speed = float(np.linalg.norm(way[:2])), _speed_mm_per_s(moments)
    if speed <= 0 or sideways < HELD_MM:
        return None
    said = f"on its way out sideways at {speed:.0f} mm/s, {sideways:.0f} mm away"
    return GraspOutcome(GraspKind.EJECTED, moments[-1].time_s, said + EARLY)


def _left_behind(moments: Sequence[Moment]) -> bool:
    """Tell if the table, in the lift, took the object along by more than it may sink."""
    lift = [moment for moment in moments if moment.lifting]
    if not lift:
        return False
    before = [moment for moment in moments if not moment.lifting][-1]
    return float(before.centre_mm[2] - lift[-1].centre_mm[2]) > HELD_MM
