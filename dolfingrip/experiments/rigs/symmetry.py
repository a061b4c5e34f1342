"""Whether a gripper with its food is its own mirror image in the plane y = 0."""

from __future__ import annotations

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.grasped import GraspedBody
from dolfingrip.foods.policy import FOOD_SHAPE

MIRROR = np.array([1.0, -1.0, 1.0])
"""Factors from a point's coordinates to those of its image in y = 0."""


SIDEWAYS = frozenset({"y_mm", "turn_x_rad", "turn_z_rad"})
"""Coordinates of a body that have the other sign in its mirror image."""


def halved(config: Config, food: GraspedBody) -> bool:
    """Whether half a thumb and one finger are computed for the whole gripper.

    Fingers B and C are mirror images in any pose of the gripper. Only with ``gripper.half = false``
    can left and right differ, for example as food is squeezed out sideways.

    Raises:
        ConfigError: one line, if half is asked for and something is not symmetric.
    """
    asked = config.gripper.half
    uneven = "" if asked is False else _uneven(config, food)
    if asked and uneven:
        raise ConfigError(f"gripper.half = true: {uneven}; allowed: what is its own mirror image")
    return asked is not False and not uneven


def _uneven(config: Config, food: GraspedBody) -> str:
    """Key and value of something that is not its own mirror image; "" if everything is."""
    if config.mesh.file is not None:
        return "mesh.file may be any solid"
    skew = [name for name, film in config.film.all.items() if not film.symmetric]
    if skew:
        return f"film.{skew[0]}.fibre_deg is not symmetric"
    if food.body.centre_mm[1]:
        return f"food.offset_y_mm = {food.body.centre_mm[1]:g}"
    points = food.surface.points
    apart = food.shape.at(points * MIRROR).value - food.shape.at(points).value
    most = float(np.abs(apart).max())
    if most > FOOD_SHAPE.even_mm:
        return f"the food differs from its mirror image by {most:.2g} mm"
    return ""
