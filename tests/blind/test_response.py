"""The blind benchmark: readings at any strength, and causes that no catalogue has."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from blind.made_up import made_up

from benchmarks.blind import noise, outsiders
from benchmarks.blind.protocols import FINGERS, PROTOCOLS
from benchmarks.blind.response import Hidden, Truth


def test_longer_protocols_begin_as_shorter_ones() -> None:
    for name in FINGERS:
        whole = PROTOCOLS[PROTOCOLS[name].history]
        for course in PROTOCOLS[name].courses:
            if course.experiment != "coupon":
                longer = whole.course(course.experiment).rows
                pd.testing.assert_frame_equal(course.rows, longer.iloc[: len(course.rows)])


def test_a_modulus_scales_and_a_regulator_shifts() -> None:
    """α(p; cμ) = α(p/c), F(p; cμ) = c F(p/c), against the curve itself; α from the pose at rest.

    The plate is set against the tip at rest, which has bent away by −2 kPa: 0.2 mm for each kPa.
    """
    catalogue = made_up()
    truth = Truth((), {"modulus": 1.0, "pressure_gain": 2.0, "pressure_offset": -1.0})
    bending, blocked = catalogue.readings(truth)
    c = np.exp(0.2)
    x = (1.03 * bending["pressure_kPa"] - 2) / c / 250
    angle_deg = 100 * (x + 0.3 * x**2)
    np.testing.assert_allclose(bending["angle_deg"], angle_deg - angle_deg[0], atol=1e-6)
    x = x.to_numpy()
    at = 250 * x
    nearer = 0.2 * at[0] * -0.02 * at / (at + 20)
    force_N = c * (3 * (x + 0.3 * x**2) + nearer)
    force_N[[0, -1]] = 0.0
    np.testing.assert_allclose(blocked["force_N"], force_N, atol=3e-4)
    assert force_N[1] - c * 3 * (x + 0.3 * x**2)[1] > 2e-3


def test_strengths_are_interpolated_through_nothing() -> None:
    """The changes here are quadratic in the strength, so that two simulations tell all."""
    catalogue = made_up()
    none = catalogue.vector(Truth())
    one, other = (
        catalogue.vector(Truth((Hidden("mooney_rivlin", 0, part),))) - none for part in (1.0, 0.3)
    )
    np.testing.assert_allclose(other, one * (0.3 + 0.1 * 0.09) / 1.1, atol=1e-9)
    assert np.abs(one).max() > 1


def test_a_history_differs_between_branches() -> None:
    catalogue = made_up()
    change = catalogue.vector(Truth((Hidden("prony", 0, 1.0),))) - catalogue.vector(Truth())
    index = noise.index(catalogue.protocol)
    at = (index["experiment"] == "bending") & (index["pressure_kPa"] == 125)
    loading, unloading = change[at]
    assert unloading == pytest.approx(10 * loading)


def test_outsiders_change_what_they_say() -> None:
    rows = PROTOCOLS["P2"].course("bending").rows
    leak = outsiders.OUTSIDERS["opening_leak"].pressure
    assert leak is not None
    lost = rows["pressure_kPa"].to_numpy() - leak(rows, 1.0)
    assert lost[10] == pytest.approx(0.06 * 250)
    assert lost[5] == pytest.approx(0.06 * 250 / 8)
    stuck = outsiders.OUTSIDERS["backlash"].pressure
    assert stuck is not None
    off = stuck(rows, 1.0) - rows["pressure_kPa"].to_numpy()
    np.testing.assert_allclose(off[1:11], 4)
    np.testing.assert_allclose(off[11:-1], -4)


def test_outsiders_of_a_coupon() -> None:
    rows = PROTOCOLS["coupon"].course("coupon").rows
    travel = rows["displacement_mm"].to_numpy()
    names = ("jaw_slip", "sticky_cell", "twisted_coupon")
    shown = {}
    for name in names:
        displayed = outsiders.OUTSIDERS[name].displayed
        assert displayed is not None
        shown[name] = displayed(rows, {"force_N": travel}, 1.0)["force_N"]
        assert not displayed(PROTOCOLS["P2"].course("bending").rows, {}, 1.0)
    slipped = shown["jaw_slip"] / np.where(travel > 0, travel, 1.0)
    np.testing.assert_allclose(slipped[[12, 13, 20, 39]], [1.0, 0.94, 0.94, 0.94])
    lag = travel - shown["sticky_cell"]
    np.testing.assert_allclose(lag[[0, 1, 20, 21, 40]], [0.0, 0.1, 0.1, -0.1, -0.1])
    assert (shown["twisted_coupon"] - travel).max() == pytest.approx(0.15)
    for name in names:
        assert outsiders.possible(PROTOCOLS["coupon"], name)
        assert not outsiders.possible(PROTOCOLS["P2"], name)


def test_walls_lie_between_those_that_were_simulated() -> None:
    """With a kink that thinner walls move: there exactly as simulated, beyond along a line."""
    catalogue = made_up("P1")
    curves = catalogue.library.walls["bending"]
    at = curves[0.0625].at
    for part, curve in curves.items():
        kink = np.maximum(at - 150 - 400 * part, 0) / 10
        curve.columns["angle_deg"][:] += kink  # type: ignore[index]
    base = catalogue.library.base["bending"].columns["angle_deg"]
    base += np.maximum(at - 150, 0) / 10  # type: ignore[misc]
    pressure = catalogue.protocol.course("bending").rows["pressure_kPa"].to_numpy()

    def angle(sigmas: float) -> np.ndarray:
        return catalogue.readings(Truth((), {"wall": sigmas}))[0]["angle_deg"].to_numpy()

    on_stops = np.isin(pressure, at)
    assert on_stops.sum() > 3
    for sigmas, part in ((-2.5, -0.125), (-1.25, -0.0625), (1.25, 0.0625), (2.5, 0.125)):
        there = curves[part].columns["angle_deg"][np.isin(at, pressure)]
        np.testing.assert_allclose(angle(sigmas)[on_stops], there, atol=1e-9)
    beyond = [angle(sigmas) for sigmas in (2.5, 2.7, 2.9)]
    np.testing.assert_allclose(beyond[2] - beyond[1], beyond[1] - beyond[0], atol=1e-9)
