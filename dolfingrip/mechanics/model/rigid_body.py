"""A rigid body: its pose is six unknowns; mass, inertia and dead weight act on it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Final

import dolfinx
import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.forms.inertia import IMPLICIT_EULER, Scheme
from dolfingrip.mechanics.model.pose import LEVI_CIVITA, SIX, Pose, rotation
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.mechanics.model.term import Coupling, Term
from dolfingrip.mechanics.model.time_integrator import TimeIntegrator
from dolfingrip.mechanics.model.unknowns import GlobalUnknown, Gradient

COORDINATES: Final = ("x_mm", "y_mm", "z_mm", "turn_x_rad", "turn_y_rad", "turn_z_rad")
"""Names of the six global unknowns."""

LONGEST_MM: Final = 8.0
"""Largest step of a centre, and of the turn at the radius of gyration. A linear prediction would
throw a nearly free body metres away."""

N_PER_KG_MM_S2: Final = 1e-3


@dataclass(frozen=True)
class RigidBody:
    """A body that does not deform.

    Attributes:
        name: of the body.
        mass_kg: mass of the body.
        inertia_kg_mm2: (3, 3) tensor about the centre of gravity, in the unturned body's axes.
        centre_mm: first place of the centre of gravity.
        held: coordinates of :data:`COORDINATES` that are prescribed. A frictionless sphere on a
            plane slides and turns freely. At rest, without inertia, these coordinates must be held.
    """

    name: str
    mass_kg: float
    inertia_kg_mm2: np.ndarray
    centre_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    held: frozenset[str] = field(default_factory=frozenset)

    @property
    def gyration_mm(self) -> float:
        """Radius of gyration ℓ, the mean over the three axes: √(tr I/(3 m))."""
        return float(np.sqrt(np.trace(self.inertia_kg_mm2) / (3 * self.mass_kg)))

    def pose(self, mesh: dolfinx.mesh.Mesh) -> Pose:
        """The pose, of global unknowns in mm and ℓθ, so that derivatives by them are forces."""
        constants = [fem.Constant(mesh, PETSc.ScalarType(0.0)) for _ in COORDINATES]
        for constant, value in zip(constants, self.centre_mm, strict=False):
            constant.value = value
        global_unknowns: list[GlobalUnknown | None] = []
        for i, (name, constant) in enumerate(zip(COORDINATES, constants, strict=True)):
            scale = 1.0 if i < 3 else 1 / self.gyration_mm
            free = name not in self.held
            global_unknowns.append(
                GlobalUnknown(f"{self.name}.{name}", constant, scale) if free else None
            )
        return Pose(constants, np.eye(SIX), np.zeros(SIX), global_unknowns)


def ball(
    name: str,
    mass_kg: float,
    radius_mm: float,
    centre_mm: tuple[float, float, float],
    held: Sequence[str] = (),
) -> RigidBody:
    """A solid sphere of uniform density."""
    inertia = 0.4 * mass_kg * radius_mm**2 * np.eye(3)
    return RigidBody(name, mass_kg, inertia, centre_mm, frozenset(held))


class RigidMotion(Term, Memory):
    """Dead weight and inertia of a rigid body.

    Π = k/2 (m |c − ĉ|² + (R − R̂) : (R − R̂) J)

    over a load step from which a scheme of :mod:`dolfingrip.forms.inertia` predicts k, ĉ and R̂, the
    weight's part included; J = ½ tr(I) 1 − I is the second moment of mass. The last is
    ½ ∫ ρ k |R X − R̂ X|² dV. Up to ``from_s`` the scheme is implicit Euler.
    Velocity and acceleration that it stores are those of a body that turns: parts in which points
    would leave the body, which no force damps, are left out, except for implicit Euler, which
    forgets them.
    If no time passes there is no inertia, and Π = −m g·c.
    It bounds Newton's steps to :data:`LONGEST_MM`.

    Args:
        body: mass and inertia.
        pose: pose of the body.
        gravity_m_s2: (3,) acceleration of free fall, a control's array; 0 for a weightless body.
            It changes between load steps alone.
        copies: number of meshed parts that make the whole and share the body.
        restraint_mm: distance over which the restraint, a stiffness that Newton's method adds to a
            nearly free body, bears the residual's force; it vanishes with the residual.
        scheme: after ``from_s``.
        error_mm: error of a step by that scheme that is allowed, at the radius of gyration.
        from_s: time (s).

    Attributes:
        motion: of the centre and the rows of ℓR, ℓ the radius of gyration, (4, 3).
    """

    name: ClassVar[str] = "rigid body"

    def __init__(
        self,
        body: RigidBody,
        pose: Pose,
        gravity_m_s2: np.ndarray,
        comm: MPI.Comm,
        copies: int = 1,
        restraint_mm: float = np.inf,
        scheme: Scheme = IMPLICIT_EULER,
        error_mm: float = np.inf,
        from_s: float = 0.0,
    ) -> None:
        self.restraint_mm = restraint_mm
        self.body = body
        self.pose = pose
        self.gravity_m_s2 = np.asarray(gravity_m_s2, dtype=float)
        self._comm = comm
        self._share = 1 / copies
        self._later, self._error_mm, self._from_s = scheme, error_mm, from_s
        inertia = np.asarray(body.inertia_kg_mm2, dtype=float)
        moment = np.trace(inertia) / 2 * np.eye(3) - inertia
        self._moment_kg = moment / body.gyration_mm**2
        self._residual_N = 0.0
        self.motion = TimeIntegrator(body.name, self._places(), IMPLICIT_EULER)

    def _places(self) -> np.ndarray:
        """Centre and the rows of ℓR (mm), (4, 3): ℓ is the radius of gyration."""
        q = self.pose.coordinates
        return np.vstack([q[:3], self.body.gyration_mm * rotation(q[3:]).matrix])

    # -- the potential ---------------------------------------------------------------------------

    @property
    def weight_N(self) -> np.ndarray:
        """Dead weight of the whole body, (3,)."""
        return self.body.mass_kg * self.gravity_m_s2

    def _away(self) -> tuple[float, np.ndarray]:
        """k (N/(kg mm)), and places less what the step predicts, (4, 3) (mm)."""
        return N_PER_KG_MM_S2 * self.motion.stiffness, self._places() - self.motion.ahead

    def _masses_kg(self, places: np.ndarray) -> np.ndarray:
        """Places, by mass and second moments of mass, (4, 3)."""
        return np.vstack([self.body.mass_kg * places[0], places[1:] @ self._moment_kg])

    def _turned_N_mm(self) -> np.ndarray:
        """M (3, 3) of the rotation's part R : M of the potential, which else is constant."""
        k = N_PER_KG_MM_S2 * self.motion.stiffness
        return -k * self.body.gyration_mm * self._masses_kg(self.motion.ahead)[1:]

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part's share."""
        k, away = self._away()
        if not k:
            return -self._share * float(self.weight_N @ self.pose.coordinates[:3])
        return self._share * k / 2 * float(np.vdot(away, self._masses_kg(away)))

    def kinetic_mJ(self) -> float:
        """Kinetic energy of the whole body at the end of the present load step."""
        velocity = self.motion.end_velocity(self._places())
        return N_PER_KG_MM_S2 / 2 * float(np.vdot(velocity, self._masses_kg(velocity)))

    def held_N(self) -> np.ndarray:
        """Force (3,) of all but weight on the body, which its motion to the step's end needs."""
        return -N_PER_KG_MM_S2 * self.body.mass_kg * self.motion.end_forces(self._places())[0]

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add forces (N) and moments (N mm)."""
        k, away = self._away()
        force = k * self.body.mass_kg * away[0] if k else -self.weight_N
        turn = rotation(self.pose.coordinates[3:]).slopes(self._turned_N_mm())
        self.pose.add_slopes(self._share * np.concatenate([force, turn]), gradient)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Inertia's part of the global unknowns' own second derivatives."""
        within = np.zeros((SIX, SIX))
        within[:3, :3] = N_PER_KG_MM_S2 * self.motion.stiffness * self.body.mass_kg * np.eye(3)
        within[3:, 3:] = rotation(self.pose.coordinates[3:]).curvatures(self._turned_N_mm())
        within *= self._share
        restraint = self._residual_N / self.restraint_mm
        turning = restraint * self.body.gyration_mm**2
        within += np.diag(3 * [restraint] + 3 * [turning])
        return self.pose.coupling(0, np.zeros((SIX, 0)), within)

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add nothing: the body is no part of the mesh."""

    def set_residual(self, residual_N: float) -> None:
        """Set the restraint that follows from the residual."""
        self._residual_N = residual_N

    def scale_N(self) -> float:
        """Weight of the meshed part's share, which the tolerance may refer to."""
        return self._share * float(np.linalg.norm(self.weight_N))

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction that moves the body by :data:`LONGEST_MM` or less."""
        change = self.pose.change(step)
        length = max(np.linalg.norm(change[:3]), self.body.gyration_mm * np.linalg.norm(change[3:]))
        return min(1.0, LONGEST_MM / max(float(length), LONGEST_MM))

    # -- memory ----------------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Predict the step's end."""
        self.motion.scheme = self._later if time_s > self._from_s else IMPLICIT_EULER
        falls = np.zeros((4, 3))
        falls[0] = self.gravity_m_s2 / N_PER_KG_MM_S2
        self.motion.set_step(step_s, falls)

    def step_error(self) -> float:
        """Error of the converged step by the allowed one; implicit Euler has none that is told."""
        estimated = self.motion.scheme is not IMPLICIT_EULER
        return self.motion.error_mm(self._places()) / self._error_mm if estimated else 0.0

    def accept(self) -> None:
        """Make the step's end the start of the next step."""
        self.motion.accept(self._places())
        if self.motion.scheme is not IMPLICIT_EULER:
            self._turn()

    def _turn(self) -> None:
        """Make the stored motion one of a body that turns: Ṙ = R ω×, R̈ = R (ω̇× + ω× ω×)."""
        turned, speed, rate = (
            vectors[1:] / self.body.gyration_mm
            for vectors in (self.motion.places, self.motion.velocity, self.motion.acceleration)
        )
        spin = self._cross(turned.T @ speed)
        change = self._cross(turned.T @ rate - spin @ spin)
        self.motion.velocity[1:] = self.body.gyration_mm * turned @ spin
        self.motion.acceleration[1:] = self.body.gyration_mm * turned @ (change + spin @ spin)

    def _cross(self, rate: np.ndarray) -> np.ndarray:
        """ω× of the turn whose points are nearest, by mass, to those that move by (3, 3) rates."""
        moments = rate @ (self._moment_kg * self.body.gyration_mm**2)
        omega = np.linalg.solve(
            self.body.inertia_kg_mm2, -np.einsum("ijk,ij->k", LEVI_CIVITA, moments)
        )
        return -np.einsum("ijk,k->ij", LEVI_CIVITA, omega)

    def values(self) -> dict[str, np.ndarray]:
        """The motion, by name."""
        return self.motion.values()

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore values that :meth:`values` returned."""
        self.motion.restore(values)
