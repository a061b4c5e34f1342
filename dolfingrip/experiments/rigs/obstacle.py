"""What stands beside a finger: its shape, where it stands, and the contact with the skin."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from dolfingrip.config import ConfigError
from dolfingrip.experiments.rigs.fixture import SKIN
from dolfingrip.experiments.rigs.grasped import MIRROR
from dolfingrip.extensions.site import Site
from dolfingrip.foods.food import Obstacle
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.contact.distance import SignedDistance, TurnedShape
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.pose import SIX, Pose
from dolfingrip.meshes.closed_surface import ClosedSurface

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
    points = surface.points
    apart = float(np.abs(shape.at(points * MIRROR).value - shape.at(points).value).max())
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
