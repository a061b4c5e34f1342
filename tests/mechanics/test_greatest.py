"""The greatest pressure ahead by the volume, against the radial equation of a thick balloon."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from support import bodies, spheres
from support.paths import by_pressure

from dolfingrip.config import KPA, Solver
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.greatest import greatest


@pytest.mark.parametrize("part", [0.0, 0.5, 0.95])
@pytest.mark.parametrize("beyond", [0.97, 1.3])
def test_the_greatest_pressure_is_that_of_the_radial_equation(
    balloon: bodies.Body, part: float, beyond: float
) -> None:
    """It is found from any state below, within 0.2 % of the mesh and what long steps miss.

    Reference: radial equilibrium (:func:`spheres.pressure_MPa`). A pressure below it is reached,
    and then nothing turns.
    """
    mu, lmbda = balloon.mu.value, balloon.lmbda.value
    best = minimize_scalar(
        lambda stretch: -spheres.pressure_MPa(stretch, mu, lmbda),
        bounds=(1.3, 1.8),
        method="bounded",
    )
    expected = float(-best.fun / KPA)
    newton = Newton(balloon.model, Solver(rtol=1e-9))
    assert by_pressure(newton).advance({"pressure_kPa": part * expected}).failure is None
    good, pressure = balloon.model.state(), balloon.model.controls["pressure_kPa"]
    ds = balloon.model.domain.surface("cavity", quadrature_degree=6)
    volume = cavity_pressure.volume_density(balloon.u, balloon.model.domain.mesh) * ds
    found = greatest(balloon.model, pressure, volume, newton.settings, beyond * expected, 0.02)
    print(f"{found and found[0]} kPa, radial equation {expected:.2f} kPa at {best.x:.3f}")
    turns = partial(greatest, balloon.model, pressure, volume, newton.settings, beyond * expected)
    by_tangent = turns(1.0, lambda: True)  # nothing falls by the whole of its pressure
    assert (by_tangent is not None) == (beyond > 1)
    if by_tangent is not None and found is not None:
        assert by_tangent[0] == pytest.approx(found[0], rel=1e-3)
        assert turns(1.0, lambda: False) is None  # a snap
    after = balloon.model.state()
    assert after.controls == good.controls
    np.testing.assert_array_equal(after.displacement, good.displacement)
    assert (found is not None) == (beyond > 1)
    if found is not None:
        pressure_kPa, top = found
        assert pressure_kPa == pytest.approx(expected, rel=1e-2)
        assert top.controls["pressure_kPa"] == pressure_kPa
        balloon.model.restore(top)
        inside = np.linalg.norm(balloon.nodes, axis=1) < 1 + 1e-6
        widened = np.linalg.norm((balloon.nodes + balloon.displacement())[inside], axis=1)
        assert spheres.pressure_MPa(float(widened.mean()), mu, lmbda) / KPA == pytest.approx(
            pressure_kPa, rel=3e-3
        )
        assert Newton(balloon.model, Solver(rtol=1e-9)).solve().converged  # an equilibrium
