"""The stages of a grasp: open and approach if asked, pressurise, settle, lift, settle."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

from dolfingrip.experiments.protocol.schedule import Stop, steps

if TYPE_CHECKING:
    from dolfingrip.config import Config
    from dolfingrip.experiments.protocol.schedule import GraspBranch

MOVED = 6
"""Number of readings while the table moves."""


def closing_starts_s(config: Config) -> float:
    """Return the time (s) at which the food is in place and the fingers begin to close.

    Args:
        config: with suction, the fingers open, settle and approach before.
    """
    gripper = config.gripper
    if not config.experiment.min_pressure_kPa:
        return 0.0
    return gripper.pressurise_s + gripper.settle_s + gripper.approach_mm / gripper.lift_mm_per_s


def lift_starts_s(config: Config) -> float:
    """Return the time (s) at which the lift begins.

    Args:
        config: of the grasp.
    """
    return closing_starts_s(config) + config.gripper.pressurise_s + config.gripper.settle_s


def table_z_mm(config: Config, time_s: float) -> float:
    """Return the height (mm) of the table seen from the gripper, 0 where the fingers close.

    Args:
        config: with the starts of approach and lift, their speed and their ways.
        time_s: time.
    """
    gripper = config.gripper
    left = (closing_starts_s(config) - time_s) * gripper.lift_mm_per_s
    way = (time_s - lift_starts_s(config)) * gripper.lift_mm_per_s
    return 0.0 - min(max(left, 0.0), gripper.approach_mm) - min(max(way, 0.0), gripper.lift_mm)


def stops(config: Config) -> Sequence[Stop]:
    """Stops of a grasp: steps to the highest pressure, a wait, the lift, a wait.

    With suction fingers open first, wait, and approach the food.

    Args:
        config: of the grasp.
    """
    gripper, experiment = config.gripper, config.experiment
    suction, largest = experiment.min_pressure_kPa, experiment.max_pressure_kPa
    found: list[Stop] = []

    def ramp(values: Sequence[float], start_s: float) -> None:
        ways = [abs(b - a) for a, b in pairwise(values)]
        for i, value in enumerate(values):
            part = sum(ways[:i]) / sum(ways)
            if i or not found:  # the approach ends where the second ramp starts
                time_s = start_s + gripper.pressurise_s * part
                branch: GraspBranch = "unloading" if i and value < values[i - 1] else "loading"
                found.append(Stop(value, time_s, branch))

    def move(value: float, start_s: float, way_mm: float, branch: GraspBranch) -> None:
        length_s = way_mm / gripper.lift_mm_per_s
        found.append(Stop(value, start_s, "hold"))
        for i in range(1, MOVED + 1):
            found.append(Stop(value, start_s + i * length_s / MOVED, branch))

    closing = steps(largest, experiment.step_kPa)
    if suction:
        opening = steps(suction, experiment.step_kPa)
        ramp(opening, 0.0)
        move(suction, gripper.pressurise_s + gripper.settle_s, gripper.approach_mm, "approach")
        ramp([*opening[::-1], *closing[1:]], closing_starts_s(config))
    else:
        ramp(closing, 0.0)
    move(largest, lift_starts_s(config), gripper.lift_mm, "lift")
    return [*found, Stop(largest, found[-1].time_s + gripper.settle_s, "hold")]
