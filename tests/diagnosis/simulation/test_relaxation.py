"""Quasi-linear viscoelasticity: loads against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.diagnosis.finger.closed_forms import relaxed
from dolfingrip.extensions.prony import Prony

TIME_s = np.array([0.0, 0.5, 1.0, 4.0, 4.0, 9.0, 30.0])
RAMP = 3.0 * TIME_s
PRONY = Prony(g=(0.2, 0.1), tau_s=(2.0, 40.0))


def test_a_ramp_relaxes_as_its_branches_do() -> None:
    """Reference: v = a τ (1 − exp(−t/τ)) of a ramp of the rate a, in branches of gᵢ/(1 − Σg)."""
    expected = RAMP.copy()
    for g, tau_s in zip(PRONY.g, PRONY.tau_s, strict=True):
        expected += g / 0.7 * 3.0 * tau_s * (1 - np.exp(-TIME_s / tau_s))
    assert relaxed(PRONY, TIME_s, RAMP) == pytest.approx(expected, rel=1e-12)


def test_a_load_that_is_held_decays() -> None:
    """Reference: what a branch bears decays as exp(−t/τ)."""
    one = Prony(g=(0.2,), tau_s=(2.0,))
    found = relaxed(one, np.array([0.0, 1.0, 4.0, 60.0]), np.array([0.0, 5.0, 5.0, 5.0]))
    assert found[2] - 5.0 == pytest.approx((found[1] - 5.0) * np.exp(-1.5), rel=1e-12)
    assert found[3] == pytest.approx(5.0, abs=1e-9)


def test_a_load_at_once_is_borne_by_all_branches() -> None:
    found = relaxed(PRONY, np.array([0.0]), np.array([7.0]))
    assert found == pytest.approx([7.0 / 0.7], rel=1e-12)


def test_the_elastic_load_relaxes_to_the_one_that_is_there() -> None:
    rng = np.random.default_rng(11)
    time_s = np.cumsum(rng.exponential(3.0, 40))
    load = rng.normal(size=40)
    elastic = relaxed(PRONY, time_s, load, inverse=True)
    assert relaxed(PRONY, time_s, elastic) == pytest.approx(load, abs=1e-12)
    assert np.abs(elastic - load).max() > 0.1
