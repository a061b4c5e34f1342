"""The gripper's model: three fingers, the food that they grasp, and the table under it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np
from dolfinx import fem
from mpi4py import MPI
from scipy.optimize import brentq

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.protocol import Lift, lift_starts_s, table_z_mm
from dolfingrip.experiments.rigs.finger import Additions, FingerModel, build
from dolfingrip.experiments.rigs.fixture import SKIN
from dolfingrip.experiments.rigs.food import SIDEWAYS, GraspedBody, grasped, halved
from dolfingrip.experiments.rigs.materials import REST, weight_name, weight_value
from dolfingrip.experiments.rigs.undeformed import Made, made, side_by_side, spread
from dolfingrip.extensions.site import Site
from dolfingrip.forms import inertia
from dolfingrip.mechanics.contact.density import Smooth
from dolfingrip.mechanics.contact.distance import Plane
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.contact.rigid import RigidContact
from dolfingrip.mechanics.contact.rigid_points import RigidPoints
from dolfingrip.mechanics.contact.tangential import Touching
from dolfingrip.mechanics.model.assembly import box
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.placement import Placement
from dolfingrip.mechanics.model.pose import Pose
from dolfingrip.mechanics.model.rigid_body import RigidMotion
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.meshes.gripper import Stand, stands

GRAVITY_M_S2, DOWN = 9.81, (0.0, 0.0, -1.0)
"""Direction of gravity in the laboratory's frame, in which the fingers hang."""

UPWARDS = Plane((0.0, 0.0, 1.0))
"""Signed distance of the table."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RisingTable(Control):
    """The table's height, which takes the food along where a step would put it into the food.

    The food's own motion is solved for; this is where Newton's method starts.

    Attributes:
        table: contact of the food with it.
    """

    table: RigidPoints

    def set(self, value: float) -> None:
        """Prescribe the height (mm)."""
        rise = value - self.value
        Control.set(self, value)
        if self.table.gaps_mm(np.empty(0)).min() <= 0:
            self.table.pose.constants[2].value += rise


@dataclass(frozen=True, slots=True)
class Acceleration(Memory):
    """A gripper's acceleration in the lift: in its frame, fingers and food weigh more by it.

    Attributes:
        config: with the lift.
        site: of the fingers, whose weights are constants of it.
        motion: of the food.
        height: of the table, seen from the gripper.
    """

    config: Config
    site: Site
    motion: RigidMotion
    height: fem.Constant

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set weights and height; between stops the table's way is curved."""
        time_s -= SETTLING_S
        rate = Lift.of(self.config).acceleration_mm_per_s2(time_s - lift_starts_s(self.config))
        more = 1 + 1e-3 * rate / GRAVITY_M_S2
        self.motion.gravity_m_s2[:] = more * GRAVITY_M_S2 * np.array(DOWN)
        self.height.value = table_z_mm(self.config, time_s)
        for part in (REST, *self.config.material.own):
            constant = self.site.parameters.get(weight_name(part))
            if constant is not None:
                constant.value = more * weight_value(self.site.config, part)


ONE_FINGER = "skin of finger B"
"""Region of a half gripper that may touch its own mirror image."""


SETTLING_S: Final = 0.1
"""Time before the first stop, in which fingers and food come to rest."""

RESOLVED: Final = 0.01
"""Largest error of a step of the food's motion, as a part of the width of its barrier. With 2.5
times as much, food that bounces gains energy."""

RESTRAINT_MM: Final = 1.0
"""See :class:`~dolfingrip.mechanics.model.rigid_body.RigidMotion`."""


@dataclass(slots=True)
class GripperModel:
    """Fingers, food and table.

    The gripper stands still and the table moves, so that clamps stay in place. If the gripper is
    its own mirror image, half a thumb and finger B are meshed (``model.domain.half``).

    Attributes:
        finger: model of all fingers, with the food and the table.
        stands: places of the fingers.
        motion: weight and inertia of the food.
        contact: contact of the fingers with the food.
        finger_friction: friction of this contact.
        table: contact of the food with the table.
        table_friction: friction of this contact.
    """

    finger: FingerModel
    stands: Sequence[Stand]
    motion: RigidMotion
    contact: RigidContact
    finger_friction: Friction
    table: RigidPoints
    table_friction: Friction

    @property
    def model(self) -> Model:
        """Model that is solved."""
        return self.finger.model

    @property
    def pose(self) -> Pose:
        """Pose of the food."""
        return self.motion.pose

    @property
    def placement(self) -> Placement:
        """The places of the fingers in the reference mesh."""
        placement = self.model.domain.placement
        assert placement is not None
        return placement


def build_gripper(config: Config, comm: MPI.Comm) -> GripperModel:
    """Build the model that a configuration asks for.

        Π = Π_fingers + Π_motion + Π_contact + Π_finger_friction + Π_table + Π_table_friction
            + Π_mirror

    Π_fingers is the potential of all fingers with their weight (:func:`~.finger.total_potential`),
    and Π_motion that of the food's weight and inertia. The food touches fingers and table. In half
    a gripper a finger may touch its own mirror image.

    Args:
        config: gripper, fingers and food.
        comm: ranks to run on.

    Returns:
        The model; food and fingers do not touch.

    Raises:
        ConfigError: on every rank, one line.
    """
    if config.obstacle is not None:
        raise ConfigError("obstacle: allowed: beside a single finger; a gripper has [food]")
    food = grasped(config.food)
    stands = stands_of(config, food)
    domain = _fingers(config, comm, stands, half=halved(config, food))
    hung = config.changed(gravity={"acceleration_m_s2": GRAVITY_M_S2, "direction": DOWN})
    grasps: list[_Grasp] = []

    def adds(site: Site) -> Additions:
        grasps.append(_grasp(config, food, site, comm))
        return grasps[0].additions

    finger = build(hung, domain, plate=False, adds=adds)
    return GripperModel(finger, stands, *grasps[0][:-1])


class _Grasp(NamedTuple):
    """Food and table among the fingers, in the order of :class:`GripperModel`'s attributes."""

    motion: RigidMotion
    contact: RigidContact
    finger_friction: Friction
    table: RigidPoints
    table_friction: Friction
    additions: Additions


def _grasp(config: Config, food: GraspedBody, site: Site, comm: MPI.Comm) -> _Grasp:
    """Put food and table among the fingers."""
    domain, u, gripper = site.domain, site.u, config.gripper
    gravity = GRAVITY_M_S2 * np.array(DOWN)

    def friction(touched: Touching, coefficient: float, title: str) -> Friction:
        return Friction(touched, u, site.fixed(coefficient), title=title)

    body = replace(food.body, held=SIDEWAYS) if domain.half else food.body
    pose, height = body.pose(domain.mesh), site.fixed(table_z_mm(config, 0.0))
    pose.constants[2].value += height.value
    standing = Pose([height], np.array([[0, 0, 1, 0, 0, 0.0]]).T, np.zeros(6))
    barrier, skin = Smooth(gripper.barrier_mm, gripper.stiffness_MPa), food.surface
    areas, copies = skin.point_areas_mm2(), domain.copies
    solver, moving = config.solver, config.experiment.dynamic
    starts_s = SETTLING_S + lift_starts_s(config) if moving else np.inf
    error_mm = min(solver.time_error_mm, RESOLVED * gripper.barrier_mm)
    scheme = inertia.scheme(solver.hht_alpha), error_mm, starts_s
    motion = RigidMotion(body, pose, gravity, comm, copies, RESTRAINT_MM, *scheme)
    contact = RigidContact(u, domain, SKIN, food.shape, pose, barrier)
    table = RigidPoints(u, skin.points, areas, pose, UPWARDS, standing, barrier, copies)
    _stand(motion, table, u.x.array)
    finger_friction = friction(contact, config.food.friction, "friction on fingers")
    table_friction = friction(table, config.food.table_friction, "friction on the table")
    mirror = [_mirror_image(config, domain, u)] if domain.half else []
    accelerated = gripper.lift_acceleration_m_s2 is not None
    additions = Additions(
        memories=[Acceleration(config, site, motion, height)] if accelerated else [],
        terms=[motion, contact, finger_friction, table, table_friction, *mirror],
        global_unknowns=pose.free,
        controls={"table_z_mm": RisingTable(height, table=table)},
        inertia_from_s=starts_s,
    )
    return _Grasp(motion, contact, finger_friction, table, table_friction, additions)


def _stand(motion: RigidMotion, table: RigidPoints, dofs: np.ndarray) -> None:
    """Put the food at the height at which the table's barrier bears its weight."""
    height, width_mm = motion.pose.constants[2], table.density.width_mm
    lowest = float(height.value)

    def excess_N(height_mm: float) -> float:
        height.value = lowest + height_mm
        return float(table.load_N(dofs)[2] + motion.weight_N[2])

    brentq(excess_N, 1e-6 * width_mm, width_mm, xtol=1e-9 * width_mm)
    motion.accept()  # the food starts there, at rest


def _extent(food: GraspedBody) -> Callable[[np.ndarray], float]:
    """A function: how far the food reaches along a way in the plane of the table."""
    points = food.surface.points[:, :2] + np.array(food.body.centre_mm[:2])
    return lambda way: float((points @ way).max())


def stands_of(config: Config, food: GraspedBody) -> list[Stand]:
    """The places of a configuration's fingers around its food.

    Args:
        config: gripper and fingers.
        food: body that is grasped.

    Returns:
        Places of thumb A, finger B and finger C.

    Raises:
        ConfigError: one line, if there is no room for them.
    """
    return stands(config.gripper, config.adapted().geometry, _extent(food))


def _fingers(config: Config, comm: MPI.Comm, stands: Sequence[Stand], *, half: bool) -> Domain:
    """One mesh of all fingers side by side; for half a gripper, of half a thumb and finger B."""

    def all_made() -> Made:
        finger = made(config)
        if not half:
            return side_by_side([finger] * len(stands))
        return side_by_side([made(config.changed(mesh={"half": True})), finger])

    domain = spread(comm, all_made)
    low, high = box(comm, domain.mesh.geometry.x)[:, 0]
    domain = replace(domain, placement=placed(stands, (low, high), half=half))
    if not half:
        return domain
    assert domain.placement is not None
    start = domain.placement.start_mm + domain.placement.pitch_mm
    return domain.with_region(ONE_FINGER, SKIN, lambda points: points[0] > start)


def placed(stands: Sequence[Stand], extent_mm: tuple[float, float], *, half: bool) -> Placement:
    """The places of the fingers that are meshed.

    Args:
        stands: places of thumb A, finger B and finger C.
        extent_mm: see :meth:`~dolfingrip.mechanics.model.placement.Placement.of`.
        half: whether half a thumb and finger B are meshed.
    """
    meshed = stands[:2] if half else stands
    rotations = np.array([stand.rotation for stand in meshed])
    origins = np.array([stand.origin_mm for stand in meshed])
    return Placement.of(extent_mm, rotations, origins)


def _mirror_image(config: Config, domain: Domain, u: fem.Function) -> RigidContact:
    """Contact of finger B with its mirror image; both can only meet in the plane y = 0."""
    contact = config.contact
    barrier = Smooth(contact.barrier_mm / 2, contact.stiffness_MPa)
    still = Pose([], np.zeros((6, 0)), np.zeros(6))
    return RigidContact(u, domain, (ONE_FINGER,), Plane((0.0, 1.0, 0.0)), still, barrier)
