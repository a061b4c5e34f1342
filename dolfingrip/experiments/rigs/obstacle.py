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
from dolfingrip.mechanics.contact.distance import TurnedShape
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.model.pose import SIX, Pose

EVEN_MM = 0.01
"""Difference from its mirror image that is not felt: a part of the barrier's width."""


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
    shape, surface = obstacle.shape.made(obstacle.size_mm)
    if obstacle.shape.lying is not None:
        turned = Rotation.from_rotvec(obstacle.shape.lying).as_matrix()
        shape, surface = TurnedShape(shape, turned), surface.turned(turned)
    points = surface.points
    apart = float(np.abs(shape.at(points * MIRROR).value - shape.at(points).value).max())
    if site.domain.half and apart > EVEN_MM:
        raise ConfigError(
            f"obstacle: it differs from its mirror image by {apart:.2g} mm; allowed: with "
            "mesh.half = false"
        )
    away_mm = obstacle.gap_mm + obstacle.barrier_mm + float(points[:, 0].max())
    place = np.array([-away_mm, 0.0, obstacle.z_mm, 0.0, 0.0, 0.0])
    barrier = Smooth(obstacle.barrier_mm, obstacle.stiffness_MPa)
    still = Pose([], np.zeros((SIX, 0)), place)
    return RigidContact(site.u, site.domain, SKIN, shape, still, barrier)
