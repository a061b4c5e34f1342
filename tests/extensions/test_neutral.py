"""At its neutral value an effect leaves the energy as it is, and can be told from nothing.

Energies are evaluated as numbers, at a generic strain and generic internal variables in the middle
of a history. The reference of each derivative is a central difference of the same energy: at a step
of 1e-5 its error is of the order of 1e-10, and its round-off 1e-11, of the energy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import ufl
from ufl.core.expr import Expr

from dolfingrip.extensions.effect import Effect, Energetic, Flow
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.extensions.set_point_logged import SetPointLogged
from dolfingrip.forms import neo_hookean
from dolfingrip.forms.evaluate import number

SEED = 29
MU, LMBDA = 2.93, 26.37
STEP = 1e-5
STRAIN = [[-0.15, 0.08, 0.05], [0.08, -0.1, -0.06], [0.05, -0.06, 0.3]]
"""Green–Lagrange: the shape changes by tens of per cent, the volume by some."""
ENERGIES = [effect for effect in EFFECTS if issubclass(effect, Energetic)]
PARAMETERS = [(effect, key) for effect in ENERGIES for key in effect.neutral]


class Place:
    """What a strain energy asks of a site, without a mesh: numbers in the middle of a load step.

    Args:
        **more: what is added to the parameters, by key.
    """

    mu, lmbda = MU, LMBDA
    step_s, time_s, cycle = 3.0, 600.0, 50.0

    def __init__(self, **more: float) -> None:
        self._more = more
        self._rng = np.random.default_rng(SEED)
        self.strain = ufl.as_matrix(STRAIN)
        self.history = self
        self.variables: dict[str, Expr] = {}

    def constant(self, effect: Effect, key: str) -> Expr:
        """A parameter, to which derivatives can be taken; of a list each entry is the same."""
        value = np.asarray(getattr(effect, key), dtype=float) + self._more.get(key, 0.0)
        entry = self.variables[key] = ufl.variable(ufl.as_ufl(float(value.flat[0])))
        return ufl.as_vector([entry] * value.size) if value.ndim else entry

    def remember(self, effect: Effect, name: str, initial: Any) -> Expr:
        """An internal variable: an energy beyond the present one, or a metric."""
        if np.ndim(initial) == 0:
            return ufl.as_ufl(2 * number(base(self.strain)))
        full = self._rng.uniform(-0.2, 0.2, (3, 3))
        return ufl.as_matrix((np.eye(3) + full + full.T).tolist())

    def evolve(self, variable: Expr, end: Expr) -> None:
        """Nothing: no step ends."""


def base(strain: Expr) -> Expr:
    """The energy without any effect."""
    return neo_hookean.energy(strain, MU, LMBDA)


def energy(effect: Effect, place: Place) -> Expr:
    """The energy with it."""
    return effect.strain_energy(base, place)(place.strain)  # type: ignore[arg-type]


@pytest.mark.parametrize("effect", ENERGIES, ids=[each.name() for each in ENERGIES])
def test_the_energy_is_the_base_models(effect: type[Effect]) -> None:
    """To the last digit."""
    place = Place()
    assert number(energy(effect(**effect.neutral), place)) == number(base(place.strain))


@pytest.mark.parametrize(
    ("effect", "key"), PARAMETERS, ids=[f"{each.name()}.{key}" for each, key in PARAMETERS]
)
def test_the_energy_has_a_slope(effect: type[Effect], key: str) -> None:
    """∂ψ/∂parameter is finite, the difference's, and not 0."""
    neutral = effect(**effect.neutral)
    place = Place()
    found = number(ufl.diff(energy(neutral, place), place.variables[key]))
    after, before = (number(energy(neutral, Place(**{key: h}))) for h in (STEP, -STEP))
    difference = (after - before) / (2 * STEP)
    size = number(base(place.strain))
    print(f"ψ = {size:.6g}, derivative {found:.9g}, difference {difference:.9g}")
    assert found == pytest.approx(difference, rel=1e-6, abs=1e-9 * size)
    assert abs(found) > 1e-4 * size


def test_a_line_without_a_lag() -> None:
    """p_out = p_in − τ dp_in/dt + …, with a remainder that vanishes faster than any power of τ."""
    flow = Flow(inlet_before_kPa=20.0, inlet_kPa=26.0, outlet_before_kPa=19.0, time_s=5, step_s=2)
    assert SetPointLogged(tau_s=0.0).outlet_kPa(flow) == 26.0
    for tau in (1e-12, 1e-6, 1e-3):
        slope = (SetPointLogged(tau_s=tau).outlet_kPa(flow) - 26.0) / tau
        assert slope == pytest.approx(-3.0, rel=1e-15 * 26 / tau / 3 + 1e-12)


def test_a_lag_that_outlasts_the_step() -> None:
    """For τ much longer than a step the outlet rises by (p_in − p_out) Δt/τ, to 1e-16 kPa."""
    flow = Flow(inlet_before_kPa=8.0, inlet_kPa=8.0, outlet_before_kPa=0.0, time_s=5, step_s=1e-6)
    assert SetPointLogged(tau_s=1e4).outlet_kPa(flow) == pytest.approx(8e-10, abs=2e-15)
    ramp = Flow(inlet_before_kPa=0.0, inlet_kPa=8.0, outlet_before_kPa=0.0, time_s=5, step_s=1e-6)
    assert SetPointLogged(tau_s=1e4).outlet_kPa(ramp) == pytest.approx(4e-10, abs=2e-15)


def test_a_step_of_no_duration() -> None:
    """Nothing flows through a line; without one the outlet is the inlet."""
    flow = Flow(inlet_before_kPa=3.0, inlet_kPa=4.0, outlet_before_kPa=2.0, time_s=5, step_s=0)
    assert SetPointLogged(tau_s=0.7).outlet_kPa(flow) == 2.0
    assert SetPointLogged(tau_s=0.0).outlet_kPa(flow) == 4.0
