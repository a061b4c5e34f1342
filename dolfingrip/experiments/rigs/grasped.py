"""The food as a rigid body: its signed distance, skin, mass and inertia."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from dolfingrip.experiments.rigs.policy import FOOD_SHAPE
from dolfingrip.mechanics.contact.distance import (
    BentCapsule,
    Capsule,
    RoundedBox,
    SignedDistance,
)
from dolfingrip.mechanics.contact.sampled_distance import SampledDistance
from dolfingrip.mechanics.contact.turned_shape import TurnedShape
from dolfingrip.mechanics.model.rigid_body import RigidBody
from dolfingrip.meshes import closed_surface
from dolfingrip.meshes.closed_surface import MM3_PER_M3, ClosedSurface, level_set
from dolfingrip.meshes.food import potato
from dolfingrip.sections.food import Food

NAME = "object"


LYING = Rotation.from_rotvec([-math.pi / 2, 0, 0])
"""A sausage's own axis is z; it lies along y."""


@dataclass(frozen=True)
class GraspedBody:
    """What is grasped, as it is put there, with its centre of gravity at the origin.

    Attributes:
        shape: its signed distance.
        surface: its skin, on the zeros of that distance.
        body: mass, inertia, and where it stands at first: on the table z = 0.
    """

    shape: SignedDistance
    surface: ClosedSurface
    body: RigidBody


def grasped(food: Food) -> GraspedBody:
    """The food that a configuration asks for, on the table z = 0 below the gripper's centre.

    Raises:
        MeshError: one line, where an STL file is none.
    """
    shape, surface = _shape(food)
    upright = LYING if food.kind.startswith("sausage") else Rotation.identity()
    if food.kind not in ("cube", "sausage-short", "sausage-long"):
        upright = _stable(surface.points)
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
    """The least turn to where a body lies still: the lowest centre of gravity within reach.

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


def _shape(food: Food) -> tuple[SignedDistance, ClosedSurface]:
    """Distance and skin, the centre of gravity at the origin."""
    half = np.array(food.size_mm) / 2
    if food.kind == "cube":
        box = RoundedBox((half[0], half[1], half[2]), food.edge_radius_mm)
        return box, _skin(box, half)
    if food.kind.startswith("sausage"):
        return _sausage(food)
    if food.kind == "file":
        assert food.file is not None
        source = closed_surface.read(food.file)
        smoothing = food.smoothing_mm
    else:
        source, smoothing = potato(food.size_mm, food.bump_mm, food.seed), 0.0
    source = source.moved(-source.centre_mm)
    beyond = FOOD_SHAPE.margin_cells * food.grid_mm + smoothing
    low, high = source.points.min(axis=0) - beyond, source.points.max(axis=0) + beyond
    sampled = SampledDistance.of(source.distances_mm, low, high, food.grid_mm, smoothing)
    return sampled, _skin(sampled, np.maximum(-low, high) - food.grid_mm)


def _sausage(food: Food) -> tuple[SignedDistance, ClosedSurface]:
    width, length, _ = food.size_mm
    radius, straight = width / 2, (length - width) / 2
    half = np.array([radius, radius, length / 2])
    if food.bend_radius_mm is None:
        capsule = Capsule(radius, straight)
        return capsule, _skin(capsule, half)
    bent = BentCapsule(radius, straight, food.bend_radius_mm)
    half[0] += food.bend_radius_mm * (1 - math.cos(straight / food.bend_radius_mm))
    place = -float(_skin(bent, half).centre_mm[0])
    bent = BentCapsule(radius, straight, food.bend_radius_mm, place)
    return bent, _skin(bent, half)


def _skin(shape: SignedDistance, half_mm: np.ndarray) -> ClosedSurface:
    """Zeros of a distance within a box about the origin, in triangles fit for its size."""
    size_mm = half_mm.prod() ** (1 / 3)
    spacing_mm = float(
        np.clip(
            size_mm / FOOD_SHAPE.divisions,
            FOOD_SHAPE.least_spacing_mm,
            FOOD_SHAPE.largest_spacing_mm,
        )
    )

    def found(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        distances = shape.at(points)
        return distances.value, distances.gradient

    # off the grid's planes, lest they lie in a flat face
    reach = half_mm + 1.37 * spacing_mm
    return level_set(found, -reach, reach, spacing_mm)
