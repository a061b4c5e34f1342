"""The pressure's maximum is found where it is near, and only there."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies
from support.paths import by_pressure

from dolfingrip.config import Solver
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.greatest import greatest

GREATEST_KPA = 316.0
"""The balloon's, see test_failure."""


@pytest.mark.parametrize(
    ("part", "near"), [(0.3, False), (0.6, False), (0.9, False), (0.999, True)]
)
def test_limit_point_ahead(balloon: bodies.Body, part: float, near: bool) -> None:
    """The search finds the balloon's limit point below a pressure, and only from near it."""
    model = balloon.model
    settings = Solver(rtol=1e-9)
    arrival = by_pressure(Newton(model, settings)).advance({"pressure_kPa": part * GREATEST_KPA})
    assert arrival.failure is None
    before = model.state()
    ds = model.domain.surface("cavity", quadrature_degree=6)
    volume = cavity_pressure.volume_density(balloon.u, model.domain.mesh) * ds
    pressure = model.controls["pressure_kPa"]
    # as a step of a hundredth more is asked for
    beyond_kPa = (part + 0.01) * GREATEST_KPA
    found = greatest(model, pressure, volume, settings, beyond_kPa, 1e-4)
    assert (found is not None) is near
    after = model.state()
    assert after.controls == before.controls
    np.testing.assert_array_equal(after.displacement, before.displacement)
