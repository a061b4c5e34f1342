"""A balloon under volume control passes the greatest pressure, where pressure control ends."""

from __future__ import annotations

import numpy as np
import pytest
from support import bodies, spheres

from dolfingrip.config import KPA, Solver
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import VolumeControl, volume_controlled
from dolfingrip.mechanics.path.path import LoadPath

NAME = "cavity_volume_mm3"


@pytest.fixture
def controlled(balloon: bodies.Body) -> tuple[bodies.Body, VolumeControl, LoadPath]:
    """The balloon, its volume as a control, and its load path."""
    model = balloon.model
    ds = model.domain.surface("cavity", quadrature_degree=6)
    density = cavity_pressure.volume_density(balloon.u, model.domain.mesh)
    controlled = volume_controlled(model, model.controls["pressure_kPa"], density * ds)
    volume = controlled.terms[-1]
    newton = Newton(controlled, Solver(rtol=1e-11))
    return balloon, volume, LoadPath(newton, {NAME: volume.control.value})


def test_passes_the_greatest_pressure(
    controlled: tuple[bodies.Body, VolumeControl, LoadPath],
) -> None:
    """Pressures up to twice the radius follow the radial equation, which falls from 1.54 on.

    The mesh has one or two quadratic elements across the wall: 0.2 % in pressure at a given
    radius, as under pressure control.
    """
    balloon, volume, path = controlled
    rest = volume.control.value
    pressures = []
    for stretch in (1.2, 1.4, 1.54, 1.7, 2.0):
        arrival = path.advance({NAME: rest * stretch**3})
        assert arrival.failure is None
        assert volume.volume_mm3() == pytest.approx(rest * stretch**3, rel=1e-10)
        pressures.append(balloon.model.controls["pressure_kPa"].value)
        expected = spheres.pressure_MPa(stretch, balloon.mu.value, balloon.lmbda.value) / KPA
        print(f"stretch {stretch}: {pressures[-1]:.3f} kPa, radial equation {expected:.3f} kPa")
        assert pressures[-1] == pytest.approx(expected, rel=2e-3)
    assert pressures[2] > pressures[3] > pressures[4]


def test_way_back(controlled: tuple[bodies.Body, VolumeControl, LoadPath]) -> None:
    """Deflated to its first volume the balloon is what it was."""
    balloon, volume, path = controlled
    rest = volume.control.value
    for target in (8 * rest, rest):
        assert path.advance({NAME: target}).failure is None
    assert abs(balloon.model.controls["pressure_kPa"].value) < 1e-6
    assert np.abs(balloon.displacement()).max() < 1e-8


def test_an_iterate_that_diverges_does_not_loosen_the_tolerance(
    controlled: tuple[bodies.Body, VolumeControl, LoadPath],
) -> None:
    """The residual is judged by the pressure's load on the sphere at the step's start.

    That load is p times the norm of ∂V/∂u of the meshed part, which the coupling holds.
    Diverging iterates have a million times the pressure, which would let any residual pass.
    """
    balloon, volume, path = controlled
    assert path.advance({NAME: volume.control.value * 1.2**3}).failure is None
    before = volume.scale_N()
    rates = volume.couplings(balloon.u.x.array)[0].hessian.toarray() / volume.unknown.scale
    expected = abs(volume.unknown.value) * np.linalg.norm(rates)
    assert before == pytest.approx(expected, rel=1e-6)
    volume.unknown.constant.value *= 1e6
    volume.couplings(balloon.u.x.array)
    assert volume.scale_N() == before
