"""Where Newton's iterations begin, and how their damping follows the steps that were taken."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from petsc4py import PETSc
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import Guess
from dolfingrip.mechanics.newton import damping
from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.iterations import Iterations, System
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import NewtonPolicy
from dolfingrip.mechanics.newton.tangent import Tangent

WEIGHT = 1e-4
"""N/mm³ along x."""


@pytest.fixture(scope="module")
def column() -> bodies.Body:
    """A clamped column that its weight bends."""
    solid = bodies.box((1, 1, 6), (1.0, 1.0, 6.0))
    body = bodies.body(bodies.domain(solid, {}), 2)
    body.hold(bodies.plane(2, 0.0))
    return body


@pytest.fixture
def system(column: bodies.Body) -> Iterator[System]:
    """Its equations at rest, with the weight on."""
    column.displace(np.zeros_like(column.nodes))
    column.body_force.x.array.reshape(-1, 3)[:, 0] = WEIGHT
    yield System(column.model, Solver(rtol=1e-10), Profile(), NewtonPolicy(), Counts())
    column.body_force.x.array[:] = 0.0


def begin(system: System, guess: Guess | None) -> Iterations:
    """Iterations from the present state, or from a guess."""
    return Iterations(
        system, guess, damped=False, corrected=False, before={}, end_s=time.monotonic() + 60
    )


def guessed(column: bodies.Body, displacement: np.ndarray) -> Guess:
    """A displacement, with the stress that it has, as a guess; the state stays as it is."""
    model, kept = column.model, column.displacement()
    column.displace(displacement)
    model.carried.reset()
    guess = Guess(model.unknowns.local().copy(), model.carried.values)
    column.displace(kept)
    model.carried.reset()
    return guess


def test_a_guess_is_where_iterations_begin(column: bodies.Body, system: System) -> None:
    answer = 0.02 * column.nodes[:, 2:] * np.array([1.0, 0.0, 0.0])
    begin(system, None)
    assert not column.displacement().any()
    begin(system, guessed(column, answer))
    np.testing.assert_allclose(column.displacement(), answer)


def test_a_guess_with_too_large_a_residual_is_left_out(column: bodies.Body, system: System) -> None:
    """The state stays at rest where the guess has more than twice its residual, else not."""
    system.policy = replace(system.policy, guess_residual_ratio=2.0)
    at_rest = system.norm()
    assert Newton(column.model, Solver(rtol=1e-10)).solve().converged
    answer = column.displacement()
    for times, taken in ((1.0, True), (-300.0, False)):
        column.displace(np.zeros_like(column.nodes))
        begin(system, guessed(column, times * answer))
        assert column.displacement().any() == taken
        assert system.norm() <= 2 * at_rest


def test_the_residual_along_a_step_is_the_slope_of_the_energy(
    column: bodies.Body, system: System
) -> None:
    """Against a central difference, whose error is of second order."""
    print("seed", 7)
    rng = np.random.default_rng(7)
    free = column.nodes[:, 2:] > 1e-9
    start, step = (0.05 * free * rng.uniform(-1, 1, column.nodes.shape) for _ in range(2))
    energies = []
    for h in (1e-4, -1e-4):
        column.displace(start + h * step)
        energies.append(column.energy())
    column.displace(start)
    slope = (energies[0] - energies[1]) / 2e-4
    assert system.along(step.ravel()) == pytest.approx(slope, rel=1e-6)


def test_no_iteration_begins_after_the_time_is_over(column: bodies.Body, system: System) -> None:
    newton = Newton(column.model, Solver(rtol=1e-10))
    assert newton.solve().converged
    there = column.displacement()
    column.displace(np.zeros_like(column.nodes))
    late = newton.solve(end_s=time.monotonic() - 1.0)
    assert not late.converged
    assert abs(there).max() > 1e-3


class Operators:
    """What a preconditioner of PETSc's type ``python`` is called with."""

    def __init__(self, matrix: PETSc.Mat) -> None:
        self._matrix = matrix

    def getOperators(self) -> tuple[PETSc.Mat, PETSc.Mat]:
        return self._matrix, self._matrix

    def setFailedReason(self, reason: int) -> None:
        assert not reason


def damped_step(system: System, right: PETSc.Vec) -> np.ndarray:
    """The step for a residual at the present state, with the damping of the moment."""
    step = system.model.unknowns.create_vector()
    system.model.carried.reset()
    system.tangent.assemble()
    pc = Operators(system.tangent.matrix)
    system.damping.setUp(pc)
    system.damping.apply(pc, right, step)
    return np.array(step.array)


def test_damping_follows_the_part_of_steps_that_is_taken(system: System) -> None:
    """None at a minimum; where steps are stuck (K + cM)⁻¹ r falls as 1/c; whole steps end it."""
    system.damping.start()
    right = system.model.unknowns.create_vector()
    system.model.assemble_equations(right)
    plain = damped_step(system, right)
    tangent = Tangent(system.model)
    tangent.assemble()
    x, product = tangent.matrix.createVecs()
    x.array[:] = plain
    tangent.matrix.mult(x, product)
    np.testing.assert_allclose(product.array, right.array, atol=1e-9 * abs(right.array).max())
    sizes = []
    for _ in range(7):
        system.damping.adapt(0.5 * damping.STUCK)
        sizes.append(np.linalg.norm(damped_step(system, right)))
    assert (np.diff(sizes) < 0).all()
    assert sizes[-2] / sizes[-1] == pytest.approx(damping.FAR_STRONGER, rel=0.05)
    system.damping.adapt(0.5 * damping.HARD)
    stronger = np.linalg.norm(damped_step(system, right))
    assert sizes[-1] / stronger == pytest.approx(damping.STRONGER, rel=0.05)
    system.damping.adapt(0.5 * (damping.HARD + damping.EASY))  # neither short nor long
    np.testing.assert_allclose(np.linalg.norm(damped_step(system, right)), stronger)
    for _ in range(40):
        system.damping.adapt(1.0)
    np.testing.assert_allclose(damped_step(system, right), plain, atol=1e-9 * abs(plain).max())
    assert not system.damping.unstable


def test_a_damped_step_of_a_column_that_buckles_leads_downhill(
    column: bodies.Body, system: System
) -> None:
    """Pressed together by a fifth, thirty times Euler's strain, it has an indefinite tangent.

    Euler's form m has m·K m < 0. So K m, taken for a residual, has the plain step m, which leads
    uphill: m·K m is the energy's slope against it.
    """
    x, _, z = column.nodes.T
    column.displace(np.stack([0 * z, 0 * z, -0.2 * z], axis=1))
    system.model.carried.reset()
    tangent = Tangent(system.model)
    tangent.assemble()
    form, right = tangent.matrix.createVecs()
    turn = np.pi / 12 * np.sin(np.pi * z / 12) / 0.8  # of sections, which stay normal to the axis
    bent = np.stack([1 - np.cos(np.pi * z / 12), 0 * z, (0.5 - x) * turn], axis=1)
    form.array[:] = bent.ravel()
    tangent.matrix.mult(form, right)
    assert form.dot(right) < 0
    system.damping.start()
    step = damped_step(system, right)
    assert system.damping.unstable
    assert step @ right.array > 0
