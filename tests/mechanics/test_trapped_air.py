"""Air trapped in a closed cavity: the gas law at the volume reached, derivatives, columns."""

from __future__ import annotations

import numpy as np
import pytest
from mpi4py import MPI
from support import hollow_box, taylor
from support.paths import by_pressure

from dolfingrip import config as configuration
from dolfingrip.config import ConfigError
from dolfingrip.experiments.rigs.finger import Additions, FingerModel, build
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.extensions.site import Site
from dolfingrip.forms import cavity_pressure
from dolfingrip.mechanics.model.domain import distribute
from dolfingrip.mechanics.model.model import Control
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.readings.integrals import Integral

AMBIENT_KPA = 101.325
SEED = 11


def pushed(exponent: float = 1.0, closed_at_kPa: float = AMBIENT_KPA) -> FingerModel:
    """Half of a box with a closed hollow, in air of a higher pressure around it."""
    config = configuration.from_dict(
        {
            "material": {"mu_MPa": 0.05},
            "contact": {"self_contact": False},
            "solver": {"rtol": 1e-11},
            "cavity": {
                "cavity": {
                    "closed": True, "exponent": exponent, "closed_at_kPa": closed_at_kPa,
                }
            },
        }
    )  # fmt: skip

    def adds(site: Site) -> Additions:
        load = site.fixed(0.0)
        outside = site.domain.surface("skin", "tip", quadrature_degree=4)
        pressing = cavity_pressure.energy(site.u, site.domain.mesh, load) * outside
        return Additions(loads=[pressing], controls={"load_MPa": Control(load)})

    return build(config, distribute(MPI.COMM_SELF, hollow_box.mesh()), plate=False, adds=adds)


@pytest.mark.parametrize("exponent", [1.0, 1.4])
def test_pushed_to_nine_tenths_of_its_volume(exponent: float) -> None:
    """p = p₀ (V₀/V)ⁿ − pₐ: 11.258 kPa in 0.9 of the volume at constant temperature."""
    finger = pushed(exponent)
    path = LoadPath(Newton(finger.model, finger.config.solver), {"load_MPa": 0.005})
    volume = Integral(finger.model, "volume_mm3", finger.volume_of("cavity"))
    start = volume.value()
    assert start == pytest.approx(2 * hollow_box.CAVITY_MM3)
    ratio, load = 1.0, 0.0
    while ratio > 0.9:
        load += 0.005
        assert path.advance({"load_MPa": load}).failure is None
        ratio = volume.value() / start
        expected = AMBIENT_KPA * (ratio**-exponent - 1)
        found = finger.pressure_in("cavity").value
        print(load, ratio, found, expected)
        assert found == pytest.approx(expected, rel=1e-6)
    assert found > 11


def test_derivatives_of_trapped_air() -> None:
    """Taylor remainders of Π and its gradient, by displacement and pressure of the air."""
    print("seed", SEED)
    model = pushed(1.4, 120.0).model
    rng = np.random.default_rng(SEED)
    start = model.unknowns.owned()
    way = rng.uniform(-1, 1, start.shape) * model.free
    start = start + 0.05 * way

    def at(step: float, gradient: bool = False) -> np.ndarray | float:
        model.unknowns.set_owned(start + step * way)
        return model.gradient() if gradient else model.energy()

    slope = float(np.asarray(at(0.0, gradient=True)) @ way)
    assert taylor.rates(at, slope, 1e-2).min() > 1.9


def test_air_that_was_closed_under_pressure_blows_it_up() -> None:
    """At rest the air has expanded, and readings count from there."""
    finger = pushed(closed_at_kPa=105.0)
    path = by_pressure(Newton(finger.model, finger.config.solver))
    assert path.advance({"pressure_kPa": 0.0}).failure is None
    volume = Integral(finger.model, "volume_mm3", finger.volume_of("cavity"))
    ratio = volume.value() / (2 * hollow_box.CAVITY_MM3)
    assert 1.001 < ratio < 1.04
    found = finger.pressure_in("cavity").value
    assert found == pytest.approx(105.0 / ratio - AMBIENT_KPA, rel=1e-6)
    read = Observation(finger).readings
    assert read["cavity_pressure_kPa"].value() == found  # the regulator's is 0
    assert read["pressure_kPa"].value() == 0


def test_a_closed_cavity_has_no_ratio() -> None:
    with pytest.raises(ConfigError, match=r"cavity.cavity.pressure_ratio = 0.5: allowed: not "):
        configuration.from_dict({"cavity": {"cavity": {"closed": True, "pressure_ratio": 0.5}}})
