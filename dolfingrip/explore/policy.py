"""The numbers of the explorer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final


@dataclass(frozen=True, slots=True)
class ExplorePolicy:
    """How the explorer behaves.

    Attributes:
        steps: readings up to the highest pressure, where a campaign has fewer.
        coarse_steps: readings up to the highest pressure on the coarse mesh.
        pressures: ends of the slider of the highest pressure, by the configured one.
        neighbours: solved designs that one is interpolated between.
        looked_at: solved designs, the nearest, among which those of one mesh are looked for.
        checked: solved designs from which on the interpolation's error is estimated.
        same: distance of two designs, in shares of the sliders' ranges, up to which they are one.
        outside: distance from the solved designs' hull, in the same shares, up to which a design
            counts as lying among them.
        grasp_kPa: highest pressure of a grasp where none is asked for.
        grasp_step_kPa: between readings of a grasp.
    """

    steps: int = 12
    coarse_steps: int = 4
    pressures: tuple[float, float] = (0.1, 2.0)
    neighbours: int = 12
    looked_at: int = 40
    checked: int = 4
    same: float = 1e-6
    outside: float = 0.02
    grasp_kPa: float = 150.0
    grasp_step_kPa: float = 25.0


POLICY: Final = ExplorePolicy()
