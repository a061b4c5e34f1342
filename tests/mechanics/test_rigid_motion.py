"""A rigid body's motion in time, against closed forms and Newton's and Euler's equations."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation
from support import blocks
from support.oscillator import oscillator

from dolfingrip.config import Solver
from dolfingrip.forms.inertia import IMPLICIT_EULER, Scheme, scheme
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.pose import SIX, Pose, rotation
from dolfingrip.mechanics.model.rigid_body import RigidBody, RigidMotion
from dolfingrip.mechanics.model.term import Coupling, Term
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.newton import Newton

MASS_KG, TENSOR = 0.0375, np.diag([5.0, 8.0, 9.0])
ALLOWED_MM = 1e-3
STILL = np.concatenate([np.zeros(3), np.eye(3).ravel(), np.zeros(6)])
"""Centre, R, velocity and spin in the body's axes."""


class Spring(Term):
    """A spring from a point of a rigid body to the origin."""

    def __init__(self, pose: Pose, stiffness: float, point: np.ndarray) -> None:
        self._pose, self._stiffness, self._point = pose, stiffness, point

    def value(self, dofs: np.ndarray) -> float:
        q = self._pose.coordinates
        ends = q[:3] + rotation(q[3:]).matrix @ self._point
        return self._stiffness / 2 * float(ends @ ends)

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        q = self._pose.coordinates
        turn = rotation(q[3:])
        force = q[:3] + turn.matrix @ self._point
        moment = turn.slopes(np.outer(q[:3], self._point))
        self._pose.add_slopes(self._stiffness * np.concatenate([force, moment]), gradient)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> list[Coupling]:
        q = self._pose.coordinates
        turn, within = rotation(q[3:]), np.eye(SIX)
        within[:3, 3:] = np.einsum("kij,j->ik", turn.first, self._point)
        within[3:, :3] = within[:3, 3:].T
        within[3:, 3:] = turn.curvatures(np.outer(q[:3], self._point))
        return self._pose.coupling(0, np.zeros((SIX, 0)), self._stiffness * within)


class Stone:
    """A rigid body on a spring, in motion; the block that a model needs is far away."""

    def __init__(
        self, by: Scheme, stiffness: float = 0.0, point: tuple[float, float, float] = (0, 0, 0)
    ) -> None:
        every = {axis: ["left"] for axis in range(3)}
        far = blocks.block((1, 1, 1), origin=(0, 0, 500))
        model = blocks.model([blocks.Block("far", far, blocks.NeoHooke(2.0, 0.3), held=every)])
        body = RigidBody("stone", MASS_KG, TENSOR)
        self.pose, self.point = body.pose(model.domain.mesh), np.array(point, dtype=float)
        self.stiffness, self.gravity = stiffness, np.zeros(3)
        self.rigid = RigidMotion(
            body, self.pose, self.gravity, model.comm, scheme=by, error_mm=ALLOWED_MM
        )
        self.gravity = self.rigid.gravity_m_s2
        self.model = Model(
            model.domain, model.u, model.potential, model.supports, {},
            [self.rigid, Spring(self.pose, stiffness, self.point)],
            global_unknowns=self.pose.free,
        )  # fmt: skip
        self.newton = Newton(self.model, Solver(rtol=1e-10, atol_N=1e-12, max_iterations=60))

    def rates(self, time_s: float, state: np.ndarray) -> np.ndarray:
        """Newton's and Euler's equations of a state."""
        centre, turn, speed, spin = np.split(state, [3, 12, 15])
        r = turn.reshape(3, 3)
        force = -1e3 * self.stiffness * (centre + r @ self.point)  # kg mm/s²
        moment = np.cross(self.point, r.T @ force) - np.cross(spin, TENSOR @ spin)
        falls = 1e3 * self.gravity + force / MASS_KG
        return np.concatenate(
            [speed, (r @ _cross(spin)).ravel(), falls, np.linalg.solve(TENSOR, moment)]
        )

    def exact(self, state: np.ndarray, time_s: float) -> np.ndarray:
        """The state after a time."""
        solved = solve_ivp(self.rates, (0.0, time_s), state, rtol=1e-11, atol=1e-11)
        return np.asarray(solved.y[:, -1])

    def start(self, state: np.ndarray) -> None:
        """Begin with a state's motion."""
        centre, turn, speed, spin = np.split(state, [3, 12, 15])
        r, size, rates = turn.reshape(3, 3), self.rigid.body.gyration_mm, self.rates(0.0, state)
        pose = (*centre, *Rotation.from_matrix(r).as_rotvec())
        for constant, value in zip(self.pose.constants, pose, strict=True):
            constant.value = value
        self.rigid.accept()
        turns = _cross(rates[15:]) + _cross(spin) @ _cross(spin)
        felt = rates[12:15] - 1e3 * self.gravity
        self.rigid.motion.start(
            np.vstack([speed, size * r @ _cross(spin)]), np.vstack([felt, size * r @ turns])
        )

    def step(self, step_s: float) -> float:
        """Take a step; its error by the allowed one."""
        self.model.prescribe({"time_s": self.model.time_s + step_s})
        assert self.newton.solve().converged
        error = self.model.step_error()
        self.model.accept_step()
        return error

    def place(self) -> np.ndarray:
        """Centre and R, as in a state."""
        q = self.pose.coordinates
        return np.concatenate([q[:3], rotation(q[3:]).matrix.ravel()])

    def energy_mJ(self) -> float:
        """Of motion, spring and weight."""
        return self.model.energy() + self.rigid.kinetic_mJ()


def _cross(omega: np.ndarray) -> np.ndarray:
    """ω×."""
    x, y, z = omega
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


@pytest.mark.parametrize("alpha", [0.0, -0.05, -0.3])
def test_a_free_fall_is_exact(alpha: float) -> None:
    """v t + g t²/2 after steps of any length, also where the frame's acceleration jumps."""
    stone = Stone(scheme(alpha))
    thrown = np.array([30.0, 0.0, -20.0])
    stone.start(np.concatenate([STILL[:12], thrown, np.zeros(3)]))
    moved, speed = np.zeros(3), thrown
    for gravity, step_s in ((9.81, 0.003), (9.81, 0.0012), (11.81, 0.05), (7.81, 0.01)):
        stone.gravity[2] = -gravity
        assert stone.step(step_s) < 1e-6
        falls = np.array([0.0, 0.0, -1e3 * gravity])
        moved = moved + step_s * speed + step_s**2 / 2 * falls
        speed = speed + step_s * falls
        np.testing.assert_allclose(stone.pose.coordinates[:3], moved, atol=1e-9)


@pytest.mark.parametrize("alpha", [0.0, -0.2])
def test_a_swing_is_the_schemes_own(alpha: float) -> None:
    """The centre on a spring follows the scheme's equations of one degree of freedom.

    Energy is kept with α = 0, else lost at the scheme's rate, and the error is of second order.
    """
    stone, speed = Stone(scheme(alpha), stiffness=0.02), 100.0
    omega = np.sqrt(1e3 * stone.stiffness / MASS_KG)
    errors = []
    for steps in (40, 80):
        stone.start(np.concatenate([STILL[:12], [speed, 0, 0], np.zeros(3)]))
        start, step_s = stone.energy_mJ(), 1.6 * 2 * np.pi / omega / steps
        for _ in range(steps):
            stone.step(step_s)
        found = float(stone.pose.coordinates[0])
        expected, kept = oscillator(omega, step_s, steps, alpha, speed)
        assert found == pytest.approx(expected, rel=1e-7)
        assert stone.energy_mJ() / start == pytest.approx(kept, abs=1e-7)
        assert kept == pytest.approx(1.0, abs=1e-12) if alpha == 0 else kept < 0.999
        errors.append(found - speed / omega * np.sin(1.6 * 2 * np.pi))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.03)


@pytest.mark.parametrize(
    ("by", "order"), [(scheme(0.0), 2), (scheme(-0.05), 2), (IMPLICIT_EULER, 1)], ids=str
)
def test_a_stone_that_hangs_by_its_side_swings_and_tumbles(by: Scheme, order: int) -> None:
    """Turns by 60°, against a solver of ordinary differential equations."""
    stone = Stone(by, stiffness=0.02, point=(6.0, -2.0, 9.0))
    stone.gravity[2] = -9.81
    first = np.concatenate([[0.0, 4.0, -20.0], STILL[3:12], [40.0, 0, 0], [9.0, 2.0, -5.0]])
    end_s, errors, energies = 0.2, [], []
    exact = stone.exact(first, end_s)[:12]
    assert np.trace(exact[3:].reshape(3, 3)) < 1 + 2 * np.cos(np.radians(60))
    for steps in (30, 60):
        stone.start(first)
        start = stone.energy_mJ()
        for _ in range(steps):
            stone.step(end_s / steps)
        errors.append(np.linalg.norm((stone.place() - exact) / ([1.0] * 3 + [0.1] * 9)))
        energies.append(stone.energy_mJ() - start)
    print(errors, energies)
    assert errors[0] / errors[1] == pytest.approx(2**order, rel=0.2)
    assert abs(energies[1]) < 3e-3 if order == 2 else energies[1] < -0.5  # mJ


def test_a_steps_error_is_told() -> None:
    """The centre's against the exact motion; of points that turn, no less than it is.

    Their acceleration changes along the radius, too, where they cannot go astray.
    """
    stone = Stone(scheme(0.0), stiffness=0.02)
    first = np.concatenate([[3.0, 0.0, 0.0], STILL[3:12], [300.0, 0, 0], np.zeros(3)])
    stone.start(first)
    told_mm = ALLOWED_MM * stone.step(0.002)
    off_mm = stone.place()[0] - stone.exact(first, 0.002)[0]
    assert told_mm == pytest.approx(abs(off_mm), rel=0.1)
    stone = Stone(scheme(0.0), stiffness=0.02, point=(6.0, -2.0, 9.0))
    first = np.concatenate([[0.0, 4.0, -20.0], STILL[3:12], [40.0, 0, 0], [9.0, 2.0, -5.0]])
    for step_s in (0.002, 0.001):
        stone.start(first)
        told_mm = ALLOWED_MM * stone.step(step_s)
        away = stone.place() - stone.exact(first, step_s)[:12]
        away[3:] *= stone.rigid.body.gyration_mm
        print(told_mm, np.abs(away).max())
        assert 1 < told_mm / np.abs(away).max() < 1.5


def test_a_restored_body_moves_on() -> None:
    """Velocities, too: the next step's potential is what it was."""
    stone = Stone(scheme(-0.05))
    rates = np.array([1.0, -2.0, 0.5, 0.2, -0.1, 0.3])  # mm, rad for each second

    def put(time_s: float, step_s: float) -> float:
        """Potential (mJ) of the step that ends there."""
        for constant, value in zip(stone.pose.constants, time_s * rates, strict=True):
            constant.value = value
        stone.rigid.set_time(time_s, step_s)
        return stone.rigid.value(np.empty(0))

    stone.gravity[2] = -9.81
    stone.rigid.accept()
    put(0.1, 0.1)
    stone.rigid.accept()
    kept = stone.rigid.values()
    expected = put(0.3, 0.2)
    assert all(np.abs(kept[f"stone.{name}"][1:]).max() > 0.1 for name in ("velocity", "before_mm"))
    put(0.2, 0.1)
    stone.rigid.accept()
    put(0.25, 0.05)
    stone.rigid.accept()
    assert put(0.3, 0.2) != expected
    stone.rigid.restore(kept)
    assert put(0.3, 0.2) == expected
    for name, value in stone.rigid.values().items():
        np.testing.assert_array_equal(value, kept[name])
