"""The stages of a grasp: pressurise, settle, lift, settle."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from dolfingrip.experiments.protocol.schedule import Stop, steps
from dolfingrip.sections.gripper import Gripper

if TYPE_CHECKING:
    from dolfingrip.config import Config

LIFTED = 6
"""Number of readings during the lift."""


def lift_starts_s(gripper: Gripper) -> float:
    """Return the time (s) at which the lift begins."""
    return gripper.pressurise_s + gripper.settle_s


def lift_mm(gripper: Gripper, time_s: float) -> float:
    """Return the height (mm) by which the gripper has been lifted.

    Args:
        gripper: section with the lift's start, speed and height.
        time_s: time.
    """
    way = (time_s - lift_starts_s(gripper)) * gripper.lift_mm_per_s
    return min(max(way, 0.0), gripper.lift_mm)


def stops(config: Config) -> Sequence[Stop]:
    """Stops of a grasp: steps to the highest pressure, a wait, the lift, a wait."""
    gripper, largest = config.gripper, config.experiment.max_pressure_kPa
    found = [
        Stop(value, gripper.pressurise_s * value / largest, "loading")
        for value in steps(largest, config.experiment.step_kPa)
    ]
    start = lift_starts_s(gripper)
    end = start + gripper.lift_mm / gripper.lift_mm_per_s
    times = [start + part * (end - start) / LIFTED for part in range(LIFTED + 1)]
    lift = [Stop(largest, time_s, "lift") for time_s in times[1:]]
    return [
        *found,
        Stop(largest, start, "hold"),
        *lift,
        Stop(largest, end + gripper.settle_s, "hold"),
    ]
