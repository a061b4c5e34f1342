"""What stands beside a finger in its pictures: force sensor, curves, an obstacle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.food import standing_surface
from dolfingrip.files.run import PlatePose
from dolfingrip.foods.kind import FoodKind
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.report.skin import Floats


@dataclass(frozen=True)
class Plate:
    """The force sensor as drawn.

    Attributes:
        point_mm: any point of its face.
        normal: of its face, towards the finger; any length but zero.
        contact_length_mm: length of the finger that faces it, from the tip; it is drawn twice as
            long, half of it beyond the tip.
    """

    point_mm: Sequence[float]
    normal: Sequence[float] = (1.0, 0.0, 0.0)
    contact_length_mm: float = 10.0


@dataclass(frozen=True)
class Beside:
    """Things that are drawn beside a finger.

    Attributes:
        plate: force sensor.
        curves: x and z (mm) of points, (n, 2) each, of lines beside the finger's nearer side.
        food: surface (mm) of an obstacle.
        food_colour: of the obstacle.
    """

    plate: Plate | None = None
    curves: Sequence[Floats] = ()
    food: ClosedSurface | None = None
    food_colour: str = FoodKind.colour

    @classmethod
    def of_run(cls, config: Config, pose: PlatePose | None) -> Beside:
        """Find what stood beside the finger of a run.

        Args:
            config: of the run.
            pose: of the force sensor; None: there was none.
        """
        plate, food, colour = None, None, FoodKind.colour
        if pose is not None:
            plate = Plate(pose.point_mm, pose.normal, config.plate.contact_length_mm)
        if config.obstacle is not None:
            food, colour = standing_surface(config.obstacle), config.obstacle.shape.colour
        curves = () if config.curve is None else config.curve.lines
        return cls(plate, [np.asarray(line) for line in curves], food, colour)


ALONE: Final = Beside()
"""Nothing beside a finger."""
