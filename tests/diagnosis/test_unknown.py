"""Numbers of causes, from standard normal ones by their priors."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm

from dolfingrip.config import Config, changed
from dolfingrip.diagnosis.core.blend import TangentBlend, Tangents
from dolfingrip.diagnosis.core.unknown import Cause, causes, mixture
from dolfingrip.extensions.index import effect

CAUSES = causes(Config())


def test_a_cause_may_be_far_off() -> None:
    """Nine parts of its prior are ordinary, one is four times as wide: against that mixture."""
    for name in ("force_offset", "yeoh"):
        number = next(each for each in CAUSES if each.name == name).numbers[0]
        assert number.tail == pytest.approx(4.0)
        zeta = np.linspace(-6.0, 12.0, 37)[:, None]
        told, precision = mixture(zeta, np.array([number.tail]))
        density = 0.9 * norm.pdf(zeta) + 0.1 * norm.pdf(zeta, scale=4.0)
        np.testing.assert_allclose(np.exp(-told) / np.sqrt(2 * np.pi), density, rtol=1e-12)
        more, less = (mixture(zeta + step, np.array([4.0]))[0] for step in (1e-5, -1e-5))
        np.testing.assert_allclose(precision * zeta, (more - less) / 2e-5, atol=1e-8)
        for place in (-2.0, 0.3, 9.5):
            assert number.zeta(float(number.at(place))) == pytest.approx(place, abs=1e-6)
            step = float(number.at(place + 1e-5) - number.at(place - 1e-5)) / 2e-5
            assert number.slope(place) == pytest.approx(step, rel=1e-5)


def test_a_far_instrument_is_blended_as_a_near_one() -> None:
    """It is straight in its own number, six standard deviations out and more."""
    cause = next(each for each in CAUSES if each.name == "force_offset")
    (offset,) = cause.numbers
    assert offset.high > 6
    u, rate = offset.coordinate_of(float(offset.at(0.3)))
    told = np.array([[float(offset.at(0.3)), rate]]) * np.ones((5, 2))
    found = TangentBlend.of([offset], Tangents(np.array([[u]]), told[None]), np.full(5, 0.02))
    anywhere = np.linspace(offset.low, offset.high, 41)[:, None]
    told, true = found.at(anywhere) @ found.columns.T, offset.at(anywhere) * np.ones(5)
    np.testing.assert_allclose(told, true, atol=1e-8)


def test_a_number_that_all_simulations_share_tells_none_of_them_apart() -> None:
    """A lag is worked out at many constants and one modulus: any other modulus has the nearest."""
    (force,) = next(each for each in CAUSES if each.name == "force_offset").numbers
    numbers = [force, force]
    u = np.array([[0.5, at] for at in np.linspace(-3.0, 3.0, 13)])

    def told(own: np.ndarray, lag: np.ndarray) -> np.ndarray:
        """Values and derivatives by both numbers of five readings, linear in the first."""
        phase = np.arange(5.0)[:, None] + lag
        return np.stack([own * np.sin(phase), np.sin(phase), own * np.cos(phase)], -1)

    runs = Tangents(u, np.moveaxis(told(*u.T), 1, 0))
    found = TangentBlend.of(numbers, runs, np.full(5, 0.02))
    for own in (0.5, -1.5, 8.0):
        for lag in (-1.0, 2.5):
            at = np.array([[own, lag]])
            g, slopes = found.at_coordinates(at)
            exact = told(*at.T)[:, 0]
            np.testing.assert_allclose(found.columns @ g[0], exact[:, 0], atol=1e-3)
            np.testing.assert_allclose(found.columns @ slopes[0, :, 0], exact[:, 1], atol=1e-3)


def test_a_number_that_fits_find_close_to_nothing_is_nothing() -> None:
    """A configuration refuses numbers that a slip of a unit made, such as a length of 1e-55 mm."""
    cause = next(each for each in CAUSES if each.name == "force_offset")
    (offset,) = cause.numbers
    assert [float(offset.at(zeta)) for zeta in (-1e-55, 0.0)] == [0.0, 0.0]
    assert changed(Config(), cause.overrides([-1e-55])).extensions.force_offset is not None


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
