"""A step's first tangent with the controls of the equilibrium that it leaves."""

from __future__ import annotations

import numpy as np
from support import small

from dolfingrip.config import Solver
from dolfingrip.mechanics.newton.newton import Newton


def test_the_same_solution_in_fewer_iterations() -> None:
    """The pressure alone, without the stress that bears it, softens the tangent of a finger."""
    found, iterations = [], []
    for before in (None, {"pressure_kPa": 0.0}):
        model = small.model(small.short(), plate=False).model
        # without it the tangent leads astray for some thirty iterations
        newton = Newton(model, Solver(rtol=1e-9, max_iterations=100))
        model.prescribe({"pressure_kPa": 60.0})
        solve = newton.solve(before=before)
        assert solve.converged
        assert model.controls["pressure_kPa"].value == 60.0
        found.append(model.u.x.array.copy())
        iterations.append(solve.iterations)
    print(iterations)
    assert iterations[1] < iterations[0] / 2
    np.testing.assert_allclose(found[1], found[0], atol=1e-6 * np.abs(found[0]).max())
