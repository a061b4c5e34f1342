"""Numbers of causes, from standard normal ones by their priors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.emulator import places, trained
from dolfingrip.diagnosis.core.unknown import Cause, causes
from dolfingrip.extensions.index import effect

CAUSES = causes(Config())
SEED = 3


def test_an_instrument_may_be_far_off() -> None:
    """Nine parts of its prior are ordinary, one is four times as wide: against that mixture."""
    (offset,) = next(each for each in CAUSES if each.name == "force_offset").numbers
    print("seed", SEED)
    zeta = np.random.default_rng(SEED).standard_normal(100_000)
    sigma = np.abs(offset.at(np.clip(zeta, -3.3, 3.3)) / offset.prior.spread)
    for size in (0.5, 1.0, 3.0, 6.0):
        expected = 2 * (0.9 * norm.sf(size) + 0.1 * norm.sf(size / 4))
        off = 4 * np.sqrt(expected / len(zeta))
        assert (sigma > size).mean() == pytest.approx(expected, abs=off)
    for place in (-2.0, 0.3, 2.5):
        assert offset.zeta(float(offset.at(place))) == pytest.approx(place, abs=1e-6)
        step = float(offset.at(place + 1e-5) - offset.at(place - 1e-5)) / 2e-5
        assert offset.slope(place) == pytest.approx(step, rel=1e-5)


def test_a_far_instrument_is_emulated_as_a_near_one() -> None:
    """Straight in the instrument's own number, which is no polynomial of ζ."""
    cause = next(each for each in CAUSES if each.name == "force_offset")
    (offset,) = cause.numbers
    zeta = places(cause.box(), 64)
    changes, noise = offset.at(zeta) * np.ones(5), np.full(5, 0.02)
    found = trained(zeta, changes, noise, cause.box(), cause.stretches)
    assert found.left < 1e-6
    anywhere = np.linspace(offset.low, offset.high, 41)[:, None]
    told, true = found.at(anywhere) @ found.columns.T, offset.at(anywhere) * np.ones(5)
    np.testing.assert_allclose(told, true, atol=1e-8)


@pytest.mark.parametrize("cause", CAUSES, ids=[each.name for each in CAUSES])
def test_each_number_that_is_tried_is_allowed(cause: Cause) -> None:
    """Also near an exponent of 0, which Ogden's law does not have."""
    middle = np.clip(np.zeros(len(cause.numbers)), *cause.box().T)
    for place, number in enumerate(cause.numbers):
        for zeta in np.linspace(number.low, number.high, 301):
            every = middle.copy()
            every[place] = zeta
            values = {}
            for own, z in zip(cause.numbers, every, strict=True):
                value = float(own.at(z))
                values[own.key.rpartition(".")[2]] = [value] if own.listed else value
            effect(cause.name).model_validate(values)
