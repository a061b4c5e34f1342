"""The food as a rigid body: grasped, or an obstacle that stands beside a finger.

Grasped, it has a signed distance, skin, mass, inertia, and symmetry on the table. An obstacle has
a shape, a place, and contact with the skin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.fixture import SKIN
from dolfingrip.extensions.site import Site
from dolfingrip.foods.food import Food, Obstacle
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.contact.distance import SignedDistance, TurnedShape
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.pose import SIX, Pose
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


def grasped(food: Food, tipped_deg: float = 40.0) -> GraspedBody:
    """The food that a configuration asks for, on the table z = 0 below the gripper's centre.

    Args:
        food: shape, size, density and place of the food.
        tipped_deg: angle by which a body that does not lie still as it is drawn may turn to where
            it does.

    Returns:
        The body in coordinates about its centre of gravity (mm).

    Raises:
        MeshError: one line, if an STL file cannot be read.
    """
    shape, surface = food.shape.made(food.size_mm)
    lying = food.shape.lying
    upright = _stable(surface.points, tipped_deg) if lying is None else Rotation.from_rotvec(lying)
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


def _stable(points: np.ndarray, tipped_deg: float) -> Rotation:
    """The smallest turn with which a body lies still: its centre of gravity is lowest there.

    The face of its convex hull that is nearest to the centre has the centre above it (Goldberg et
    al., Part Pose Statistics, Int. J. Robotics Research 18, 1999).
    """
    hull = ConvexHull(points)
    normals, apart = hull.equations[:, :3], -hull.equations[:, 3]
    near = np.flatnonzero(normals[:, 2] < -math.cos(math.radians(tipped_deg)))
    down = normals[near[apart[near].argmin()]]
    axis = np.cross(down, [0.0, 0.0, -1.0])
    size = float(np.linalg.norm(axis))
    angle = math.atan2(size, -float(down[2]))
    return Rotation.from_rotvec(angle * axis / max(size, np.finfo(float).tiny))


MIRROR = np.array([1.0, -1.0, 1.0])
"""Factors from a point's coordinates to those of its image in y = 0."""


SIDEWAYS = frozenset({"y_mm", "turn_x_rad", "turn_z_rad"})
"""Coordinates of a body that have the other sign in its mirror image."""


def halved(config: Config, food: GraspedBody) -> bool:
    """Decide if half of a gripper is computed for the whole.

    Fingers B and C are mirror images in any pose of the gripper. Only with ``gripper.half = false``
    can left and right differ, for example as food is squeezed out sideways.

    Args:
        config: gripper and fingers.
        food: body that is grasped.

    Returns:
        True if half a thumb and one finger are computed for the whole gripper.

    Raises:
        ConfigError: one line, if half is asked for and something is not symmetric.
    """
    half = config.gripper.half
    uneven = "" if half is False else _uneven(config, food)
    if half and uneven:
        raise ConfigError(f"gripper.half = true: {uneven}; allowed: what is its own mirror image")
    return half is not False and not uneven


def _uneven(config: Config, food: GraspedBody) -> str:
    """Key and value of something that is not its own mirror image; "" if everything is."""
    if config.mesh.file is not None:
        return "mesh.file may be any solid"
    skew = [name for name, film in config.film.all.items() if not film.symmetric]
    if skew:
        return f"film.{skew[0]}.fibre_deg is not symmetric"
    if food.body.centre_mm[1]:
        return f"food.offset_y_mm = {food.body.centre_mm[1]:g}"
    apart = _apart_mm(food.shape, food.surface)
    return f"the food differs from its mirror image by {apart:.2g} mm" if apart > EVEN_MM else ""


def _apart_mm(shape: SignedDistance, surface: ClosedSurface) -> float:
    """How far a body is from its mirror image."""
    points = surface.points
    return float(np.abs(shape.at(points * MIRROR).value - shape.at(points).value).max())


EVEN_MM = 0.01
"""Difference from its mirror image that is not felt: a part of the barrier's width."""


WAYS = np.zeros((SIX, 2))
"""How its pose changes with the gap, away from the back, and with z."""
WAYS[0, 0], WAYS[2, 1] = -1.0, 1.0


def standing(obstacle: Obstacle) -> tuple[SignedDistance, ClosedSurface, float]:
    """Turn an obstacle as it stands, about its centre of gravity.

    Args:
        obstacle: of the configuration.

    Returns:
        Its distance, its surface (mm), and the distance of its centre from the back where the gap
        is 0 (mm).

    Raises:
        MeshError: one line, where an STL file cannot be read.
    """
    shape, surface = obstacle.shape.made(obstacle.size_mm)
    if obstacle.shape.lying is not None:
        turned = Rotation.from_rotvec(obstacle.shape.lying).as_matrix()
        shape, surface = TurnedShape(shape, turned), surface.turned(turned)
    return shape, surface, obstacle.barrier_mm + float(surface.points[:, 0].max())


def standing_surface(obstacle: Obstacle) -> ClosedSurface:
    """Return the surface (mm) of an obstacle where it stands, from the clamp's centre.

    Args:
        obstacle: of the configuration.

    Raises:
        MeshError: one line, where an STL file cannot be read.
    """
    _, surface, at_touch_mm = standing(obstacle)
    return surface.moved(np.array([-at_touch_mm - obstacle.gap_mm, 0.0, obstacle.z_mm]))


def beside(site: Site, obstacle: Obstacle) -> RigidContact:
    """Put an obstacle beside the back of a finger at rest, where x = 0.

    Args:
        site: of the finger, whose whole skin may touch it.
        obstacle: of the configuration.

    Returns:
        The contact, without friction. The obstacle stands still.

    Raises:
        ConfigError: one line, where half a finger is meshed and its halves would differ.
        MeshError: one line, where an STL file cannot be read.
    """
    shape, surface, at_touch_mm = standing(obstacle)
    apart = _apart_mm(shape, surface)
    if site.domain.half and apart > EVEN_MM:
        raise ConfigError(
            f"obstacle: it differs from its mirror image by {apart:.2g} mm; allowed: with "
            "mesh.half = false"
        )
    places = [site.fixed(obstacle.gap_mm), site.fixed(obstacle.z_mm)]
    site.parameters |= dict(zip(("obstacle.gap_mm", "obstacle.z_mm"), places, strict=True))
    barrier = Smooth(obstacle.barrier_mm, obstacle.stiffness_MPa)
    still = Pose(places, WAYS, np.array([-at_touch_mm, *np.zeros(SIX - 1)]))
    return RigidContact(site.u, site.domain, SKIN, shape, still, barrier)
