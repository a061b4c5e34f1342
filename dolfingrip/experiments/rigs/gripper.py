"""The gripper's model: three fingers, what they grasp, and the table that it lies on."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.grasped import GraspedBody, grasped
from dolfingrip.experiments.rigs.material import KG_M3_M_S2
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.contact.distance import Plane
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.rigid_points import RigidPoints
from dolfingrip.mechanics.model.dead_weight import DeadWeight
from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.placement import Placement
from dolfingrip.mechanics.model.pose import Pose
from dolfingrip.mechanics.model.rigid_body import RigidMotion
from dolfingrip.meshes.copies import side_by_side
from dolfingrip.meshes.gripper import Stand, stands

GRAVITY_M_S2 = 9.81

RESTRAINT_MM = 1.0
"""See :class:`~dolfingrip.mechanics.model.rigid_body.RigidMotion`."""

SKIN = ("skin", "tip")
"""Regions of a finger that may touch food."""


@dataclass(slots=True)
class GripperModel:
    """Fingers, food and table.

    The gripper stands still and the table moves, so that clamps stay where they are.

    Attributes:
        model: what is solved.
        finger: the model of all fingers without food, of which ``model`` has the terms.
        stands: where the fingers stand.
        grasped: the food.
        pose: of the food.
        motion: its weight and inertia.
        contact: of the fingers with the food.
        rubbing: friction there.
        table: contact of the food with the table.
        table_rubbing: friction there.
    """

    model: Model
    finger: FingerModel
    stands: Sequence[Stand]
    grasped: GraspedBody
    pose: Pose
    motion: RigidMotion
    contact: RigidContact
    rubbing: Friction
    table: RigidPoints
    table_rubbing: Friction

    @property
    def placement(self) -> Placement:
        """Where the fingers stand, as the reference mesh has it."""
        placement = self.model.domain.placement
        assert placement is not None
        return placement


def build_gripper(config: Config, comm: MPI.Comm) -> GripperModel:
    """The model that a configuration asks for.

    Raises:
        ConfigError: on every rank, one line.
    """
    food = grasped(config.food)
    found = stands_of(config, food)
    domain = _fingers(config, comm, found)
    finger = build(config, domain, plate=False)
    u, gripper = finger.model.u, config.gripper
    pose = food.body.pose(domain.mesh)
    for constant, turn in zip(pose.constants[3:], food.turn, strict=True):
        constant.value = turn
    height = fem.Constant(domain.mesh, PETSc.ScalarType(0.0))
    up = np.array([[0, 0, 1, 0, 0, 0.0]]).T
    table_pose = Pose([height], up, np.zeros(6))
    barrier = Smooth(gripper.barrier_mm, gripper.stiffness_MPa)
    contact = RigidContact(u, domain, SKIN, food.shape, pose, barrier)
    skin = food.surface
    table = RigidPoints(
        u, skin.points, skin.point_areas_mm2(), pose, Plane((0.0, 0.0, 1.0)), table_pose, barrier
    )
    gravity = np.array([0.0, 0.0, -GRAVITY_M_S2])
    _stand(pose, table, -float(gravity[2]) * food.body.mass_kg, gripper.barrier_mm)
    motion = RigidMotion(food.body, pose, gravity, comm, restraint_mm=RESTRAINT_MM)
    rubbing, table_rubbing = (
        Friction(touch, u, fem.Constant(domain.mesh, PETSc.ScalarType(coefficient)), title=title)
        for touch, coefficient, title in (
            (contact, config.food.friction, "friction on fingers"),
            (table, config.food.table_friction, "friction on the table"),
        )
    )
    weight = config.material.density_kg_m3 * KG_M3_M_S2 * gravity
    further = [DeadWeight(u, domain, weight), motion, contact, rubbing, table, table_rubbing]
    fingers = finger.model
    model = replace(
        fingers,
        terms=[*fingers.terms, *further],
        numbers=[*fingers.numbers, *pose.free],
        controls={**fingers.controls, "table_z_mm": Control(height)},
    )
    return GripperModel(
        model, finger, found, food, pose, motion, contact, rubbing, table, table_rubbing
    )


def _stand(pose: Pose, table: RigidPoints, weight_N: float, width_mm: float) -> None:
    """Put the food where the table's barrier bears its weight."""
    lowest = float(pose.constants[2].value)

    def excess_N(height_mm: float) -> float:
        pose.constants[2].value = lowest + height_mm
        return float(table.load_N()[2]) - weight_N

    brentq(excess_N, 1e-6 * width_mm, width_mm, xtol=1e-9 * width_mm)


def _extent(food: GraspedBody) -> Callable[[np.ndarray], float]:
    """How far food reaches along a way in the plane of the table, where it is put."""
    points = Rotation.from_rotvec(food.turn).apply(food.surface.points)[:, :2]
    points = points + np.array(food.body.centre_mm[:2])
    return lambda way: float((points @ way).max())


def stands_of(config: Config, food: GraspedBody) -> list[Stand]:
    """Where the fingers of a configuration stand around its food.

    Raises:
        ConfigError: one line, where they cannot.
    """
    return stands(config.gripper, config.adapted().finger, _extent(food))


def _fingers(config: Config, comm: MPI.Comm, found: Sequence[Stand]) -> Domain:
    """One reference mesh of all fingers, side by side."""
    mesh = on_root(comm, lambda: side_by_side(solid(config), len(found)))
    domain = distribute(comm, mesh)
    rotations = np.array([stand.rotation for stand in found])
    origins = np.array([stand.origin_mm for stand in found])
    return replace(domain, placement=Placement.of(domain.mesh.geometry.x, rotations, origins))
