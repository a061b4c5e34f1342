"""The food as a rigid body: its signed distance, skin, mass and inertia."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from dolfingrip.foods.food import Food
from dolfingrip.foods.policy import FOOD_SHAPE
from dolfingrip.mechanics.contact.distance import SignedDistance
from dolfingrip.mechanics.contact.turned_shape import TurnedShape
from dolfingrip.mechanics.model.rigid_body import RigidBody
from dolfingrip.meshes.closed_surface import MM3_PER_M3, ClosedSurface

NAME = "object"


@dataclass(frozen=True)
class GraspedBody:
    """The food as it is put on the table, in coordinates about its centre of gravity.

    Attributes:
        shape: signed distance of the food.
        surface: skin of the food, whose points have the distance 0.
        body: mass, inertia, and place at the start, on the table z = 0.
    """

    shape: SignedDistance
    surface: ClosedSurface
    body: RigidBody


def grasped(food: Food) -> GraspedBody:
    """The food that a configuration asks for, on the table z = 0 below the gripper's centre.

    Raises:
        MeshError: one line, if an STL file cannot be read.
    """
    shape, surface = food.shape.made(food.size_mm)
    lying = food.shape.lying
    upright = _stable(surface.points) if lying is None else Rotation.from_rotvec(lying)
    turned = Rotation.from_rotvec([0, 0, math.radians(food.turn_deg)]) * upright
    if turned.magnitude() > 0:
        shape = TurnedShape(shape, turned.as_matrix())
        surface = surface.turned(turned.as_matrix())
    per_mm3 = food.density / MM3_PER_M3
    lowest = float(surface.points[:, 2].min())
    body = RigidBody(
        NAME,
        per_mm3 * surface.volume_mm3,
        per_mm3 * surface.inertia_mm5(),
        (food.offset_x_mm, food.offset_y_mm, -lowest),
    )
    return GraspedBody(shape, surface, body)


def _stable(points: np.ndarray) -> Rotation:
    """The smallest turn with which a body lies still: its centre of gravity is lowest there.

    The face of its convex hull that is nearest to the centre has the centre above it (Goldberg et
    al., Part Pose Statistics, Int. J. Robotics Research 18, 1999).
    """
    hull = ConvexHull(points)
    normals, apart = hull.equations[:, :3], -hull.equations[:, 3]
    near = np.flatnonzero(normals[:, 2] < -math.cos(math.radians(FOOD_SHAPE.tipped_deg)))
    down = normals[near[apart[near].argmin()]]
    axis = np.cross(down, [0.0, 0.0, -1.0])
    size = float(np.linalg.norm(axis))
    angle = math.atan2(size, -float(down[2]))
    return Rotation.from_rotvec(angle * axis / max(size, np.finfo(float).tiny))
