"""Strain energies in uniaxial tension, against the incompressible closed forms.

P = 2 (λ − λ⁻²) (∂ψ/∂I₁ + ∂ψ/∂I₂ / λ) (Holzapfel, Nonlinear Solid Mechanics, 2000, section 6.5).
"""

from __future__ import annotations

import numpy as np
import pytest
from extensions import bars

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
