"""Frequency, decay and spectrum of a free swing, and how charts show them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from dolfingrip.experiments import ring_down
from dolfingrip.experiments.chart import DrawnResult, chart, over, panels, spectrum
from dolfingrip.experiments.index import find

BEAM = Path(__file__).parents[2] / "examples" / "released_beam" / "ring_down.csv"
TIME_S = np.arange(0.0, 0.5, 0.005)
PRESSURE_KPA = 100 * np.minimum(TIME_S / 0.05, 1.0)


def swinging(rate_per_s: float = 4.0, creep: float = 3.0) -> np.ndarray:
    """An angle (°) that swings at 10 Hz, in closed form, after the pressure has risen."""
    since = TIME_S - 0.05
    free = 15 + creep * since
    free += 10 * np.exp(-rate_per_s * since) * np.cos(2 * np.pi * 10 * since + 2)
    return np.where(TIME_S < 0.05, free[10] * TIME_S / 0.05, free)


def test_a_swing_is_found_again() -> None:
    swing = ring_down.fit(TIME_S, PRESSURE_KPA, swinging())
    assert swing is not None
    assert swing.frequency_Hz == pytest.approx(10.0, rel=1e-6)
    assert swing.ratio == pytest.approx(np.exp(-0.4), rel=1e-6)
    assert swing.rest(0.35) == pytest.approx(15.9, rel=1e-6)
    low, high = swing.envelope(TIME_S[20:])
    assert ((swinging()[20:] >= low - 1e-6) & (swinging()[20:] <= high + 1e-6)).all()


def test_what_does_not_swing_has_no_ring_down() -> None:
    """A record that creeps with noise, one with a single swing, and one that is read too rarely."""
    rng = np.random.default_rng(4)
    creeping = 15 * (1 - np.exp(-TIME_S / 0.1)) + 0.02 * rng.normal(size=len(TIME_S))
    assert ring_down.fit(TIME_S, PRESSURE_KPA, creeping) is None
    short = TIME_S < 0.15
    assert ring_down.fit(TIME_S[short], PRESSURE_KPA[short], swinging()[short]) is None
    assert ring_down.fit(TIME_S[::5], PRESSURE_KPA[::5], swinging()[::5]) is None


@pytest.mark.parametrize(
    ("mass_g", "frequency_Hz", "ratio"), [(0, 7.7, 0.71), (52, 4.35, 0.72), (101, 3.4, 0.66)]
)
def test_a_measured_beam(mass_g: int, frequency_Hz: float, ratio: float) -> None:
    """Frequencies and ratios that the laboratory tells of the whole records."""
    for name, rows in pd.read_csv(BEAM).groupby("specimen"):
        if str(name).startswith(f"{mass_g} g "):
            time_s = rows["time_s"].to_numpy()
            swing = ring_down.fit(time_s, np.zeros(len(time_s)), rows["tip_x_mm"].to_numpy())
            assert swing is not None
            assert swing.frequency_Hz == pytest.approx(frequency_Hz, rel=0.03)
            assert swing.ratio == pytest.approx(ratio, rel=0.1)


def test_a_steady_swing_has_its_amplitude_in_the_spectrum() -> None:
    frequencies, sizes = ring_down.spectrum(TIME_S, 3 + 2 * np.sin(2 * np.pi * 20 * TIME_S))
    assert frequencies[np.argmax(sizes)] == pytest.approx(20, abs=0.5)
    assert sizes.max() == pytest.approx(2, rel=0.01)
    assert frequencies[-1] == pytest.approx(100)


def test_a_result_in_motion_is_drawn_over_time() -> None:
    bending = find("bending")
    table = {
        "time_s": TIME_S, "pressure_kPa": PRESSURE_KPA, "angle_deg": swinging(),
        "branch": ["loading"] * len(TIME_S),
    }  # fmt: skip
    assert over(bending, table).name == "pressure_kPa"
    moving = {**table, "kinetic_energy_mJ": np.ones(len(TIME_S))}
    assert over(bending, moving).name == "time_s"
    assert "Pressure (kPa)" in [panel.label for panel in panels(bending, moving)]
    drawn = chart(bending, [DrawnResult(moving)])
    assert drawn.x.label == "Time (s)"
    assert "envelope: 10 Hz, each swing 0.67 of the one before" in [s.name for s in drawn.series]
    measured = {**table, "experiment": ["bending"] * len(TIME_S)}
    frequencies = spectrum(bending, [DrawnResult(moving)], measured)
    assert frequencies is not None
    assert [series.name for series in frequencies.series] == ["simulated", "measured"]
    still = {**moving, "angle_deg": PRESSURE_KPA}
    assert spectrum(bending, [DrawnResult(still)]) is None
