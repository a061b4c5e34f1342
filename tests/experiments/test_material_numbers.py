"""Numbers of a material that nobody gave, and stretches that its law is not known of, are said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support import compressible
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.experiments.material_fit.fit import fit, write
from dolfingrip.experiments.material_fit.law import LAWS, stress
from dolfingrip.experiments.results import doubts
from dolfingrip.sections import material

NAMED = sorted(material.named())


@pytest.mark.parametrize("name", NAMED)
def test_a_named_material_keeps_its_volume_as_its_fit_did(name: str) -> None:
    """Its nominal stress, the volume free to change, is that at constant volume to 1 %."""
    settings = config.load(None, {"material.name": name})
    own = settings.material
    assert own.nu == material.OF_RUBBER
    assert own.bulk_MPa is None
    assert doubts.not_given(settings) == []
    names = {f"material.{key}" for key in own.constants()}
    law = next(each for each in LAWS.values() if {*each.keys} == names)
    values = [own.constants()[key.rpartition(".")[2]] for key in law.keys]
    at = np.linspace(1.1, min(4.0, material.named()[name]["stretch"]), 5)
    bulk = own.lmbda_MPa + 2 / 3 * own.shear_MPa
    exact = stress(law, "uniaxial", at, values)
    assert compressible.stress(law, "uniaxial", at, values, bulk) == pytest.approx(exact, rel=0.012)


def test_a_bulk_modulus_or_another_ratio_may_be_told_beside_a_name() -> None:
    told = config.load(None, {"material.name": "Ecoflex 00-30", "material.bulk_MPa": 50.0})
    assert told.material.nu is None
    told = config.load(None, {"material.name": "Ecoflex 00-30", "material.nu": 0.45})
    assert told.material.nu == 0.45
    found = material.known_as(told.material)
    assert found is not None
    assert found[0] == "Ecoflex 00-30"
    assert material.known_as(material.DEFAULT) is None


def test_a_fit_is_written_with_the_ratio_that_it_was_made_with(tmp_path: Path) -> None:
    data = coupons.read(EXAMPLES / "coupons" / "ninjaflex_uniaxial.csv")
    write(fit(LAWS["ogden-1"], data), data, tmp_path / "material.toml")
    settings = config.load(tmp_path / "material.toml")
    assert settings.material.poisson == material.OF_RUBBER
    assert doubts.not_given(settings) == []
    assert '"P2-P1"' in (tmp_path / "material.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({}, ""),
        ({"material.mu_MPa": 0.3}, "nu = 0.45: not given"),
        ({"material.mu_MPa": 0.3, "material.nu": 0.4}, ""),
        ({"material.mu_MPa": 0.3, "material.bulk_MPa": 50.0}, ""),
        (
            {"material.mu_MPa": 0.3, "gravity.acceleration_m_s2": 9.81},
            "nu = 0.45 and density_kg_m3 = 1190: not given",
        ),
        ({"material.law": "gent", "material.gent_mu_MPa": 0.2, "material.gent_limit": 30.0},
         "nu = 0.45: not given"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("experiment", ["bending", "coupon"])
def test_a_run_says_which_numbers_of_its_material_were_not_given(
    change: dict[str, object], said: str, experiment: str
) -> None:
    notes = [
        each
        for each in EXPERIMENTS[experiment].notes(config.load(None, change))
        if each.startswith("material")
    ]
    assert [said in each for each in notes] == ([True] if said else [])


def test_a_coupon_says_where_it_leaves_what_its_law_is_known_of() -> None:
    name = {"material.name": "Dragon Skin 20", "coupon.max_strain": 1.0, "coupon.step_strain": 0.5}
    found = run("coupon", config.load(None, name), comm=MPI.COMM_SELF)
    assert EXPERIMENTS["coupon"].remarks(found) == []
    (said,) = doubts.of_law(found.config, 2.4)
    assert said == (
        "Dragon Skin 20: the largest stretch is 2.4; its law is known to 2 alone "
        "(data sheet of Smooth-On: 49 psi at 100 % strain)"
    )


def test_a_coupon_says_that_its_volume_grows() -> None:
    """ν = 0.3 of the polynomial: beyond J = e the volumetric energy softens."""
    change = {"material.law": "polynomial", "material.C10_MPa": 0.1, "material.nu": 0.3,
              "coupon.max_strain": 3.0, "coupon.step_strain": 1.0}  # fmt: skip
    found = run("coupon", config.load(None, change), comm=MPI.COMM_SELF)
    (said,) = EXPERIMENTS["coupon"].remarks(found)
    volume = 4.0 * (1 + found.column("transverse_strain")[-1]) ** 2
    assert said.startswith(f"at a stretch of 4 the volume is {volume:.2f} of that at rest")
    assert ("softens" in said) == (volume > np.e)
