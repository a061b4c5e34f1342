"""Numbers of the searches that grasps decide."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GraspSearch:
    """Where the least pressure or friction that picks food up is searched for.

    Attributes:
        lift_mm: way up in a trial; what slips does so within the first millimetres.
        highest_kPa: pressure above which none is tried; the paper's highest.
        largest_pressure_kPa: that a user may ask for.
        largest_friction: coefficient above which none is tried.
        estimates: grasps at most from which the pressure is estimated, before others confirm it.
    """

    lift_mm: float = 10.0
    highest_kPa: float = 300.0
    largest_pressure_kPa: float = 1000.0
    largest_friction: float = 2.0
    estimates: int = 4
