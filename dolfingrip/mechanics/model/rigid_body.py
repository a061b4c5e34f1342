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

from dolfingrip.mechanics.model.carried_stress import Regularised
from dolfingrip.mechanics.model.pose import SIX, Pose, rotation
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.state import Memory
from dolfingrip.mechanics.model.term import Coupling, Term
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


class RigidMotion(Term, Memory, Regularised):
    """Dead weight and inertia of a rigid body (implicit Euler).

    Π = −m g·c + m/(2h²) |c − c_n − h v_n|² − R(θ) : (R_n + h Ṙ_n) J/h²

    over a load step of h seconds that starts at c_n, R_n, v_n, Ṙ_n; J = ½ tr(I) 1 − I is the
    second moment of mass. The last is ½ ∫ ρ |R X − R_n X − h Ṙ_n X|² dV/h² without its constant.
    If no time passes there is no inertia: the body is at rest, and no velocity is stored.
    It bounds Newton's steps to :data:`LONGEST_MM`.

    Args:
        body: mass and inertia.
        pose: pose of the body.
        gravity_m_s2: (3,) acceleration of free fall, a control's array; 0 for a weightless body.
        copies: number of meshed parts that make the whole and share the body.
        restraint_mm: distance over which the restraint, a stiffness that Newton's method adds to a
            nearly free body, bears the residual's force; it vanishes with the residual.
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
    ) -> None:
        self.restraint_mm = restraint_mm
        self.body = body
        self.pose = pose
        self.gravity_m_s2 = np.asarray(gravity_m_s2, dtype=float)
        self._comm = comm
        self._share = 1 / copies
        inertia = np.asarray(body.inertia_kg_mm2, dtype=float)
        self._moment = np.trace(inertia) / 2 * np.eye(3) - inertia
        self._step_s = 0.0
        self._residual_N = 0.0
        self._start = pose.coordinates
        self._velocity = np.zeros(3)
        self._turning = np.zeros((3, 3))

    # -- the potential ---------------------------------------------------------------------------

    @property
    def weight_N(self) -> np.ndarray:
        """(3,) dead weight of the whole body."""
        return self.body.mass_kg * self.gravity_m_s2

    def _inertia(self) -> tuple[float, np.ndarray, np.ndarray] | None:
        """m/h² (N/mm), the centre's place without forces (mm), M of the rotation's R : M (N mm)."""
        if self._step_s <= 0:
            return None
        rate = N_PER_KG_MM_S2 / self._step_s**2
        ahead = self._start[:3] + self._step_s * self._velocity
        turned = rotation(self._start[3:]).matrix + self._step_s * self._turning
        return self.body.mass_kg * rate, ahead, -rate * turned @ self._moment

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part's share."""
        q = self.pose.coordinates
        found = -float(self.weight_N @ q[:3])
        inertia = self._inertia()
        if inertia is not None:
            stiffness, ahead, m = inertia
            found += stiffness / 2 * float((q[:3] - ahead) @ (q[:3] - ahead))
            found += float(np.vdot(rotation(q[3:]).matrix, m))
        return self._share * found

    def kinetic_mJ(self) -> float:
        """Kinetic energy of the whole body at the end of the present load step; 0 at rest."""
        if self._step_s <= 0:
            return 0.0
        q = self.pose.coordinates
        velocity = (q[:3] - self._start[:3]) / self._step_s
        turning = (rotation(q[3:]).matrix - rotation(self._start[3:]).matrix) / self._step_s
        turned = float(np.einsum("ij,jk,ik->", turning, self._moment, turning))
        return N_PER_KG_MM_S2 / 2 * (self.body.mass_kg * float(velocity @ velocity) + turned)

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add forces (N) and moments (N mm)."""
        q = self.pose.coordinates
        slopes = np.concatenate([-self.weight_N, np.zeros(3)])
        inertia = self._inertia()
        if inertia is not None:
            stiffness, ahead, m = inertia
            slopes[:3] += stiffness * (q[:3] - ahead)
            slopes[3:] += rotation(q[3:]).slopes(m)
        self.pose.add_slopes(self._share * slopes, gradient)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        """Inertia's part of the global unknowns' own second derivatives."""
        within = np.zeros((SIX, SIX))
        inertia = self._inertia()
        if inertia is not None:
            stiffness, _, m = inertia
            within[:3, :3] = stiffness * np.eye(3)
            within[3:, 3:] = rotation(self.pose.coordinates[3:]).curvatures(m)
        within *= self._share
        restraint = self._residual_N / self.restraint_mm
        turning = restraint * self.body.gyration_mm**2
        within += np.diag(3 * [restraint] + 3 * [turning])
        return self.pose.coupling(0, np.zeros((SIX, 0)), within)

    def add_shape_gradient(self, dofs: np.ndarray, found: ShapeGradient) -> None:
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
        """Take the length of the load step."""
        self._step_s = step_s

    def accept(self) -> None:
        """Make the step's end the start of the next step."""
        q = self.pose.coordinates
        turn = rotation(q[3:]).matrix - rotation(self._start[3:]).matrix
        per_second = 1 / self._step_s if self._step_s > 0 else 0.0
        self._velocity = per_second * (q[:3] - self._start[:3])
        self._turning = per_second * turn
        self._start = q

    def values(self) -> dict[str, np.ndarray]:
        """Start and velocities, by name."""
        name = self.body.name
        return {
            f"{name}.start": self._start.copy(),
            f"{name}.velocity_mm_per_s": self._velocity.copy(),
            f"{name}.turning_per_s": self._turning.copy(),
        }

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore values that :meth:`values` returned."""
        name = self.body.name
        self._start = values[f"{name}.start"].copy()
        self._velocity = values[f"{name}.velocity_mm_per_s"].copy()
        self._turning = values[f"{name}.turning_per_s"].copy()
