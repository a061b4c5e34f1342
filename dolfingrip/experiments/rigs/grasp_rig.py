"""The rig of a gripper that grasps food from a table and lifts it, and its readings.

Readings are forces of each finger, angles, slip, and pressure on the food.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import ClassVar, Final

import numpy as np
from mpi4py import MPI
from scipy.spatial.transform import Rotation

from dolfingrip.channels import CAVITY_PRESSURE, GRIPPER
from dolfingrip.config import KPA, Config
from dolfingrip.experiments.protocol import (
    Stop,
    closing_starts_s,
    lift_starts_s,
    table_z_mm,
)
from dolfingrip.experiments.results.outcome import Moment, Ring, decided, judge
from dolfingrip.experiments.rigs.food import MIRROR
from dolfingrip.experiments.rigs.gripper import SETTLING_S, GripperModel, build_gripper
from dolfingrip.experiments.rigs.pneumatics import longest_step_s, of_supply
from dolfingrip.experiments.rigs.rig import Rig
from dolfingrip.files.run import GraspOutcome
from dolfingrip.mechanics.contact import force_closure
from dolfingrip.mechanics.contact.friction import Friction
from dolfingrip.mechanics.contact.surface import Surface
from dolfingrip.mechanics.model.assembly import integral
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import CorrectionPolicy, LagPolicy, NewtonPolicy, StepPolicy
from dolfingrip.mechanics.path.path import LoadPath, Observer
from dolfingrip.mechanics.path.policy import PathPolicy
from dolfingrip.mechanics.readings.prescribed import ControlValue
from dolfingrip.mechanics.readings.reading import Reading

PRESSING_kPa = 1e3
"""kPa in MPa."""


class GraspReadings:
    """Reads a gripper's model, and adds up energies and slip from step to step.

    Args:
        gripper: model of the gripper at its start.
        config: that it was built from, with the times of its stages.

    Attributes:
        moments: all accepted steps so far in which the food is in place.
    """

    def __init__(self, gripper: GripperModel, config: Config) -> None:
        self._gripper = gripper
        self._lift_starts_s = lift_starts_s(config)
        self._closing_starts_s = closing_starts_s(config)
        model = gripper.model
        domain, space = model.domain, model.u.function_space
        self._comm = model.comm
        index_map = space.dofmap.index_map
        owner = gripper.placement.which(space.tabulate_dof_coordinates())
        self._finger_of_point = owner[gripper.contact.points.nodes]
        # by global node, of all ranks
        self._finger_of_node = np.concatenate(self._comm.allgather(owner[: index_map.size_local]))
        self._tips = Surface(space, domain, domain.facets("tip"), spacing_mm=None)
        self._to_finger = gripper.placement.rotations.transpose(0, 2, 1)
        self._tip_of = np.array([self._nearest(point) for point in self._tips.rest])
        pose = gripper.pose.coordinates
        self._height = float(pose[2]) - model.controls["table_z_mm"].value
        self._start = Rotation.from_rotvec(pose[3:])
        self._half = domain.half
        self._slip_mm = np.zeros(gripper.placement.count)
        self._angles_deg = np.zeros(gripper.placement.count)
        self._energy = EnergyBook(gripper)
        self._momentum_error_N = 0.0
        self.moments: list[Moment] = []

    def _nearest(self, point: np.ndarray) -> int:
        """The finger whose tip stands closest to a point of a tip at rest."""
        gripper = self._gripper
        length = gripper.finger.config.geometry.length_mm
        down = gripper.placement.origins_mm + length * gripper.placement.rotations[:, :, 2]
        return int(np.linalg.norm(down - point, axis=1).argmin())

    # -- observer of the path ---------------------------------------------------------------------

    def converged(self, before: State) -> None:
        """Add up energies and slip of an accepted step."""
        gripper, dofs = self._gripper, self._gripper.model.u.x.array
        sliding = gripper.finger_friction.sliding(dofs)
        which = self._finger_of_node[sliding.keys[:, 0]]
        for i in range(len(self._slip_mm)):
            mine = which == i
            weight = float(sliding.normal_N[mine].sum())
            if weight > 0:
                mean = float(sliding.normal_N[mine] @ sliding.slid_mm[mine]) / weight
                self._slip_mm[i] += mean
        self._energy.book()
        self._balance()
        self.angles_deg()
        time_s = gripper.model.time_s - SETTLING_S
        if 0 < self._closing_starts_s > time_s + 1e-9:
            return
        q = gripper.pose.coordinates
        weight_N = float(np.linalg.norm(gripper.motion.weight_N))
        table_z = gripper.model.controls["table_z_mm"].value
        self.moments.append(
            Moment(
                time_s,
                time_s > self._lift_starts_s + 1e-9,
                q[:3].copy(),
                float(q[2]) - table_z - self._height,
                self.normal_N(),
                float(gripper.table.load_N(gripper.model.u.x.array)[2]) / weight_N,
            )
        )

    def _balance(self) -> None:
        """Keep the largest error of m Δv/h = Σ F of the object, with the contacts' forces."""
        gripper = self._gripper
        total = gripper.table.load_N(gripper.model.u.x.array)[:3] + self._table_friction_N()
        total = total + self.on_object_N().sum(axis=0)
        error = float(np.linalg.norm(gripper.motion.held_N() - total))
        self._momentum_error_N = max(self._momentum_error_N, error)

    # -- forces ------------------------------------------------------------------------------------

    def normal_N(self) -> np.ndarray:
        """Sum of each finger's normal forces on the object, (3,)."""
        gripper = self._gripper
        near = gripper.contact.near(gripper.model.u.x.array)
        sizes = np.linalg.norm(near.forces, axis=1)
        which = self._finger_of_point[near.rows]
        normal = self._sum(np.bincount(which, sizes, gripper.placement.count))
        return self._each(normal * [2, 1]) if self._half else normal

    def _each(self, values: np.ndarray) -> np.ndarray:
        """Values of all fingers, (3,); finger C has those of finger B."""
        return values[[0, 1, 1]] if self._half else values

    def _sum(self, local: np.ndarray) -> np.ndarray:
        return np.asarray(self._comm.allreduce(local, MPI.SUM))

    def on_object_N(self) -> np.ndarray:
        """Force of each finger on the object, with friction, (3, 3)."""
        gripper, dofs = self._gripper, self._gripper.model.u.x.array
        near = gripper.contact.near(dofs)
        forces = np.zeros((gripper.placement.count, 3))
        pushed = near.forces @ near.turned.matrix
        np.add.at(forces, self._finger_of_point[near.rows], pushed)
        forces = self._sum(forces)
        nodes = gripper.contact.touching.nodes
        friction = gripper.finger_friction.forces_N(dofs)[: len(nodes)]
        np.add.at(forces, self._finger_of_node[nodes], friction)
        if not self._half:
            return forces
        return np.array([forces[0] + MIRROR * forces[0], forces[1], MIRROR * forces[1]])

    def _table_friction_N(self) -> np.ndarray:
        """On the object, (3,)."""
        force = -self._gripper.table_friction.forces_N(self._gripper.model.u.x.array)[0]
        return force + MIRROR * force if self._half else force

    def angles_deg(self) -> np.ndarray:
        """Rotation of each tip face's area vector about its finger's y, towards the food, (3,).

        It is the angle of a single finger, for the polygons between the face's nodes. It goes on
        beyond 180° as long as no face turns by more between two accepted steps.
        """
        tips = self._tips
        to_finger = self._to_finger[self._tip_of[tips.triangles[:, 0]]]
        now, resting = (
            np.einsum("nij,nj->ni", to_finger, _areas(points[tips.triangles]))
            for points in (tips.positions(self._gripper.model.u.x.array), tips.rest)
        )
        outward = np.sign(resting[:, 2])[:, None] * now  # a triangle may turn either way
        which = self._tip_of[tips.triangles[:, 0]]
        count = self._gripper.placement.count
        sums = np.array([outward[which == i].sum(axis=0) for i in range(count)])
        angles = np.degrees(np.arctan2(-sums[:, 0], sums[:, 2]))
        self._angles_deg = angles + 360.0 * np.round((self._angles_deg - angles) / 360.0)
        return self._each(self._angles_deg)

    def opening_mm(self) -> float:
        """Horizontal distance from the thumb's tip to the middle between those of B and C."""
        tips = self._tips
        which = self._tip_of[tips.triangles[:, 0]]
        area = np.linalg.norm(_areas(tips.rest[tips.triangles]), axis=1)
        centres = tips.positions(self._gripper.model.u.x.array)[tips.triangles].mean(axis=1)
        thumb, *others = (
            np.average(centres[which == i], axis=0, weights=area[which == i])
            for i in range(self._gripper.placement.count)
        )
        apart = np.mean(others, axis=0) - thumb
        # in half a gripper the middle is in the plane of symmetry
        return float(abs(apart[0]) if self._half else np.hypot(*apart[:2]))

    def _closure(self) -> float:
        """Force-closure margin of the present contacts of fingers and object."""
        gripper = self._gripper
        near = gripper.contact.near(gripper.model.u.x.array)
        normals = -near.distances.gradient @ near.turned.matrix
        normals /= np.linalg.norm(normals, axis=1)[:, None]
        sizes = np.linalg.norm(near.forces, axis=1)
        arms, normals, sizes = (
            np.concatenate(self._comm.allgather(values)) for values in (near.arms, normals, sizes)
        )
        if self._half:
            arms, normals = (np.concatenate([v, MIRROR * v]) for v in (arms, normals))
            sizes = np.concatenate([sizes, sizes])
        friction = gripper.finger.config.food.friction
        return float(self._comm.bcast(force_closure.margin(arms, normals, sizes, friction)))

    # -- a row -------------------------------------------------------------------------------------

    def read(self) -> dict[str, float]:
        """Values by column, the channels of :data:`~dolfingrip.channels.GRIPPER`.

        ``normal_A_N`` is the sum of the normal forces of finger A. ``lift_A_N`` is the vertical
        part of all its forces on the object. ``slip_mm`` is the way that the finger with the
        largest one has slid over the food so far: the mean over its points, weighted by normal
        forces. ``force_closure`` is :func:`~dolfingrip.mechanics.contact.force_closure.margin`.
        ``pressure_mJ`` is the work of the pressure, ``friction_mJ`` the energy that sliding has
        dissipated, and ``energy_error_mJ`` the error of the energy balance, all so far (see
        :class:`EnergyBook`). ``momentum_error_N`` is the largest |m Δv/h − ΣF| of
        all steps.
        """
        gripper = self._gripper
        q = gripper.pose.coordinates
        turn = (Rotation.from_rotvec(q[3:]) * self._start.inv()).as_rotvec(degrees=True)
        near = gripper.contact.near(gripper.model.u.x.array)
        least = self._comm.allreduce(float(near.barrier.slope.min(initial=0.0)), MPI.MIN)
        pressure = -least * PRESSING_kPa
        table_z = gripper.model.controls["table_z_mm"].value
        values = (
            *(table_z, *q[:3], float(q[2]) - table_z - self._height),
            *(float(np.linalg.norm(turn)), *turn),
            *self.angles_deg(),
            *self.normal_N(),
            *self.on_object_N()[:, 2],
            *(
                float(gripper.table.load_N(gripper.model.u.x.array)[2]),
                float(self._slip_mm.max()),
                pressure,
            ),
            self._closure(),
            *(self._energy.pressure_mJ, self._energy.friction_mJ),
            *(self._energy.error_mJ, self._momentum_error_N, self.opening_mm()),
        )
        return {channel.name: float(value) for channel, value in zip(GRIPPER, values, strict=True)}


def _areas(triangles: np.ndarray) -> np.ndarray:
    """Twice the area vectors of (m, 3, 3) triangles, (m, 3)."""
    a, b, c = (triangles[:, i] for i in range(3))
    return np.cross(b - a, c - a)


class EnergyBook:
    """Adds up the energies of each accepted step of a gripper.

    Stored energies are those of strain, of barriers, of friction that sticks elastically, of
    weights, and of the motion of food and fingers. Pressure does the work ∫ p dV and the table
    ∫ F dz, both by the trapezoidal rule. The rest is the schemes' damping, the rule's error, and
    energy that friction gains or loses as normal forces change.

    Args:
        gripper: model of the gripper at its start.

    Attributes:
        pressure_mJ: work of the pressure since the first step.
        friction_mJ: energy that sliding has dissipated; it never decreases.
        error_mJ: increase of the stored energy, less the works, plus the dissipated energy.
    """

    def __init__(self, gripper: GripperModel) -> None:
        self._gripper, self._volume = gripper, gripper.finger.enclosed
        self._last: tuple[float, float, float, float, float] | None = None
        self.pressure_mJ = self.friction_mJ = self.error_mJ = 0.0

    def book(self) -> None:
        """Add the energies of the converged step at whose end the model is."""
        model, dofs = self._gripper.model, self._gripper.model.u.x.array
        copies = model.domain.copies
        taken = copies * sum(friction.dissipated_mJ(dofs) for friction in self._frictions)
        volume = copies * integral(self._volume)
        pressure = self._gripper.finger.cavity.value * KPA
        force, height = self._table_N(), model.controls["table_z_mm"].value
        stored = self._stored_mJ(taken) + pressure * volume
        if self._last is not None:
            before, then, pushed, place, was = self._last
            pressing = (pressure + then) / 2 * (volume - before)
            lifting = (force + pushed) / 2 * (height - place)
            self.pressure_mJ += pressing
            self.error_mJ += stored - was - pressing - lifting + taken
        self.friction_mJ += taken
        self._last = volume, pressure, force, height, stored

    @property
    def _frictions(self) -> tuple[Friction, Friction]:
        return self._gripper.finger_friction, self._gripper.table_friction

    def _table_N(self) -> float:
        """Upward force of the table on the food."""
        return float(self._gripper.table.load_N(self._gripper.model.u.x.array)[2])

    def _stored_mJ(self, taken: float) -> float:
        """Stored energy (mJ): the potential without its pressure's part −p V."""
        gripper, dofs = self._gripper, self._gripper.model.u.x.array
        motion = gripper.motion
        inert = (motion, *self._frictions, gripper.finger.air)
        terms = [term for term in gripper.model.all_terms if not any(term is i for i in inert)]
        copies = gripper.model.domain.copies
        meshed = sum(term.value(dofs) for term in (*terms, *self._frictions))
        height_mJ = -float(motion.weight_N @ gripper.pose.coordinates[:3])
        inertia = gripper.finger.inertia
        if inertia is not None:  # what the fingers' motion stores is not the step's potential
            meshed += inertia.kinetic_mJ() - integral(inertia.energy)
        return copies * meshed - taken + height_mJ + motion.kinetic_mJ()


SOLVING: Final = NewtonPolicy(
    # a step that a bound cuts short, as where the food is first touched, goes astray, and half a
    # step in time is easy
    steps=StepPolicy(shortest=0.05, patience=0),
    # each step updates friction's forces, so the next step has what they lag behind
    lag=LagPolicy(tolerance=0.05),
    # with 1e-4 a grasp solves nearly twice as often with the factors and takes as many iterations
    correction=CorrectionPolicy(tolerance=1e-2),
    # pairs in contact make a predicted state a bad start: if twice the residual of the step's start
    # is allowed, more steps around a large potato fail
    guess_residual_ratio=0.5,
)
"""How a gripper and its food are solved, step by step in time."""


class GraspRig(Rig):
    """Controls pressure and table, and reads fingers and food.

    Args:
        config: configuration that was asked for.
        gripper: model of the gripper.
        profile: takes the time of each phase.
    """

    specimen_name: ClassVar = "gripper"

    def __init__(self, config: Config, gripper: GripperModel, profile: Profile) -> None:
        super().__init__(Newton(gripper.model, config.solver, profile, SOLVING), gripper)
        self.readings = {}
        self._config = config
        self._gripper, self.pressures = gripper, gripper.finger.pressures
        self.air = gripper.finger.air
        self._of_air: list[Reading] = []
        if self.air is not None:
            cavity = ControlValue(gripper.model, CAVITY_PRESSURE.name, gripper.finger.cavity)
            self._of_air = [cavity, *of_supply(gripper.model, self.air)]
        roots = [stand.origin_mm[:2] for stand in gripper.stands]
        self._ring = Ring(
            min(float(np.linalg.norm(root)) for root in roots),
            np.array([root / np.linalg.norm(root) for root in roots]),
        )
        self._reads = GraspReadings(gripper, config)

    @classmethod
    def built(cls, config: Config, comm: MPI.Comm, profile: Profile) -> GraspRig:
        """The rig of a configuration's gripper.

        Raises:
            ConfigError: on every rank, one line.
        """
        with profile.phase("mesh and forms"):
            gripper = build_gripper(config, comm)
        return cls(config, gripper, profile)

    def longest(self) -> dict[str, float]:
        filling_s = None if self.air is None else longest_step_s(self.air)
        steps_s = self._config.solver.max_step_s, self._config.gripper.step_s, filling_s
        return {"time_s": min(step_s for step_s in steps_s if step_s is not None)}

    def controls(self, stop: Stop) -> Mapping[str, float]:
        return {
            "pressure_kPa": stop.value,
            "time_s": SETTLING_S + stop.time_s,
            "table_z_mm": table_z_mm(self._config, stop.time_s),
        }

    def path(self, observers: Sequence[Observer]) -> LoadPath:
        return LoadPath(
            self.newton,
            self.longest(),
            observers=[*observers, self._reads],
            over=self.over,
            policy=PathPolicy(from_equilibrium=True, halves_first=True),
        )

    def read(self) -> dict[str, float]:
        model = self._gripper.model
        pressure = model.controls["pressure_kPa"].value
        time_s = model.time_s - SETTLING_S
        air = {reading.column: reading.value() for reading in self._of_air}
        return {"time_s": time_s, "pressure_kPa": pressure, **self._reads.read(), **air}

    def over(self) -> bool:
        """Return whether the food has left the fingers."""
        return decided(self._reads.moments, self._ring)

    def outcome(self, *, complete: bool) -> GraspOutcome | None:
        """The grasp's outcome; see :func:`~dolfingrip.experiments.results.outcome.judge`."""
        return judge(self._reads.moments, complete=complete, ring=self._ring)
