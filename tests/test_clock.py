"""A log and a video that are known to be apart by some seconds, with a lag or none."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip import clock
from dolfingrip.sections.errors import ConfigError

LOG_S = np.arange(0.0, 40.0, 0.1)


def pressure(time_s: np.ndarray) -> np.ndarray:
    """A ramp up, a wait, a ramp down and a lower ramp, which no shift brings onto itself."""
    return np.interp(time_s, [8, 16, 19, 25, 28, 32, 35], [0, 90, 90, 0, 0, 50, 0])


def motion(time_s: np.ndarray, seed: int = 0) -> np.ndarray:
    """An angle that bends with the pressure, with noise."""
    p = pressure(time_s)
    return 0.3 * p + 0.002 * p**2 + np.random.default_rng(seed).normal(0, 0.2, len(p))


@pytest.mark.parametrize("shift", [-3.37, 0.0, 7.21])
def test_a_motion_tells_the_shift_to_the_lag(shift: float) -> None:
    """What is left of the shift is far below its error, which is that of a finger's lag."""
    time_s = np.arange(0.0, 30.0, 1 / 30)
    found = clock.by_motion(LOG_S + shift + 5.0, pressure(LOG_S), time_s, motion(time_s + 5.0))
    assert found.shift_s == pytest.approx(shift + 10.0, abs=0.03)
    assert found.std_s >= clock.POLICY.lag_s
    late = clock.by_motion(LOG_S, pressure(LOG_S), time_s, motion(time_s + 5.0 - 0.25))
    assert abs(late.shift_s - 5.0) == pytest.approx(0.25, abs=0.03)
    assert abs(late.shift_s - 5.0) < 1.645 * late.std_s


def test_a_drift_of_a_long_record_is_told() -> None:
    time_s = np.arange(0.0, 400.0, 0.1)
    log_s = np.arange(0.0, 420.0, 0.1)

    def cycles(at: np.ndarray) -> np.ndarray:
        return 45 * (1 - np.cos(2 * np.pi * at / 23.0)) * (1 + 0.3 * np.sin(at / 57.0))

    found = clock.by_motion(log_s, cycles(log_s), time_s, cycles(3.0 + 1.001 * time_s))
    assert found.rate == pytest.approx(1.001, abs=2e-4)
    assert found.of(np.array([400.0])) == pytest.approx(403.4, abs=0.06)


def test_a_repeated_cycle_is_doubted_and_another_test_is_refused() -> None:
    def cycles(at: np.ndarray) -> np.ndarray:
        return 45 * (1 - np.cos(2 * np.pi * at / 5.0))

    time_s = np.arange(0.0, 15.0, 1 / 30)
    assert "as well" in clock.by_motion(LOG_S, cycles(LOG_S), time_s, cycles(time_s + 10.0)).doubt
    noise = np.random.default_rng(3).normal(size=len(time_s))
    with pytest.raises(ConfigError, match=r"explains .* of the motion.*--shift"):
        clock.by_motion(LOG_S, pressure(LOG_S), time_s, noise)


def test_a_light_tells_the_shift_to_half_a_frame() -> None:
    """It goes on between two frames, or within the exposure of one, which is partly bright."""
    time_s = np.arange(0.0, 4.0, 1 / 30)
    log_s = np.arange(0.0, 6.0, 0.01)
    for at in np.linspace(1.0, 1.04, 9):
        exposed = np.clip((time_s + 0.008 - at) / 0.016, 0, 1)
        light = 40 + 180 * exposed + np.random.default_rng(1).normal(0, 1, len(time_s))
        seen = clock.steps_up(time_s, light)
        told = clock.steps_up(log_s, (log_s >= at + 1.7).astype(float))
        found = clock.by_events(told, seen, 0.01, 1 / 30, "a light")
        assert abs(found.shift_s - 1.7) < 0.5 / 30
        assert found.std_s < 0.02
    with pytest.raises(ConfigError, match="0 in the video and 1 in the log"):
        clock.by_events(told, np.zeros(0), 0.01, 1 / 30, "a light")


def test_a_knock_tells_it_too() -> None:
    time_s = np.arange(0.0, 4.0, 1 / 30)
    places = np.column_stack([20 * np.sin(time_s + i) for i in range(4)])
    places[45:] += 3.0
    assert clock.knock(time_s, places) == pytest.approx(time_s[45], abs=1 / 30)


def test_frames_outside_the_log_are_not_left_out_of_what_it_has_to_explain() -> None:
    """Steps up with vents between, whose largest ones a wrong shift puts behind the log's end."""
    time_s = np.arange(0.0, 20.5, 0.01)
    log_s = np.arange(0.0, 24.7, 0.05)
    levels = [0, 8, 0, 16, 0, 24, 0, 30, 0, 34, 0]

    def steps(at: np.ndarray) -> np.ndarray:
        return np.array(levels)[np.clip(((at - 0.5) // 2 + 1).astype(int), 0, 10)].astype(float)

    followed = np.zeros(len(time_s))
    for i, now in enumerate(steps(time_s)[1:]):
        followed[i + 1] = followed[i] + (now - followed[i]) * 0.01 / 0.2
    found = clock.by_motion(log_s, steps(log_s - 3.2), time_s, followed**4)
    assert found.shift_s == pytest.approx(3.2, abs=1.645 * found.std_s)
