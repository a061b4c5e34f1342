"""Coupons in closed form against the finite-element bar, which solves the same energies."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.config import Config, load
from dolfingrip.experiments import run
from dolfingrip.experiments.rigs.uniaxial import Stretching, UniaxialTension
from dolfingrip.sections.tables import assignments

WAY = ["experiment.unload=true", "coupon.step_strain=0.1", "coupon.max_strain=0.4"]
EFFECTS = [
    ["mooney_rivlin.C01_MPa=1.2", "prony.g=[0.2]", "prony.tau_s=[8.0]"],
    ["mullins.inverse_r=0.4", "temperature_drift.warming_degC=4.0", "yeoh.C20_MPa=0.05"],
]
YIELDS = ["permanent_set.g=0.2"]


def configured(effects: list[str]) -> Config:
    return load(None, assignments([*WAY, *(f"extensions.{each}" for each in effects)]))


@pytest.mark.parametrize("effects", EFFECTS, ids=lambda each: each[0].partition(".")[0])
def test_the_finite_element_bar_agrees(effects: list[str]) -> None:
    """Up and down: force and width as those of one linear element, which is exact here."""
    config = configured(effects)
    curve = run("coupon", config)
    strain = curve.column("displacement_mm") / config.coupon.gauge_length_mm
    way = Stretching(list(strain), list(curve.column("time_s")), config.coupon.step_strain)
    (told,) = UniaxialTension(config).follow({}, [way])
    force_N = told.stress_MPa[0] * config.coupon.area_mm2
    assert force_N == pytest.approx(curve.column("force_N"), rel=1e-7, abs=1e-6)
    assert told.across[0] - 1 == pytest.approx(curve.column("transverse_strain"), abs=1e-8)


def test_yielding_agrees_with_the_bar_to_its_load_steps() -> None:
    """Both end each step by backward Euler; they differ less the finer the steps are."""
    errors = []
    for step in (0.1, 0.05):
        config = load(
            None, assignments([*WAY, f"coupon.step_strain={step}", f"extensions.{YIELDS[0]}"])
        )
        curve = run("coupon", config)
        strain = curve.column("displacement_mm") / config.coupon.gauge_length_mm
        way = Stretching(list(strain), list(curve.column("time_s")), step)
        (told,) = UniaxialTension(config).follow({}, [way])
        force_N = told.stress_MPa[0] * config.coupon.area_mm2
        errors.append(np.abs(force_N - curve.column("force_N")).max())
    assert errors[0] < 0.02  # N of 28, a third of a load cell's usual noise
    assert errors[1] < 0.7 * errors[0]


def test_bars_have_parameters_of_their_own() -> None:
    """Several at once are each as one alone."""
    config = configured(["mooney_rivlin.C01_MPa=1.0", "prony.g=[0.2]"])
    values = np.array([0.3, 1.0, 1.6])
    way = Stretching([0.1, 0.2, 0.3], [1.0, 2.0, 3.0], 0.1)
    key = "extensions.mooney_rivlin.C01_MPa"
    both = {key: values, "extensions.prony.g": np.array([[0.1], [0.2], [0.3]])}
    together = UniaxialTension(config).follow(both, [way])[0].stress_MPa
    for i in range(3):
        one = {name: each[i : i + 1] for name, each in both.items()}
        alone = UniaxialTension(config).follow(one, [way])[0].stress_MPa
        assert together[i] == pytest.approx(alone[0], rel=1e-9)
    assert (np.diff(together[:, -1]) != 0).all()


@pytest.mark.slow
def test_a_bar_beyond_its_limit_point_is_lost_whatever_the_rounding() -> None:
    """A compressible Mooney–Rivlin bar that is pulled far thins until ∂²ψ/∂λ_t² vanishes.

    The next root of ∂ψ/∂λ_t is of another branch, with J near 0.1. Steps of a tenth tell the same
    stress before, and the same stop at which the bar is lost.
    """
    config = configured(["mooney_rivlin.C01_MPa=1.0"])
    stops = list(np.arange(0.5, 9.1, 0.5))
    values = np.array([0.6, 0.9, 1.2, 1.36, 1.46, 1.6, 2.0])

    def stress(values: np.ndarray, step: float) -> np.ndarray:
        bars = {"extensions.mooney_rivlin.C01_MPa": values}
        (told,) = UniaxialTension(config).follow(bars, [Stretching(stops, stops, step)])
        return told.stress_MPa

    fine = stress(values, 0.005)
    lost = np.isnan(fine)
    assert lost[:, -1].all()
    assert not lost[:, 0].any()
    assert (np.diff(lost.astype(int), axis=1) >= 0).all()
    for step in (0.05, 0.01):
        for other in (stress(values, step), stress(values * (1 + 1e-13), step)):
            np.testing.assert_array_equal(np.isnan(other), lost)
            np.testing.assert_allclose(other[~lost], fine[~lost], rtol=1e-6, atol=1e-6)


def test_a_raster_that_is_turned_is_refused() -> None:
    """Such a bar shears, so two stretches do not describe it."""
    with pytest.raises(ValueError, match="raster_deg"):
        UniaxialTension(
            configured(["print_anisotropy.k_MPa=0.2", "print_anisotropy.raster_deg=5.0"])
        )
