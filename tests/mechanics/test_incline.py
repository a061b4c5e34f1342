"""A cube that rests on a rigid plane by its weight alone, and the plane tilted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import scipy.sparse as sp
from dolfinx import fem
from petsc4py import PETSc
from support import bodies

from dolfingrip.config import Solver
from dolfingrip.mechanics.contact.friction import SLIP_MM, Friction
from dolfingrip.mechanics.model.term import Coupling, Term
from dolfingrip.mechanics.model.unknowns import Gradient
from dolfingrip.mechanics.newton.newton import Newton

MU = 0.5
LIMIT = np.arctan(MU)
WEIGHT = 0.02
"""N; a cube of 1 mm and 1 MPa hardly strains."""
SPRING = 5e-3
"""N/mm: a cube that slides is stopped by it."""
SECONDS = 60.0


class Spring(Term):
    """On the base's mean displacement along x: Π += c ū²/2."""

    def __init__(self, base: np.ndarray) -> None:
        self._base = base

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        mean = dofs.reshape(-1, 3)[self._base, 0].mean()
        gradient.at_nodes[self._base, 0] += SPRING * mean / len(self._base)

    def couplings(self, dofs: np.ndarray, *, convex: bool = False) -> Sequence[Coupling]:
        along = np.tile([1.0, 0.0, 0.0], len(self._base)) / len(self._base)
        return [Coupling(self._base, sp.coo_matrix(SPRING * np.outer(along, along)))]


class Incline:
    """The plane is z = 0; gravity turns instead of it."""

    def __init__(self, mu: float = MU, *, spring: bool = False) -> None:
        solid = bodies.domain(
            bodies.box((2, 2, 2)),
            {"facing plate": bodies.plane(2, 0.0), "skin": lambda x: x[2] < 9},
        )
        self.cube = cube = bodies.body(
            solid, 2, nu=0.3, barrier_mm=0.02, stiffness_MPa=1.0, normal=(0, 0, 1)
        )
        plate, model = cube.plate, cube.model
        self.base = cube.nodes_in("facing plate")
        plate.offset.value = -0.5 * plate.width_mm
        self.mu = fem.Constant(solid.mesh, PETSc.ScalarType(mu))
        self.friction = Friction(plate, cube.u, self.mu)
        model.terms = [plate, self.friction, *([Spring(self.base)] if spring else [])]
        self.newton = Newton(model, Solver(rtol=1e-10, atol_N=1e-13, max_iterations=60))
        # it is let down by hand, upright, until the plane bears it
        cube.hold(bodies.plane(2, 0.0), 0, 1)
        self.tilt(0.0)
        del model.supports[:]
        self.tilt(0.0)

    def tilt(self, angle_rad: float, *, time_s: float = 0.0) -> int:
        """Solve with gravity at an angle to the plane's normal; iterations."""
        pull = WEIGHT * np.array([np.sin(angle_rad), 0.0, -np.cos(angle_rad)])
        self.cube.body_force.x.array[:] = np.tile(pull, len(self.cube.body_force.x.array) // 3)
        self.cube.model.prescribe({"time_s": time_s})
        solve = self.newton.solve()
        assert solve.converged, solve
        self.cube.model.accept_step()
        return solve.iterations

    def place_mm(self) -> np.ndarray:
        """Mean displacement (3,) of the base."""
        return np.asarray(self.cube.displacement()[self.base].mean(axis=0))

    def pull_N(self) -> np.ndarray:
        """Force (3,) of friction on the cube."""
        return -self.friction.forces_N(self.cube.u.x.array).sum(axis=0)


def test_the_nodes_bear_what_the_plate_measures() -> None:
    incline = Incline()
    plate = incline.cube.plate
    found = plate.tangential(incline.cube.u.x.array)
    assert len(found.keys) == 25
    assert found.normal_N.sum() == pytest.approx(plate.force_N(), rel=1e-13)
    assert plate.force_N() == pytest.approx(WEIGHT, rel=1e-9)
    assert plate.tangential(incline.cube.u.x.array).pressing_N().sum(axis=0) == pytest.approx(
        [0, 0, WEIGHT], rel=1e-9
    )


def test_it_holds_below_the_limit_without_creep() -> None:
    """At 0.98 of the angle whose tangent is μ, for a minute in steps of any length."""
    incline = Incline()
    angle = 0.98 * LIMIT
    for part in np.linspace(0, 1, 9)[1:]:
        incline.tilt(part * angle)
    start = incline.cube.displacement()
    assert np.linalg.norm(incline.place_mm()[:2]) < SLIP_MM
    np.testing.assert_allclose(
        incline.pull_N(), [-WEIGHT * np.sin(angle), 0, 0], atol=1e-9 * WEIGHT
    )
    lengths = np.random.default_rng(3).uniform(0.01, 1, 40)
    for time_s in np.cumsum(SECONDS * lengths / lengths.sum()):
        assert incline.tilt(angle, time_s=float(time_s)) == 0
    np.testing.assert_array_equal(incline.cube.displacement(), start)


def test_it_slides_beyond_the_limit() -> None:
    """At 1.02 of it, until a spring bears what friction does not: W (sin α − μ cos α) / c."""
    incline = Incline(spring=True)
    angle = 1.02 * LIMIT
    for part in np.linspace(0, 1, 9)[1:]:
        incline.tilt(part * angle)
    excess = WEIGHT * (np.sin(angle) - MU * np.cos(angle))
    slid = float(incline.place_mm()[0])
    assert slid > SLIP_MM
    assert slid == pytest.approx(excess / SPRING, rel=0.02)
    np.testing.assert_allclose(
        incline.pull_N(), [-MU * WEIGHT * np.cos(angle), 0, 0], atol=1e-3 * WEIGHT
    )
    # and stays there, as the plane is tilted back a little
    incline.tilt(0.99 * angle)
    assert incline.place_mm()[0] == pytest.approx(slid, abs=SLIP_MM)
