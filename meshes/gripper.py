"""The places of a gripper's fingers (section III.B and Fig. 5(c) of the paper).

Seen from above, O is the centre and the thumb A stands at (−L, 0). B and C turn about (0, ±W), at a
distance R: B stands at (R sin α, W + R cos α); C is its mirror image in y = 0. With α = 90°, the
pinch, both stand opposite to the thumb. With α = 0, the claw, the three stand on different sides.
The thumb's contact face is turned to O, those of the fingers to their rotation centres. All fingers
hang down and are clamped at the height of their length.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

from dolfingrip.meshes.solid import Floats
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.gripper import Gripper


class Stand(NamedTuple):
    """The place of a finger: its point X lies at R X + o.

    Attributes:
        name: thumb A, finger B or finger C.
        rotation: R, (3, 3); the finger's x points away from the food, its z down.
        origin_mm: o, (3,); the middle of its contact face is clamped there.
    """

    name: str
    rotation: Floats
    origin_mm: Floats

    @property
    def outward(self) -> Floats:
        """Unit vector in the plane of the table, from the food to the finger, (2,)."""
        return self.rotation[:2, 0]


def stands(
    gripper: Gripper, finger: Geometry, extent_mm: Callable[[Floats], float] | None = None
) -> list[Stand]:
    """The places of thumb A, finger B and finger C.

    Args:
        gripper: pose and distances of the fingers.
        finger: dimensions.
        extent_mm: returns how far from O the food reaches along a unit vector (2,) in the plane of
            the table; distances that the configuration leaves open follow from it.

    Raises:
        ConfigError: one line, if two fingers intersect, or a finger intersects the food.
    """
    alpha = math.radians(gripper.alpha)
    height = finger.length_mm + gripper.tip_height_mm
    across = np.array([math.sin(alpha), math.cos(alpha)])
    mirrored = across * [1, -1]

    def reach(given: float | None, less: float, *ways: Floats) -> float:
        if given is not None:
            return given
        reached = max(extent_mm(way) for way in ways) if extent_mm is not None else 0.0
        return max(reached + gripper.clearance - less, 0.0)

    thumb = reach(gripper.L_mm, 0.0, np.array([-1.0, 0.0]))
    radius = reach(gripper.R_mm, gripper.W_mm * across[1], across, mirrored)
    centre = np.array([0.0, gripper.W_mm])
    stands = [
        _stand("thumb A", np.array([-thumb, 0.0]), np.array([-1.0, 0.0]), height),
        _stand("finger B", centre + radius * across, across, height),
        _stand("finger C", -centre + radius * mirrored, mirrored, height),
    ]
    given = f"L_mm = {thumb:.4g}, W_mm = {gripper.W_mm:.4g}, R_mm = {radius:.4g}"
    said = f"gripper: {given}, alpha_deg = {gripper.alpha:g}"
    for one, other in combinations(stands, 2):
        if _overlap(_outline(one, finger), _outline(other, finger)):
            raise ConfigError(
                f"{said}: {one.name} and {other.name} intersect; "
                "allowed: larger distances, or an alpha_deg nearer to 90"
            )
    if extent_mm is not None:
        _refuse_touch(said, stands, extent_mm)
    return stands


def _refuse_touch(said: str, stands: Sequence[Stand], extent_mm: Callable[[Floats], float]) -> None:
    """Refuse straight fingers that touch the food: it must lie before each contact face's plane."""
    for stand in stands:
        room = float(stand.origin_mm[:2] @ stand.outward) - extent_mm(stand.outward)
        if room <= 0:
            raise ConfigError(
                f"{said}: {stand.name} stands in the food's way by {-room:.3g} mm; "
                "allowed: larger L_mm or R_mm, or another food.turn_deg"
            )


def _stand(name: str, place: Floats, outward: Floats, height_mm: float) -> Stand:
    x, z = np.append(outward, 0.0), np.array([0.0, 0.0, -1.0])
    rotation = np.stack([x, np.cross(z, x), z], axis=1)
    return Stand(name, rotation, np.append(place, height_mm))


def _outline(stand: Stand, finger: Geometry) -> Floats:
    """Corners of a straight finger seen from above, (4, 2)."""
    half = finger.width_mm / 2
    corners = np.array(
        [(x, y, 0.0) for x, y in ((0, -half), (finger.depth_mm, -half),
                                  (finger.depth_mm, half), (0, half))]
    )  # fmt: skip
    return np.asarray((corners @ stand.rotation.T + stand.origin_mm)[:, :2])


def _overlap(one: Floats, other: Floats) -> bool:
    """Return whether two convex polygons share a point: no edge's normal separates them."""
    for corners in (one, other):
        edges = np.roll(corners, -1, axis=0) - corners
        for normal in edges @ np.array([[0.0, -1.0], [1.0, 0.0]]):
            a, b = one @ normal, other @ normal
            if a.max() < b.min() or b.max() < a.min():
                return False
    return True
