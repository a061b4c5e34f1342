"""Strain energies in uniaxial tension, against the incompressible closed forms.

P = 2 (λ − λ⁻²) (∂ψ/∂I₁ + ∂ψ/∂I₂ / λ) (Holzapfel, Nonlinear Solid Mechanics, 2000, section 6.5).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from support import bars

from dolfingrip import config
from dolfingrip.sections.tables import assignments

MU = 2.93
PULL = (*bars.INCOMPRESSIBLE, "coupon.max_strain=1.0", "coupon.step_strain=0.25")

NINJAFLEX = np.array(
    [[2, 0.389], [5, 0.859], [10, 1.544], [20, 2.642], [30, 3.480], [50, 4.607], [100, 5.987]]
)
"""Strain (%) and nominal stress (MPa): the mean of eight printed coupons."""


def shape(stretch: np.ndarray) -> np.ndarray:
    return 2 * (stretch - stretch**-2)


def test_neo_hooke() -> None:
    stretch, found = bars.stress(bars.pull(*PULL))
    np.testing.assert_allclose(found, shape(stretch) * MU / 2, rtol=1e-4)


def test_mooney_rivlin() -> None:
    c01 = 0.9
    stretch, found = bars.stress(bars.pull(*PULL, f"extensions.mooney_rivlin.C01_MPa={c01}"))
    expected = shape(stretch) * (MU / 2 - c01 + c01 / stretch)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


def test_yeoh() -> None:
    c20, c30 = -0.1, 0.05
    stretch, found = bars.stress(
        bars.pull(*PULL, f"extensions.yeoh.C20_MPa={c20}", f"extensions.yeoh.C30_MPa={c30}")
    )
    first = stretch**2 + 2 / stretch - 3
    expected = shape(stretch) * (MU / 2 + 2 * c20 * first + 3 * c30 * first**2)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("limit", [4.0, 1e4])
def test_gent(limit: float) -> None:
    """∂ψ/∂I₁ = μ/2 Jₘ/(Jₘ − I₁ + 3)."""
    stretch, found = bars.stress(bars.pull(*PULL, f"extensions.gent.inverse_J_m={1 / limit}"))
    first = stretch**2 + 2 / stretch - 3
    expected = shape(stretch) * MU / 2 * limit / (limit - first)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


@pytest.mark.parametrize("alpha", [0.5, 1.3, 2.5])
def test_ogden(alpha: float) -> None:
    """P = 2μ/α (λ^(α−1) − λ^(−α/2−1)), at stretches to 1.5."""
    half = (*PULL, "coupon.max_strain=0.5")
    stretch, found = bars.stress(bars.pull(*half, f"extensions.ogden.alpha={alpha}"))
    expected = 2 * MU / alpha * (stretch ** (alpha - 1) - stretch ** (-alpha / 2 - 1))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


def test_bulk_modulus() -> None:
    """Young's modulus at small strain: 9Kμ/(3K + μ)."""
    strain, more = 1e-5, 10.0
    bulk = config.Config().material.lmbda_MPa + 2 * MU / 3 + more
    result = bars.pull(
        *bars.protocol([0.0], [33 * strain]), f"extensions.bulk_modulus.more_MPa={more}"
    )
    young = result.column("nominal_stress_MPa")[-1] / strain
    assert young == pytest.approx(9 * bulk * MU / (3 * bulk + MU), rel=1e-4)


@pytest.mark.parametrize("angle_deg", [0.0, 45.0, 90.0])
@pytest.mark.parametrize("k", [1.2, -0.5])
def test_print_anisotropy_at_small_strain(k: float, angle_deg: float) -> None:
    """1/E from the inverse of the linear stiffness, 2μ I + λ 1⊗1 + 4k D⊗D, D = a⊗a − 1/3.

    In Mandel's notation; the bar is free to shear (Jones, Mechanics of Composite Materials, 1999,
    section 2.6).
    """
    angle = np.radians(angle_deg)
    axis = np.array([np.sin(angle), 0, np.cos(angle)])
    deviator = mandel(np.outer(axis, axis) - np.eye(3) / 3)
    unit = mandel(np.eye(3))
    stiffness = 2 * MU * np.eye(6) + config.Config().material.lmbda_MPa * np.outer(unit, unit)
    stiffness += 4 * k * np.outer(deviator, deviator)
    young = 1 / np.linalg.inv(stiffness)[2, 2]
    strain = 1e-5
    result = bars.pull(
        *bars.protocol([0.0], [33 * strain]),
        f"extensions.print_anisotropy.k_MPa={k}",
        f"extensions.print_anisotropy.raster_deg={angle_deg}",
    )
    assert result.column("nominal_stress_MPa")[-1] / strain == pytest.approx(young, rel=1e-4)


def mandel(tensor: np.ndarray) -> np.ndarray:
    """Components (6,) whose dot product is the tensors' inner product."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = tensor
    return np.array([xx, yy, zz, *(np.sqrt(2) * np.array([yz, xz, xy]))])


def test_print_anisotropy_at_large_strain() -> None:
    """Pulled along the axis, Ī₄ = λ²: P = (λ − λ⁻²) μ + dψ/dλ with ψ = k/2 (λ² − 1)²."""
    k = 0.4
    stretch, found = bars.stress(bars.pull(*PULL, f"extensions.print_anisotropy.k_MPa={k}"))
    expected = shape(stretch) * MU / 2 + 2 * k * stretch * (stretch**2 - 1)
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


def test_printed_ninjaflex_gives_the_prior_of_mooney_rivlin() -> None:
    """Least relative squares over the seven stresses; then the coupon follows them to 10 %."""
    stretch, stress = 1 + NINJAFLEX[:, 0] / 100, NINJAFLEX[:, 1]
    basis = shape(stretch)[:, None] * np.stack([np.ones_like(stretch), 1 / stretch], axis=1)
    c10, c01 = np.linalg.lstsq(basis / stress[:, None], np.ones(7))[0]
    mu = 2 * (c10 + c01)
    assert 2 * c01 / mu == pytest.approx(0.93, abs=0.01)
    travel = 33 * (stretch - 1)
    result = bars.pull(
        *bars.INCOMPRESSIBLE,
        f"material.mu_MPa={mu}",
        f"extensions.mooney_rivlin.C01_MPa={c01}",
        *bars.protocol(np.arange(7), travel),
    )
    np.testing.assert_allclose(result.column("nominal_stress_MPa"), stress, rtol=0.1)


def test_clamped_grips_stiffen() -> None:
    """Ends that cannot narrow: stiffer than the uniform bar, by less than their share of it."""
    short = ("coupon.gauge_length_mm=12", "coupon.max_strain=0.1", "coupon.step_strain=0.1")
    free, held = (
        bars.stress(bars.pull(*short, f"coupon.grip={grip}"))[1][-1]
        for grip in ("sliding", "clamped")
    )
    assert 1.01 * free < held < 1.2 * free


@pytest.mark.parametrize("poisson", [0.3, 0.45])
@pytest.mark.parametrize("more_MPa", [0.0, 20.0])
def test_a_bar_narrows_until_its_sides_bear_no_stress(poisson: float, more_MPa: float) -> None:
    """μ (a − 1) + Λ ln(λ a) + ΔK ln(λ a) = 0 with a = (1 + transverse strain)²: compressible
    neo-Hooke, ψ = μ/2 (I₁ − 3 − 2 ln J) + Λ/2 (ln J)² + ΔK/2 (ln J)²."""
    effect = (f"extensions.bulk_modulus.more_MPa={more_MPa}",) if more_MPa else ()
    settings = (f"material.nu={poisson}", "solver.atol_N=1e-7", *effect)
    result = bars.pull("coupon.max_strain=0.5", "coupon.step_strain=0.1", *settings)
    lame = config.load(None, assignments(settings)).material.lmbda_MPa + more_MPa
    expected = [
        np.sqrt(brentq(lambda a, at=at: MU * (a - 1) + lame * np.log(at * a), 0.2, 1.5)) - 1
        for at in 1 + result.column("nominal_strain")
    ]
    found = result.column("transverse_strain")
    np.testing.assert_allclose(found, expected, atol=1e-8)
    assert found[-1] < -0.1


def test_a_clamped_bar_is_read_where_it_is_free_to_narrow() -> None:
    """At half its length, where it is stretched a little further than on the whole."""
    short = ("coupon.gauge_length_mm=12", "coupon.max_strain=0.1", "coupon.step_strain=0.1")
    free, held = (
        bars.pull(*short, f"coupon.grip={grip}").column("transverse_strain")[-1]
        for grip in ("sliding", "clamped")
    )
    assert 1.0 < held / free < 1.15
