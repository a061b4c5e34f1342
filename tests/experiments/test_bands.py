"""Intervals of readings from what is not known exactly, by the derivatives of one run."""

from __future__ import annotations

from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from support import small
from support.command import run_command

from dolfingrip.channels import of_band
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments import run
from dolfingrip.experiments.derivatives.bands import LEVEL, Bands, band_sentences
from dolfingrip.experiments.index import find
from dolfingrip.experiments.result import Result
from dolfingrip.files.table import read_csv
from dolfingrip.parameter.nuisances import STIFFNESSES, changes

WIDTH = NormalDist().inv_cdf((1 + LEVEL) / 2)
"""Half of a band by the standard deviation of a normal number."""

NONE = {
    "modulus": 0.0, "wall": 0.0, "pressure_gain": 0.0, "pressure_offset_kPa": 0.0,
    "plate_gap_mm": 0.0, "specimen_scale": 0.0,
}  # fmt: skip
"""Everything is known exactly."""


def _config() -> Config:
    return small.short("experiment.step_kPa=25", "plate.gap_mm=0.5")


def _moved(kind: str, bands: Bands, key: str, amount: float) -> Result:
    """A run with parameters changed as one nuisance changes them."""
    found = {}
    for name, change in changes(bands.config, key, amount).items():
        section, _, inner = name.partition(".")
        value: Any = getattr(bands.config, section).number_at(inner)
        found[name] = value + change
    return run(kind, changed(bands.config, found))


@pytest.mark.parametrize(
    ("kind", "columns", "each", "within"),
    [
        ("bending", ("angle_deg",), {"modulus": 0.2, "wall": 0.05}, 0.02),
        ("blocked_force", ("force_N",), {"pressure_offset_kPa": 2.0, "plate_gap_mm": 0.1}, 0.1),
    ],
)
def test_the_ends_are_those_of_runs_with_other_numbers(
    kind: str, columns: tuple[str, ...], each: dict[str, float], within: float, tmp_path: Path
) -> None:
    """One number at a time, runs at both ends of its band; the squares of all about add up."""
    config, experiment = _config(), find(kind)
    every = run(kind, config, bands={**NONE, **each}, out=tmp_path)
    last = every.rows[2]
    beyond: dict[str, list[float]] = {column: [] for column in columns}
    for key, std in each.items():
        told = Bands.of(experiment, config, {**NONE, key: std})
        assert list(told.spreads) == [key]
        size = WIDTH * std
        steps = (np.expm1(-size), np.expm1(size)) if key in STIFFNESSES else (-size, size)
        runs = [_moved(kind, told, key, step) for step in steps]
        bands = told.ends(every.rows[:3], every.sensitivities, columns)
        for column in columns:
            there = sorted(float(one.column(column)[2]) for one in runs)
            found = [bands[end] for end in of_band(column)]
            print(key, column, "band", found, "runs", there)
            assert found == pytest.approx(there, abs=within * (there[1] - there[0]) / 2)
            beyond[column].append(found[1] - last[column])
    for column in columns:
        whole = last[of_band(column)[1]] - last[column]
        assert whole == pytest.approx(np.hypot.reduce(beyond[column]), rel=0.05)

    stored = read_csv(tmp_path / "result.csv")
    again = Result.read(tmp_path)
    assert {*map(of_band, columns)} <= {(n, n.replace("low", "high")) for n in stored}
    assert "low_pressure_kPa" not in stored
    assert again.facts.bands == each
    drawn = again.chart()
    assert drawn.series[0].high is not None
    assert drawn.series[0].high[2] == pytest.approx(last[of_band(columns[0])[1]])
    assert "95 %" in drawn.note
    said = band_sentences(experiment, again)[0]
    assert " at 50 kPa: " in said
    assert all(key in said for key in each)


def test_a_reading_at_its_maximum_has_the_quantiles_of_what_is_drawn() -> None:
    """Nothing is solved: place and angle are given functions of pressure, stiffness and offset.

    The reference is 400,000 draws (seed 7) of these functions.
    """
    told = {**NONE, "modulus": 0.2, "pressure_offset_kPa": 2.0}
    bands = Bands.of(find("bending"), _config(), told)
    (modulus,), (offset,) = (list(bands.changes[key]) for key in ("modulus", "pressure_offset_kPa"))
    of_load = {
        "angle_deg": (np.polynomial.Polynomial([0.0, 0.3, 4e-4]), 0.0),
        "tip_z_mm": (np.polynomial.Polynomial([0.0, 0.02, -2e-4]), -0.02),
    }
    """By the pressure at the stiffness 1, and by the offset."""
    rows: list[dict[str, Any]] = []
    entries: list[dict[str, Any]] = []
    for i, load in enumerate((0.0, 25.0, 50.0)):
        rows.append({"pressure_kPa": load, **{c: float(y(load)) for c, (y, _) in of_load.items()}})
        for column, (curve, by_offset) in of_load.items():
            stiffer = -load * curve.deriv()(load) * 0.2 / bands.changes["modulus"][modulus]
            for key, slope in ((modulus, stiffer), (offset, by_offset)):
                entries.append({"row": i, "column": column, "parameter": key, "derivative": slope})
    ends = bands.ends(rows, entries, tuple(of_load))
    zeta = np.random.default_rng(7).standard_normal((2, 400_000))
    for column, (curve, by_offset) in of_load.items():
        drawn = curve(50.0 * np.exp(0.2 * zeta[0])) + by_offset * 2.0 * zeta[1]
        expected = np.quantile(drawn, (0.5 - LEVEL / 2, 0.5 + LEVEL / 2))
        found = [ends[end] for end in of_band(column)]
        print(column, found, expected)
        assert found == pytest.approx(expected, abs=0.01 * np.ptp(expected))
    assert ends["high_tip_z_mm"] - 0.5 < 0.7 * (0.5 - ends["low_tip_z_mm"])  # its maximum is 0.5


def test_an_instruments_noise_comes_beside() -> None:
    """√(σ² + noise²), and what nothing feels is not told."""
    config = _config()
    plain = run("bending", config, bands={**NONE, "pressure_offset_kPa": 2.0})
    noisy = run("bending", config, bands={**NONE, "pressure_offset_kPa": 2.0, "tip_x_mm": 0.5})
    size = [one.column("high_tip_x_mm") - one.column("tip_x_mm") for one in (plain, noisy)]
    assert size[1] == pytest.approx(np.hypot(size[0], WIDTH * 0.5))
    assert plain.column("low_angle_deg")[0] == 0
    assert "coupon_area" not in Bands.of(find("bending"), config, {}).spreads


@pytest.mark.parametrize(
    ("told", "said"),
    [
        ({"stiffness": 0.1}, "--uncertain stiffness: nothing of this run; allowed: modulus, wall"),
        ({"wall": -0.1}, "--uncertain wall = -0.1: allowed: a number from 0 on"),
        ({"cast.wall_mm": 0.1}, "--uncertain cast.wall_mm: nothing of this run"),
    ],
)
def test_what_is_not_of_the_run_is_refused(told: dict[str, float], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        Bands.of(find("bending"), _config(), told)


def test_a_file_that_tells_no_standard_deviation_is_refused(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """A key outside of its table, which would be taken and do nothing."""
    file = tmp_path / "spread.toml"
    file.write_text("modulus = 0.15\n", encoding="utf-8")
    assert run_command("bend", "--bands", "--uncertain", file, "--out", tmp_path / "out") == 2
    assert (
        f"--uncertain {file}: no standard deviation; allowed: [nuisance]" in capfd.readouterr().err
    )
