"""Interpolation between stops."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.diagnosis.simulation.stops import StopInterpolant, StopSchedule


def leg(stops: np.ndarray, rows_at: np.ndarray) -> StopInterpolant:
    return StopInterpolant(np.arange(len(stops)), stops, np.arange(len(rows_at)), rows_at)


def test_a_cubic_is_met_and_a_stop_is_itself() -> None:
    stops = np.array([50.0, 30.0, 20.0, 5.0, 0.0])  # unloading: falling

    def cubic(p: np.ndarray) -> np.ndarray:
        return 1 + p - 0.1 * p**2 + 1e-3 * p**3

    made = leg(stops, np.array([50.0, 41.0, 20.0, 2.5]))
    np.testing.assert_allclose(made.weights(5) @ cubic(stops), cubic(made.rows_at), rtol=1e-12)
    np.testing.assert_allclose(made.weights(5)[2], [0, 0, 1, 0, 0], atol=1e-14)
    slope = 1 - 0.2 * made.rows_at + 3e-3 * made.rows_at**2
    np.testing.assert_allclose(made.weights(5, derivative=1) @ cubic(stops), slope, rtol=1e-12)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_stops(count: int) -> None:
    stops = np.array([0.0, 10.0, 25.0])[:count]
    made = leg(stops, np.array([0.0, 5.0]))
    np.testing.assert_allclose(made.weights(count) @ np.full(count, 7.0), 7.0)
    if count > 1:
        np.testing.assert_allclose(made.weights(count) @ (2 * stops), [0.0, 10.0], atol=1e-12)


@pytest.mark.parametrize("falling", [False, True])
def test_a_force_that_begins_between_stops_is_read_from_those_at_which_it_acts(
    *, falling: bool
) -> None:
    """Contact at 23 kPa between stops at 20 and 30; of what the force changes by, too."""
    stops = np.arange(0.0, 101.0, 10.0)[:: -1 if falling else 1]

    def pressed(p: np.ndarray, touch: float = 23.0) -> np.ndarray:
        return np.where(p > touch, 0.02 * (p - touch) + 1e-4 * (p - touch) ** 2, 0.0)

    rows = np.array([0.0, 5.0, 21.0, 24.5, 28.0, 30.0, 33.0, 75.0])
    made, force = leg(stops, rows), pressed(stops)
    found = made.weights(11, force=force) @ force
    np.testing.assert_allclose(found, pressed(rows), atol=0.006)
    assert np.abs(made.weights(11) @ force - pressed(rows)).max() > 0.015
    rate = made.weights(11, derivative=1, force=force) @ force
    slope = np.where(rows > 23.0, 0.02 + 2e-4 * (rows - 23.0), 0.0)
    np.testing.assert_allclose(rate, slope, atol=0.002)
    later = pressed(stops, 23.1) - force
    told = made.weights(11, force=force) @ later
    np.testing.assert_allclose(told[:3], 0.0)
    np.testing.assert_allclose(told[3:], (pressed(rows, 23.1) - pressed(rows))[3:], atol=3e-4)


def test_a_force_that_acts_from_the_start_is_read_from_all_stops() -> None:
    stops = np.arange(0.0, 101.0, 10.0)
    made, force = leg(stops, np.array([3.0, 55.0])), 0.02 * stops + 1e-4 * stops**2
    np.testing.assert_array_equal(made.weights(11, force=force), made.weights(11))


def test_beyond_the_last_stop_a_line_goes_on() -> None:
    stops = np.linspace(0, 10, 6)
    made = leg(stops, np.array([12.0]))
    np.testing.assert_allclose(made.weights(6) @ stops**2, 100 + 2 * 20)


def test_what_was_not_reached_has_no_number() -> None:
    stops = np.linspace(0, 100, 5)
    made = leg(stops, np.array([10.0, 51.0, 75.0]))
    found = made.weights(3) @ stops
    np.testing.assert_allclose(found[:2], [10.0, 51.0])
    assert np.isnan(found[2])
    assert np.isnan(made.weights(0)).all()


def test_a_route_puts_legs_together() -> None:
    up = StopInterpolant(
        np.array([0, 1, 2]), np.array([0.0, 10, 20]), np.array([0, 1]), np.array([0.0, 15])
    )
    wait = StopInterpolant(np.array([2, 3]), np.array([2.0, 12.0]), np.array([2]), np.array([7.0]))
    made = StopSchedule(
        "pressure_kPa", (0.0, 1.0, 2.0, 12.0), (0.0, 10.0, 20.0, 20.0), (1, 1, 1, 1),
        ("loading", "loading", "loading", "hold"), (up, wait),
    )  # fmt: skip
    found = made.at_rows(np.array([0.0, 5.0, 10.0, 12.0]), 4)
    np.testing.assert_allclose(found[:3], [0.0, 7.5, 11.0])
    assert np.isnan(found[3])
    np.testing.assert_allclose(
        made.at_rows(np.array([0.0, 5.0, 10.0, 12.0]), 4, 1)[:3], [0.5, 0.5, 0]
    )
    assert made.protocol()["pressure_kPa"] == [0.0, 10.0, 20.0, 20.0]
