"""A body that is stiffer in places: mean moduli of a box in closed form, and what is said of it.

The mean of exp(a cos πs) over 0 ≤ s ≤ 1 is the modified Bessel function I₀(a) (Abramowitz & Stegun,
9.6.16), and that of exp(b (1 − 2h)) over 0 ≤ h ≤ 1 is sinh(b)/b.
"""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from scipy.special import i0

from dolfingrip.config import Config
from dolfingrip.extensions.site import Site
from dolfingrip.extensions.uneven_stiffness import UnevenStiffness
from dolfingrip.extensions.yeoh import Yeoh
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.state import History

NONE = {"a_1": 0.0, "a_2": 0.0, "b_0": 0.0, "b_1": 0.0, "b_2": 0.0}


@pytest.fixture(scope="module")
def site() -> Site:
    """A box that is not at the origin."""
    ends = [np.array([2.0, 0.0, -5.0]), np.array([6.0, 1.0, 25.0])]
    box = mesh.create_box(MPI.COMM_SELF, ends, [6, 1, 16], mesh.CellType.hexahedron)
    u = fem.Function(fem.functionspace(box, ("P", 1, (3,))))
    one = fem.Constant(box, 1.0)
    return Site(Config(), Domain(box, {}, half=False), u, one, one, History(u, 4))


@pytest.mark.parametrize(
    ("modes", "mean"),
    [
        ({"a_1": 0.8}, i0(0.8)),
        ({"a_2": -0.6}, i0(0.6)),
        ({"b_0": 0.7}, np.sinh(0.7) / 0.7),
        ({}, 1.0),
    ],
    ids=["towards the clamp", "in the middle", "at the base", "nowhere"],
)
def test_mean_moduli(site: Site, modes: dict[str, float], mean: float) -> None:
    """By eight points in each direction of a cell, which leave 1e-7."""
    moduli = UnevenStiffness(**{**NONE, **modes}).moduli(site)
    dx = ufl.dx(metadata={"quadrature_degree": 8})
    total = fem.assemble_scalar(fem.form(moduli * dx(site.domain.mesh)))
    assert total / (4 * 1 * 30) == pytest.approx(mean, rel=1e-6)


def test_it_says_where() -> None:
    """Of a finger of 90 mm; half of the largest change tells a place's ends, to a millimetre."""
    towards_tip = UnevenStiffness(**{**NONE, "a_1": -0.3, "a_2": 0.1})
    # 0.1 cos 2πs − 0.3 cos πs is half of 0.4 where cos πs = (3 − √33)/4
    begins = 90 * np.arccos((3 - np.sqrt(33)) / 4) / np.pi
    assert towards_tip.words(Config()) == (
        f"the finger is stiffer somewhere between {np.ceil(begins):.0f} and 90 mm from the clamp, "
        "by up to 49 %"
    )
    at_base = UnevenStiffness(**{**NONE, "b_1": 0.3, "b_0": 0.1})
    assert "side of the base is stiffer somewhere between 0 and" in at_base.words(Config())
    softer = UnevenStiffness(**{**NONE, "a_1": -0.3, "a_2": -0.1})
    assert softer.words(Config()).startswith("the finger is softer somewhere between 0 and")
    assert "in some places" in UnevenStiffness(**NONE).words(Config())


def test_words_follow_the_sign() -> None:
    assert Yeoh(C20_MPa=-0.164).words(Config()) == "softening at large strain"
    assert Yeoh(C20_MPa=0.1).words(Config()) == "stiffening at large strain"
