"""Predictions from fits: curves, quantiles, and the command on a coarse block."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from support import posteriors
from support.example import EXAMPLES
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError, changed
from dolfingrip.experiments.prediction import PressureCurve, further, predict
from dolfingrip.sections import posterior
from dolfingrip.sections.posterior import PosteriorTable, WeightedFit
from dolfingrip.sections.tables import assignments

STRAIGHT = PressureCurve(np.array([0.0, 10.0, 20.0]), np.array([0.0, 10.0, 20.0]))


def test_a_falling_pressure_is_a_jump() -> None:
    """Readings at 0, 10, 8 and 12 kPa: from 10 kPa on the angle is that beyond the fall."""
    curve = PressureCurve.of(np.array([0.0, 10.0, 8.0, 12.0]), np.array([0.0, 10.0, 40.0, 60.0]))
    assert (np.diff(curve.pressure_kPa) >= 0).all()
    # the pressure is 10 kPa again half-way from 8 to 12 kPa, at 50°
    np.testing.assert_allclose(curve.at(np.array([5.0, 9.9, 10.1])), [5, 9.9, 50.5], rtol=2e-3)
    assert curve.ballooning_kPa == pytest.approx(10.0, rel=0.02)
    # from 10.8 kPa, at 54°, to the end it rises by 5° each kPa
    np.testing.assert_allclose(curve.at(np.array([14.0])), [70.0], rtol=1e-3)


def test_quantiles_are_those_of_the_deviations() -> None:
    """A straight curve passes normal deviations on: 1.645 standard deviations to either side.

    4,000 samples tell a 5 % quantile within 4 % of the deviation.
    """
    left = PosteriorTable(
        model_kPa=0.3, specimen=0.04, angle=0.05, reading_deg=0.5, fit=(WeightedFit(),)
    )
    found = predict([STRAIGHT], left, np.array([10.0]))
    spread = np.sqrt(0.3**2 + 0.4**2 + 0.5**2 + 0.5**2)
    expected = 10 + 1.645 * spread * np.array([-1, 0, 1])
    np.testing.assert_allclose(found.angle_deg[:, 0], expected, atol=0.1 * spread)


def test_fits_count_by_their_weight() -> None:
    """Two fits without any deviation: the median is the more probable one's."""
    steep = PressureCurve(np.array([0.0, 20.0]), np.array([0.0, 60.0]))
    left = PosteriorTable(fit=(WeightedFit(weight=1.0), WeightedFit(weight=9.0)))
    found = predict([STRAIGHT, steep], left, np.array([10.0]))
    np.testing.assert_allclose(found.angle_deg[:, 0], [10, 30, 30])


def test_the_factor_goes_on_as_it_rose() -> None:
    """Between rows it is straight, before the first it is the first's; a fall is not gone on."""
    rising = WeightedFit(growth=(2.0, 4.0, 6.0), factor=(1.0, 1.1, 1.3))
    np.testing.assert_allclose(rising.correction(np.array([1.0, 5.0, 8.0])), [1.0, 1.2, 1.5])
    falling = WeightedFit(growth=(2.0, 4.0), factor=(1.2, 1.1))
    np.testing.assert_allclose(falling.correction(np.array([8.0])), [1.1])


def test_a_path_is_gone_on_straight() -> None:
    """By one and a half times its growth, from 1 to 5: to 11, with the slopes of its end."""
    growth = np.linspace(1.0, 5.0, 41)
    far, pressure, angle = further(growth, 10 * growth, growth**2)
    assert far[-1] == pytest.approx(11.0)
    assert pressure[-1] == pytest.approx(110.0)
    assert angle[-1] == pytest.approx(25 + 6 * (4.6 + 5), rel=1e-9)


def test_the_table_is_read_back_and_is_no_section(tmp_path: Path) -> None:
    """Other commands take the same file, without the table."""
    left = PosteriorTable(model_kPa=0.5, fit=(WeightedFit(set={"film.silk.Et_N_per_mm": 3.0}),))
    file = tmp_path / "extended.toml"
    file.write_text(posteriors.appended("[finger]\nlength_mm = 80.0\n", left), encoding="utf-8")
    assert posterior.read(file) == left
    assert config.load(file).finger.length_mm == 80.0
    file.write_text("[posterior]\nmodel_kPa = -1.0\nfit = [{}]\n", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"model_kPa = -1.0: allowed: at least 0 and at most"):
        posterior.read(file)


def test_the_example_is_read() -> None:
    """Four members of two laws, which the configuration takes."""
    file = EXAMPLES / "ecoflex_actuators" / "extended.toml"
    left = posterior.read(file)
    assert left.shares.sum() == pytest.approx(1.0)
    base = config.load(file)
    laws = {
        changed(base, assignments([f"{k}={json.dumps(v)}" for k, v in each.set.items()])).material
        for each in left.fit
    }
    assert (len(left.fit), len(laws)) == (4, 2)


def test_command(tmp_path: Path) -> None:
    """Two stiffnesses of a short block: half the modulus bends as at twice the pressure.

    A second call finds both simulations.
    """
    block = (
        '[finger]\nkind = "cast"\n[cast]\nchambers = 1\n[contact]\nself_contact = false\n'
        "[mesh]\nsize_mm = 7.0\nedge_size_mm = 2.0\n[material]\nmu_MPa = 0.04\n"
        '[film.silk]\nmodel = "layer"\nregion = "film"\nEt_N_per_mm = 50.0\n'
        "[experiment]\nstep_kPa = 2.0\n"
    )
    soft = {"material.mu_MPa": 0.02, "film.silk.Et_N_per_mm": 25.0}
    file = tmp_path / "extended.toml"
    left = PosteriorTable(fit=(WeightedFit(), WeightedFit(set=soft)))
    file.write_text(posteriors.appended(block, left), encoding="utf-8")
    call = ["predict", "--from", str(file), "--out", str(tmp_path / "out"), "--pressures", "3,6"]
    for _ in range(2):
        result = CliRunner().invoke(app, call)
        assert result.exit_code == 0, result.output
    table = np.genfromtxt(tmp_path / "out" / "prediction.csv", delimiter=",", names=True)
    assert table["high_deg"][0] == pytest.approx(table["low_deg"][1], rel=0.02)
    assert "# ballooning pressure" in (tmp_path / "out" / "prediction.csv").read_text()
    again = tmp_path / "out" / "fit-1" / "run.json"
    assert again.stat().st_mtime_ns < (tmp_path / "out" / "prediction.csv").stat().st_mtime_ns
