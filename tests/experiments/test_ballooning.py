"""The forecast of ballooning against a balloon's closed form and a solved finger."""

from __future__ import annotations

import numpy as np
import pytest
from support.example import EXAMPLES

from dolfingrip import config
from dolfingrip.experiments import ballooning
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.material_fit.law import LAWS, balloon, limit_points
from dolfingrip.sections.tables import assignments


def test_a_balloon_of_neo_hooke_is_greatest_at_the_sixth_root_of_seven() -> None:
    """p = 2 μ t/r (1/λ − 1/λ⁷) has its maximum at λ⁶ = 7."""
    stretch = 7 ** (1 / 6)
    expected = 2.93 * (1 / stretch - stretch**-7)
    found = ballooning.most(config.Config().material)
    assert found == pytest.approx(expected, rel=1e-4)


def test_the_greatest_pressure_is_that_of_the_fit() -> None:
    """Coupons' page finds the limit points of the same balloon."""
    values = {"C10_MPa": 0.3, "C01_MPa": 0.01}
    law = LAWS["mooney-rivlin"]
    at, greatest = limit_points(law, list(values.values()), 5.0)[0]
    assert greatest
    (pressure,) = balloon(law, np.array([at]), list(values.values()))
    change = {"material.law": "polynomial", **{f"material.{k}": v for k, v in values.items()}}
    assert ballooning.most(config.load(None, change).material) == pytest.approx(pressure, rel=1e-4)


def test_chains_that_end_soon_have_no_maximum() -> None:
    change = {"material.law": "gent", "material.gent_mu_MPa": 0.1, "material.gent_limit": 1.5}
    assert ballooning.most(config.load(None, change).material) is None


def test_the_thin_bellows_balloon_near_their_forecast() -> None:
    """Solved, their greatest pressure is about 174 kPa (examples/thin_bellows.toml)."""
    found = ballooning.forecast(config.load(EXAMPLES / "thin_bellows.toml"))
    assert found is not None
    assert found.wall_mm == 0.5
    assert found.pressure_kPa == pytest.approx(174, rel=0.15)


def test_a_film_that_hardly_stretches_does_not_balloon() -> None:
    """Measured actuators of this block balloon at 35 kPa, and its model has a limit point at 29."""
    changes = ("film.silk.Et_N_per_mm=1e-6",)
    file = EXAMPLES / "ecoflex_actuators" / "coupon_alone.toml"
    found = ballooning.forecast(config.load(file))
    alone = ballooning.forecast(config.load(file, assignments(changes)))
    assert found is not None
    assert alone is not None
    assert (found.wall_mm, alone.wall_mm) == pytest.approx((7.0, 0.5), rel=1e-3)
    assert 29 / 2 < found.pressure_kPa < 29 * 2


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ([], False),
        (["finger.kind=pneunet"], False),
        (["finger.kind=round_bellows", "material.mu_MPa=0.01"], False),
        (["finger.kind=pneunet", 'material.name="Ecoflex 00-50"'], True),
        (["material.mu_MPa=0.5"], True),
        (["material.mu_MPa=0.5", "experiment.max_pressure_kPa=50"], False),
        (["material.mu_MPa=0.5", "experiment.control=volume"], False),
    ],
)  # fmt: skip
def test_a_run_is_told_of_walls_that_balloon(changes: list[str], *, told: bool) -> None:
    found = [each for each in Bending().notes(config.load(None, assignments(changes))) if
             "balloon near" in each]  # fmt: skip
    assert bool(found) == told
    assert all("experiment.control=auto" in each for each in found)
