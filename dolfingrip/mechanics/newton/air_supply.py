"""Air that a supply lets into a cavity: its pressure is solved for together with the shape."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Final

import numpy as np
import ufl
from dolfinx import fem

from dolfingrip.mechanics.model.model import Control, Model, Prescribed
from dolfingrip.mechanics.model.pneumatics import Air, Ends
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient
from dolfingrip.mechanics.newton.volume_control import CONTROL, VolumeControl

POINTS: Final = 16
"""Points of Gauss' rule by which the air's potential is integrated over the pressure."""

LEAST_MPA: Final = 1e-3
"""Absolute pressure that an iterate of the cavity's does not fall below."""


class AirSupply(VolumeControl):
    """Adds the air of a supply to Π: the cavity has the volume that the air takes.

    Π contains −p V(u). With + φ(p), φ' = V_air(p; Δt), it is stationary in p where both volumes are
    equal. V_air is what the balances of tube, tank and cavity leave at the pressure p at the end of
    the load step (:class:`~dolfingrip.mechanics.model.pneumatics.Air`), so that these are solved
    together with the shape. V_air falls as p rises, so that Π is concave in p. A syringe displaces
    what volume control prescribes, out of a barrel whose air has the cavity's pressure.

    Args:
        u: displacement (mm).
        pressure: control of the pressure, which becomes a result.
        volume: UFL form of the meshed cavity's volume (mm³).
        copies: number of meshed parts in the whole.
        air: what flows, at rest.
        set_point: the pressure that is asked for (kPa).
        error_MPa: error of the pressure in a step that is allowed.
        barrel_mm3: air in a syringe at first.

    Attributes:
        air: the air at the load step's start.
    """

    name: ClassVar[str] = "supply"

    def __init__(
        self, u: fem.Function, pressure: Control, volume: ufl.Form, copies: int, air: Air,
        set_point: Prescribed, error_MPa: float, barrel_mm3: float = 0.0,
    ) -> None:  # fmt: skip
        super().__init__(u, pressure, volume, copies)
        self.air, self._set_point, self._kpa = air, set_point, pressure.factor
        self._error_MPa, self._barrel_mm3, self._step_s = error_MPa, barrel_mm3, 0.0
        self.begin()

    def begin(self) -> None:
        """Fill everything with air of the pressure around, at the present volume of the cavity."""
        self.control.set(self.volume_mm3())
        self._rest_mm3 = self.control.value
        self.air.dead_mm3 = self._dead_mm3
        self.air.rest(self._rest_mm3)
        self._start, self._give = (self._rest_mm3, self.air.line.ambient), 0.0
        self._rest_air_mm3 = float(self.air.now.amounts.sum())
        self._force_N = self._load_N()

    @property
    def _dead_mm3(self) -> float:
        """Volume left in a syringe's barrel, with the tube; 0 without a syringe."""
        if not self.air.syringe:
            return 0.0
        displaced = self.control.value - self._rest_mm3
        return self._barrel_mm3 + self.air.line.tube_mm3 - displaced

    @property
    def _asked(self) -> tuple[float, float]:
        """Absolute pressure (MPa) that is asked for, and the step's length (s)."""
        return self._set_point.value * self._kpa + self.air.line.ambient, self._step_s

    def _absolute(self, pressure: float) -> float:
        return max(pressure + self.air.line.ambient, LEAST_MPA)

    def ends(self) -> Ends:
        """The air at the step's end, at the present pressure."""
        return self.air.ends(self._absolute(self.unknown.value), *self._asked)

    def filling_s(self) -> float:
        """Time in which valve and tube, choked, fill tube and cavity with air at rest."""
        return self.air.line.filling_s(self._rest_mm3)

    def held_mm3(self) -> float:
        """Free air in source, tube and cavity, by their pressures and the cavity's shape."""
        now, line = self.air.now, self.air.line
        cavity = self.volume_mm3() + self._dead_mm3
        volumes = np.array([line.tank_mm3, 0.0 if self.air.syringe else line.tube_mm3, cavity])
        stored = now.pressures ** (1 / line.exponent) * volumes
        parts = np.divide(stored, now.invariants, out=np.zeros(3), where=now.invariants > 0)
        return float(parts @ now.amounts)

    def balance_error(self) -> float:
        """Air that is held by that at rest and that entered since, less 1."""
        expected = self._rest_air_mm3 + self.air.now.entered
        return self.held_mm3() / expected - 1

    # -- as a term -------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """φ(p) of the meshed part (mJ), 0 where p is that of the air around."""
        half = self.unknown.value / 2
        places, weights = np.polynomial.legendre.leggauss(POINTS)
        volumes = [
            self.air.volume_mm3(self._absolute(half * (1 + place)), *self._asked)
            for place in places
        ]
        return float(half * weights @ volumes) / self._copies

    def given_mm3(self) -> float:
        return self.air.volume_mm3(self._absolute(self.unknown.value), *self._asked)

    def given_slope(self) -> float:
        pressure, volume = self._absolute(self.unknown.value), self.volume_mm3()
        before, start = self._start
        if (volume - before) * (pressure - start) > 0:
            self._give = (volume - before) / (pressure - start)
        return self.air.slope(pressure, *self._asked, volume, self._give)

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        raise NoShapeGradient("supply: no derivative by coordinates")

    # -- as a memory -----------------------------------------------------------------------------

    def set_time(self, time_s: float, step_s: float) -> None:
        """Set the step's length and the volume that a syringe has displaced."""
        self._step_s, self.air.dead_mm3 = step_s, self._dead_mm3

    def set_cycle(self, cycle: float) -> None:
        """Set the decades of cycles that a leak has grown over."""
        self.air.decades = math.log10(cycle)

    def step_error(self) -> float:
        """Error of the step's pressure by the allowed one."""
        return self.air.error(self.ends(), self._step_s) / self._error_MPa

    def accept(self) -> None:
        """Take the air at the step's end."""
        super().accept()
        self.air.accept(self.ends(), self._step_s)
        self._start = self.volume_mm3(), self._absolute(self.unknown.value)

    def values(self) -> dict[str, np.ndarray]:
        """Return a copy of the state of the air, by name."""
        return self.air.values()

    def restore(self, values: Mapping[str, np.ndarray]) -> None:
        """Restore a state of the air."""
        self.air.restore(values)


def supplied(model: Model, term: AirSupply) -> Model:
    """A model of the same fields and terms whose cavity's air comes from a supply.

    Args:
        model: model under pressure control.
        term: the supply, of the model's displacement.
    """
    control = {CONTROL: term.control} if term.air.syringe else {}
    return model.with_term(term, [term.unknown], control)
