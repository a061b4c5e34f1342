"""Whether the pressure has a maximum just beyond a state."""

from __future__ import annotations

import ufl

from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import CONTROL, volume_controlled
from dolfingrip.mechanics.path.policy import LIMIT_POINT
from dolfingrip.sections.numerics import Solver


class LimitPointSearch:
    """Increases the cavity's volume from a state at which the pressure could not be raised.

    Beyond a limit point equilibrium goes on at a falling pressure, and the search tests for that.
    If a single bellow collapses among stiff ones, norms of the displacement hardly show it.

    Args:
        model: model with the pressure among its controls.
        pressure: control of the pressure.
        volume: UFL form of the meshed cavity's volume (mm³).
        settings: of Newton's method.
    """

    def __init__(self, model: Model, pressure: Control, volume: ufl.Form, settings: Solver) -> None:
        self._model = model
        self._pressure = pressure
        self._volume = volume
        few = min(settings.max_iterations, LIMIT_POINT.iterations)
        self._settings = settings.model_copy(update={"max_iterations": few})

    def is_near(self, beyond_kPa: float) -> bool:
        """Return whether the pressure rises to a maximum and falls; the model is left as it was.

        Args:
            beyond_kPa: pressure that was not reached; if it is reached, there is no maximum.
        """
        good = self._model.state()
        model = volume_controlled(self._model, self._pressure, self._volume)
        newton, control = Newton(model, self._settings), model.controls[CONTROL]
        highest, start = self._pressure.value, control.value
        smallest = LIMIT_POINT.first * start
        volume, step, last = start, smallest, model.state()
        failed = 0
        try:
            for _ in range(LIMIT_POINT.most):
                control.set(volume + step)
                if not newton.solve().converged:
                    model.restore(last)
                    step /= LIMIT_POINT.shorter
                    failed += 1
                    if step < smallest or failed == LIMIT_POINT.failures:
                        break
                    continue
                pressure = self._pressure.value
                if pressure < (1 - LIMIT_POINT.fall) * highest:
                    return True
                if pressure > beyond_kPa:
                    return False
                highest = max(highest, pressure)
                volume, last = volume + step, model.state()
                step = min(2 * step, LIMIT_POINT.longest * start)
            # a long step may have passed the maximum, where the next one fails as the volume turns
            model.restore(last)
            here = self._pressure.value
            control.set(volume - smallest)
            back = volume > start and newton.solve().converged
            return back and self._pressure.value > here
        finally:
            self._model.restore(good)
