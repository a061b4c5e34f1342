"""A loss factor that is nearly constant: its moduli, a bar that is shaken, and bad input."""

from __future__ import annotations

import numpy as np
import pytest
from support import bars

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.extensions.loss_factor import LossFactor
from dolfingrip.sections.tables import assignments

STRAIN, PERIODS, PER_PERIOD = 1e-4, 2, 60


def modulus(effect: LossFactor, frequency_hz: np.ndarray | float) -> np.ndarray:
    """Complex modulus by that at rest: 1 + Σ mᵢ iωτᵢ/(1 + iωτᵢ) of Maxwell branches."""
    g, tau = map(np.array, effect.branches())
    x = 2j * np.pi * np.asarray(frequency_hz)[..., None] * tau
    return 1 + (g / (1 - g.sum()) * x / (1 + x)).sum(axis=-1)


@pytest.mark.parametrize("eta", [0.02, 0.11, 0.3])
@pytest.mark.parametrize("highest", [10.0, 100.0, 1000.0])
def test_tan_delta_is_nearly_constant(eta: float, highest: float) -> None:
    """Over each range of decades to a tenth, in the middle of a decade and at its ends."""
    effect = LossFactor(loss_factor=eta, lowest_Hz=1.0, highest_Hz=highest)
    found = modulus(effect, np.geomspace(1.0, highest, 200))
    assert len(effect.branches()[0]) == 1 + np.log10(highest)
    np.testing.assert_allclose(found.imag / found.real, eta, rtol=0.1)


def test_the_modulus_grows_as_causality_demands() -> None:
    """Reference: |G| ∝ ωⁿ has the loss angle πn/2 at all frequencies (Kramers & Kronig)."""
    eta = 0.15
    effect = LossFactor(loss_factor=eta, lowest_Hz=1.0, highest_Hz=1e4)
    growth = modulus(effect, 1e3).real / modulus(effect, 1e1).real
    assert growth == pytest.approx(100 ** (2 / np.pi * np.arctan(eta)), rel=0.01)


def test_at_rest_it_is_the_elastic_solid_and_at_once_the_sum() -> None:
    effect = LossFactor(loss_factor=0.11)
    assert modulus(effect, 1e-6) == pytest.approx(1.0, abs=1e-5)
    assert modulus(effect, 1e9) == pytest.approx(1 / (1 - sum(effect.branches()[0])), rel=1e-5)


@pytest.mark.parametrize("frequency_hz", [1.0, 5.0, 30.0])
def test_a_shaken_bar(frequency_hz: float) -> None:
    """Its stress against the closed form of Maxwell branches under ε sin ωt from rest on.

    σ = E∞ ε (sin ωt + Σ mᵢ x (x sin ωt + cos ωt − exp(−t/τᵢ))/(1 + x²)), x = ωτᵢ. Steps that are
    linear in time leave (ωΔt)²/12 of the amplitude.
    """
    effect = LossFactor(loss_factor=0.2)
    times = np.arange(PERIODS * PER_PERIOD + 1) / (PER_PERIOD * frequency_hz)
    omega = 2 * np.pi * frequency_hz
    result = bars.pull(
        "extensions.loss_factor.loss_factor=0.2", *bars.INCOMPRESSIBLE,
        *bars.protocol(times, 33 * STRAIN * np.sin(omega * times)),
    )  # fmt: skip
    g, tau = (np.array(each)[:, None] for each in effect.branches())
    x, sine, cosine = omega * tau, np.sin(omega * times), np.cos(omega * times)
    branches = x * (x * sine + cosine - np.exp(-times / tau)) / (1 + x**2)
    parts = sine + (g / (1 - g.sum()) * branches).sum(axis=0)
    expected = 3 * config.Config().material.mu_MPa * STRAIN * parts
    found = result.column("nominal_stress_MPa")
    assert np.abs(found - expected).max() < 2e-3 * np.abs(expected).max()


def test_refusals() -> None:
    for line, told in (
        ("highest_Hz=1.5", "highest_Hz = 1.5: allowed: 2 to 1e6 times lowest_Hz"),
        ("loss_factor=1.5", "extensions.loss_factor.loss_factor = 1.5"),
    ):
        with pytest.raises(ConfigError, match=told):
            config.load(None, assignments([f"extensions.loss_factor.{line}"]))
