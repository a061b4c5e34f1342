"""How a control moved, found from its rows alone."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.diagnosis.data.motion import motion, smallest_change

SEED = 4

RATE_kPa_per_s = 10.0


def led(*places: tuple[float, float], every_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of a control that ramps to each place (kPa) and waits there (s)."""
    corners = [(0.0, 0.0)]
    for value, wait_s in places:
        time_s = corners[-1][0] + abs(value - corners[-1][1]) / RATE_kPa_per_s
        corners += [(time_s, value), (time_s + wait_s, value)]
    times, values = zip(*corners, strict=True)
    time_s = np.arange(0.0, times[-1] + 1e-9, every_s)
    return time_s, np.interp(time_s, times, values)


@pytest.mark.parametrize("sigma", [0.0, 0.4])
@pytest.mark.parametrize(
    ("places", "every_s", "legs", "cycles"),
    [
        ([(100.0, 0.0)], 2.0, "l", 1),
        ([(100.0, 0.0)], 0.05, "l", 1),
        ([(100.0, 20.0), (0.0, 0.0)], 0.1, "lhu", 1),
        ([(20.0, 10.0), (40.0, 10.0), (60.0, 10.0)], 0.25, "lhlhlh", 1),
        ([(50.0, 5.0), (0.0, 5.0), (80.0, 5.0), (0.0, 5.0)], 0.2, "lhuhlhuh", 2),
        (3 * [(60.0, 0.0), (0.0, 0.0)], 0.2, "lululu", 3),
        (2 * [(60.0, 0.0), (20.0, 0.0)], 1.0, "lulu", 2),
        # suction loads as pressure does
        ([(-80.0, 0.0)], 2.0, "l", 1),
        ([(-20.0, 10.0), (-40.0, 10.0)], 0.25, "lhlh", 1),
        (3 * [(-60.0, 0.0), (0.0, 0.0)], 0.2, "lululu", 3),
        ([(-80.0, 20.0), (0.0, 0.0)], 0.1, "lhu", 1),
        ([*2 * [(-60.0, 0.0), (90.0, 0.0)], (0.0, 0.0)], 0.2, "lulululu", 2),
    ],
)
def test_ramps_and_waits(
    places: list[tuple[float, float]], every_s: float, legs: str, cycles: int, sigma: float
) -> None:
    """Whatever the rows are dense and noisy; σ is what the laboratory told."""
    print("seed", SEED)
    time_s, value = led(*places, every_s=every_s)
    read = value + np.random.default_rng(SEED).normal(0, sigma, len(value))
    found = motion([read], time_s, sigma)
    first = np.flatnonzero(np.diff(found.leg, prepend=-1))
    assert "".join(found.branch[i][0] for i in first) == legs
    assert found.cycle.iloc[-1] == cycles
    # a leg ends where the control turns or stops, to a few of its rows
    moves = np.array([b != "hold" for b in found.branch])
    rests = np.abs(np.diff(value, prepend=value[0] - 1)) < 1e-9
    assert np.mean(moves == ~rests) > 0.9


def test_without_times_nothing_waits() -> None:
    found = motion([np.array([0.0, 10, 10, 20])], np.full(4, np.nan), 0.0)
    assert list(found.branch) == 4 * ["loading"]


def test_few_rows_of_a_restless_regulator_are_a_wait() -> None:
    time_s = np.array([0.0, 10, 60, 70, 130, 140, 200])
    found = motion([np.array([0.0, 49.6, 50.3, 99.6, 100.3, 99.7, 100.2])], time_s, 0.0)
    assert list(found.branch[[1, 2, 3]]) == ["loading", "hold", "loading"]
    assert "unloading" not in set(found.branch)


@pytest.mark.parametrize(
    ("places", "legs"),
    [
        ([(20.0, 10.0), (40.0, 10.0), (60.0, 10.0)], "lhlhlh"),
        ([(100.0, 20.0), (0.0, 0.0)], "lhu"),
    ],
)
def test_dense_rows_show_a_noise_that_nobody_told(
    places: list[tuple[float, float]], legs: str
) -> None:
    """The gauge's noise is 0.4 % of the largest pressure; at most 0.5 % is taken from the rows."""
    print("seed", SEED)
    time_s, value = led(*places, every_s=0.1)
    sigma = 0.004 * value.max()
    read = value + np.random.default_rng(SEED).normal(0, sigma, len(value))
    found = motion([read], time_s, 0.0)
    first = np.flatnonzero(np.diff(found.leg, prepend=-1))
    assert "".join(found.branch[i][0] for i in first) == legs
    assert smallest_change(read, 0.0) == pytest.approx(smallest_change(read, sigma), rel=0.3)
    assert smallest_change(read, 0.0) > 1.05 * smallest_change(value, 0.0)
