"""The terms of a base material, added as an extension to next to nothing, are that material."""

from __future__ import annotations

import numpy as np
import pytest
from support import bars

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.sections.tables import assignments

PULL = ("coupon.max_strain=1.0", "coupon.step_strain=0.5", "solver.atol_N=1e-7")
LITTLE = 1e-6


@pytest.mark.parametrize(
    ("law", "effect"),
    [
        (
            ("material.law=ogden", "material.ogden_mu_MPa=[1.2, 0.4]",
             "material.ogden_alpha=[1.3, -2.5]"),
            ("extensions.ogden_terms.mu_MPa=[1.2, 0.4]",
             "extensions.ogden_terms.alpha=[1.3, -2.5]"),
        ),
        (
            ("material.law=polynomial", "material.C10_MPa=0.5", "material.C01_MPa=0.3",
             "material.C20_MPa=0.01"),
            ("extensions.polynomial.C10_MPa=0.5", "extensions.polynomial.C01_MPa=0.3",
             "extensions.polynomial.C20_MPa=0.01", "extensions.polynomial.C11_MPa=0"),
        ),
    ],
    ids=["ogden_terms", "polynomial"],
)  # fmt: skip
def test_an_effect_is_the_base_material(law: tuple[str, ...], effect: tuple[str, ...]) -> None:
    """Added to a neo-Hookean base of μ = 1e-6 MPa and equal λ; the difference is of that order."""
    bulk = "material.bulk_MPa=1000"
    _, alone = bars.stress(bars.pull(*PULL, *law, bulk))
    added = (f"material.mu_MPa={LITTLE}", bulk, *effect)
    _, found = bars.stress(bars.pull(*PULL, *added))
    np.testing.assert_allclose(found, alone, rtol=1e-5, atol=1e-9)


def test_unequal_lists_are_one_line() -> None:
    with pytest.raises(
        ConfigError, match=r"extensions\.ogden_terms\.alpha = \[-3\.0\]: allowed: as "
    ):
        config.load(None, assignments(["extensions.ogden_terms.mu_MPa=[1, 2]"]))
    with pytest.raises(ConfigError, match=r"allowed: each from 0\.05 to 10"):
        config.load(None, assignments(["extensions.ogden_terms.alpha=[0]"]))
