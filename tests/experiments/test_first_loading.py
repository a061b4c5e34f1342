"""First loading is found in the readings of coupons that no column tells it of.

Stresses are those of neo-Hooke's law, P = μ (λ − λ⁻²), with a softer way back; so the modulus is
known that is right.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.experiments.material_fit.first_loading import (
    first_loading,
    is_hollow,
    slack_strain,
)
from dolfingrip.experiments.material_fit.fit import MISFIT, fit
from dolfingrip.experiments.material_fit.law import LAWS

MU = 0.2
"""Shear modulus (MPa) of the first loading."""


def neo_hooke(stretch: np.ndarray) -> np.ndarray:
    return MU * (stretch - stretch**-2.0)


def loops(*tops: float, rest: float = 1.0, steps: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Stretches and stresses of loops: reloading is softer up to the farthest stretch before."""
    stretches, stresses, farthest = [], [], 0.0
    for top in tops:
        up = np.linspace(rest, top, steps)
        virgin = up > farthest
        stretches += [up, up[::-1]]
        stresses += [np.where(virgin, 1.0, 0.6) * neo_hooke(up), 0.5 * neo_hooke(up)[::-1]]
        farthest = max(farthest, top)
    return np.concatenate(stretches), np.concatenate(stresses)


def found_MPa(stretch: np.ndarray, stress: np.ndarray) -> float:
    keep = first_loading(stretch, stress)
    series = coupons.CouponSeries("", "uniaxial", stretch[keep], stress[keep], None)
    return float(fit(LAWS["neo-hooke"], [series]).values[0])


@pytest.mark.parametrize(
    "tops", [(2.5,), (2.0, 2.0, 2.0), (1.3, 1.8, 2.6), (1.05, 2.0), (2.4, 1.6, 2.4)]
)
@pytest.mark.parametrize("noise", [0.0, 0.002])
@pytest.mark.parametrize("rest", [1.0, 1.02])
def test_loops_have_one_first_loading(tops: tuple[float, ...], noise: float, rest: float) -> None:
    draw = np.random.default_rng(5)
    stretch, stress = loops(*tops, rest=rest)
    keep = first_loading(stretch, stress)
    virgin = np.isclose(stress, neo_hooke(stretch)) & (stretch > 1.06)
    if not noise:
        assert not (keep & ~virgin & (stretch > 1.06)).any()
        assert (keep & virgin).sum() >= virgin.sum() - len(tops)
    stretch = stretch + noise * draw.standard_normal(len(stretch))
    stress = stress + noise * MU * draw.standard_normal(len(stress))
    assert found_MPa(stretch, stress) == pytest.approx(MU, rel=0.002 + 5 * noise)


def test_what_follows_a_break_or_a_slip_is_left_out() -> None:
    stretch = np.linspace(1, 3, 81)
    for fallen, part in ((60, 0.01), (40, 0.6), (80, 0.0)):
        stress = neo_hooke(stretch)
        stress[fallen:] *= part
        keep = first_loading(stretch, stress)
        assert keep.sum() == fallen
        assert keep[:fallen].all()
        assert first_loading(stretch, stress, labelled=True).sum() == fallen


def test_one_reading_that_fails_ends_nothing() -> None:
    stretch = np.linspace(1, 3, 81)
    stress = neo_hooke(stretch)
    stress[40] = 0
    assert np.flatnonzero(~first_loading(stretch, stress)).tolist() == [40]


def test_a_table_of_both_sides_or_in_another_order_is_taken_whole() -> None:
    both = np.linspace(0.5, 2.2, 40)
    for stretch in (both, both[::-1], np.linspace(3, 1, 40), np.linspace(0.6, 1, 20)):
        assert first_loading(stretch, neo_hooke(stretch)).all()
    stretch = np.random.default_rng(2).permutation(np.linspace(1, 3, 60))
    assert first_loading(stretch, neo_hooke(stretch)).all()


def test_readings_of_one_step_of_the_gauge_stay() -> None:
    """A travel that is told in coarse steps stands still for some readings."""
    fine = np.linspace(1, 2, 200)
    stretch = np.round(fine, 2)
    assert first_loading(stretch, neo_hooke(fine)).sum() > 195


@pytest.mark.parametrize("far", [0.12, 0.3, 0.5])
def test_a_pressed_curve_is_hollow_and_a_pulled_one_is_not(far: float) -> None:
    way = np.linspace(0, far, 30)
    noise = 1e-3 * MU * np.random.default_rng(1).standard_normal(30)
    assert is_hollow(way, -neo_hooke(1 - way) + noise)
    assert not is_hollow(way, neo_hooke(1 + way) + noise)
    slack = np.maximum(way - 0.2 * far, 0)
    assert not is_hollow(way, neo_hooke(1 + slack) + noise)


def write(file: Path, stretch: np.ndarray, stress: np.ndarray, setup: str = "") -> Path:
    rows = "".join(f"{a:.5f},{b:.6f}\n" for a, b in zip(stretch, stress, strict=True))
    file.write_text(f"stretch,stress_MPa\n{rows}")
    if setup:
        file.with_suffix(".toml").write_text(setup)
    return file


def test_the_way_back_is_counted_and_not_fitted(tmp_path: Path) -> None:
    file = write(tmp_path / "loop.csv", *loops(2.5))
    ran = CliRunner().invoke(app, ["coupon", "--fit", str(file), "--law", "neo-hooke", "-o",
                                   str(tmp_path / "out")])  # fmt: skip
    assert ran.exit_code == 0, ran.output
    assert "60 readings; uniaxial: 1 specimen, to a stretch of 2.5; 60 further" in ran.output
    assert config.load(tmp_path / "out" / "material.toml").material.shear_MPa == pytest.approx(MU)


def test_a_law_that_misses_the_readings_is_not_written(tmp_path: Path) -> None:
    stretch = np.linspace(1, 3, 40)
    file = write(tmp_path / "odd.csv", stretch, (stretch - 1) ** 3)
    out = tmp_path / "out"
    ran = CliRunner().invoke(
        app, ["coupon", "--fit", str(file), "--law", "neo-hooke", "-o", str(out)]
    )
    assert isinstance(ran.exception, ConfigError)
    assert f"allowed: up to {100 * MISFIT:g} %" in str(ran.exception)
    assert (out / "fit.png").exists()
    assert not (out / "material.toml").exists()


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.filterwarnings("error::UserWarning")
def test_a_press_is_fitted_with_either_sign(sign: int, tmp_path: Path) -> None:
    way = np.linspace(0, 0.4, 40)
    table = (1 + sign * way, -sign * neo_hooke(1 - way))
    file = write(tmp_path / "press.csv", *table, 'mode = "compression"\n')
    ran = CliRunner().invoke(app, ["coupon", "--fit", str(file), "--law", "neo-hooke", "-o",
                                   str(tmp_path / "out")])  # fmt: skip
    assert ran.exit_code == 0, ran.output
    assert config.load(tmp_path / "out" / "material.toml").material.shear_MPa == pytest.approx(MU)
    assert "to a stretch of 0.6" in ran.output
    assert "up to a stretch of 1.29" in " ".join(ran.output.split())  # its width, 0.6**-0.5
    assert "rises from the start" not in ran.output


def test_a_fit_asks_whether_a_coupon_was_pressed(tmp_path: Path) -> None:
    way = np.linspace(0, 0.4, 40)
    file = write(tmp_path / "press.csv", 1 + way, -neo_hooke(1 - way))
    with pytest.raises(ConfigError, match='mode = "compression" or mode = "uniaxial" in press'):
        coupons.read(file)
    file.with_suffix(".toml").write_text('mode = "uniaxial"')
    assert len(coupons.read(file)[0].stretch) == 40


@pytest.mark.parametrize("far", [0.3, 1.5, 3.0])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_slack_is_told(far: float, noise: float) -> None:
    """With a tenth of the way slack, the strain at which a coupon is taut is read to a step."""
    way = np.linspace(0, far, 101)
    errors = noise * np.random.default_rng(3).standard_normal(101)
    for slack in (0.1, 0.3):
        stress = neo_hooke(1 + np.maximum(way - slack * far, 0))
        stress += errors * stress.max()
        assert slack_strain(1 + way, stress) == pytest.approx(slack * far, abs=0.03 * far)
    taut = neo_hooke(1 + way)
    assert slack_strain(1 + way, taut + errors * taut.max()) == 0


@pytest.mark.parametrize("soft", [0.2, 0.4])
@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_a_coupon_pulled_on_after_loops_is_taken_to_its_break(soft: float, noise: float) -> None:
    """Softened by its loops, it comes back to its first loading within a tenth of the strain."""
    draw = np.random.default_rng(7)
    up, pull = np.linspace(1, 1.5, 50), np.linspace(1, 4, 200)
    loop = np.concatenate([up, up[::-1]])
    softened = np.where(pull > 1.5, 1 - soft * np.exp(-(pull - 1.5) / 0.05), 1 - soft)
    stretch = np.concatenate([loop, *3 * [loop], pull, np.full(9, 4.0)])
    factors = [np.ones(50), np.linspace(1, 1 - soft, 50), *3 * [np.full(100, 1 - soft)], softened]
    stress = np.concatenate([*factors, np.full(9, 0.0)]) * neo_hooke(stretch)
    stretch += noise * draw.standard_normal(len(stretch))
    keep = first_loading(stretch, stress)
    assert 210 < keep.sum() < 225
    assert stretch[keep].max() > 3.9
    assert found_MPa(stretch, stress) == pytest.approx(MU, rel=0.02)


PRESS = "Weg [mm];Kraft [N]\n" + "".join(
    f"{12 * e:.4f};{-500 * MU * ((1 - e) - (1 - e) ** -2):.4f}\n" for e in np.linspace(0, 0.3, 12)
)


def test_an_import_asks_whether_a_coupon_was_pressed(tmp_path: Path) -> None:
    file = tmp_path / "press.csv"
    file.write_text(PRESS)
    sizes = [
        "import",
        str(file),
        "--gauge-length",
        "12",
        "--area",
        "500",
        "-o",
        str(tmp_path / "o"),
    ]
    ran = CliRunner().invoke(app, sizes)
    assert isinstance(ran.exception, ConfigError)
    assert "--mode compression or --mode uniaxial" in str(ran.exception)
    ran = CliRunner().invoke(app, [*sizes, "--mode", "compression"])
    assert ran.exit_code == 0, ran.output
    assert "mm × -1" in ran.output
    (series,) = coupons.read(tmp_path / "o" / "press.csv")
    assert series.stretch[-1] == pytest.approx(0.7)
    assert fit(LAWS["neo-hooke"], [series]).values[0] == pytest.approx(MU, rel=1e-3)
    assert CliRunner().invoke(app, [*sizes, "--mode", "uniaxial"]).exit_code == 0
