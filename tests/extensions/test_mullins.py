"""Mullins softening: a cycle of loading and unloading in closed form, and what it dissipates."""

from __future__ import annotations

from math import erf

import numpy as np
import pytest
from support import bars

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.sections.tables import assignments

R, M, BETA = 1.7, 0.3, 0.15
MULLINS = tuple(
    f"extensions.mullins.{key}={value}"
    for key, value in (("inverse_r", 1 / R), ("m_MPa", M), ("beta", BETA))
)
TRAVEL = 33 * np.array([0, 0.3, 0.6, 0.3, 0.1, 0, 0.4, 0.6, 0.9, 0.5, 0, 0.9, 1.0])
MU = config.Config().material.mu_MPa


def energy(stretch: np.ndarray) -> np.ndarray:
    return MU / 2 * (stretch**2 + 2 / stretch - 3)


def test_loading_and_unloading() -> None:
    """P = η μ (λ − λ⁻²) with the largest energy so far (Ogden & Roxburgh 1999, section 4)."""
    result = bars.pull(*bars.INCOMPRESSIBLE, *MULLINS, *bars.protocol(np.arange(13), TRAVEL))
    stretch, found = bars.stress(result)
    largest = np.maximum.accumulate(energy(stretch))
    eta = np.array(
        [
            1 - erf((top - now) / (M + BETA * top)) / R
            for top, now in zip(largest, energy(stretch), strict=True)
        ]
    )
    assert eta.min() < 0.5
    np.testing.assert_allclose(found, eta * MU * (stretch - stretch**-2), rtol=2e-4, atol=5e-5)


def test_dissipation_is_never_negative() -> None:
    """Any cycle from rest to rest takes work, and only one that goes farther than all before."""
    tops = [0.2, 0.5, 0.3, 0.5, 0.9, 0.1]
    found = []
    way = np.linspace(0, 1, 9)
    travel = np.concatenate([33 * top * np.concatenate([way, way[-2::-1]]) for top in tops])
    result = bars.pull(
        *bars.INCOMPRESSIBLE, *MULLINS, *bars.protocol(np.arange(travel.size), travel)
    )
    force = result.column("force_N")
    for k in range(len(tops)):
        one = slice(17 * k, 17 * (k + 1))
        found.append(np.trapezoid(force[one], travel[one]))
    scale = force.max() * travel.max()
    farther = np.array([True, True, False, False, True, False])
    assert min(np.array(found)[farther]) > 1e-3 * scale
    assert max(np.abs(np.array(found)[~farther])) < 1e-6 * scale


def test_softening_has_a_limit() -> None:
    """1/r above 1 would turn the stress around."""
    allowed = r"extensions.mullins.inverse_r = 1.1: allowed: at least 0 and at most 1"
    with pytest.raises(ConfigError, match=allowed):
        config.load(None, assignments(["extensions.mullins.inverse_r=1.1"]))
