"""Whether the pressure has a maximum just beyond a state."""

from __future__ import annotations

from dataclasses import dataclass

import ufl

from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import CONTROL, volume_controlled
from dolfingrip.sections.numerics import Solver


@dataclass(frozen=True, slots=True)
class LimitPointPolicy:
    """How far and how finely a limit point is searched for.

    Attributes:
        first: first step of the volume, relative to the cavity's; each is twice the one before.
        longest: longest step of the volume, relative to the cavity's.
        most: largest number of steps; together they are about the cavity's volume.
        shorter: factor by which a step that fails is shortened.
        failures: of steps, after which the search ends.
        iterations: of a step, at most.
        fall: part of the pressure by which it must fall after a maximum.
    """

    first: float = 1e-4
    longest: float = 0.1
    most: int = 20
    shorter: float = 4.0
    failures: int = 3
    iterations: int = 10
    fall: float = 1e-4


class LimitPointSearch:
    """Increases the cavity's volume from a state at which the pressure could not be raised.

    Beyond a limit point equilibrium goes on at a falling pressure, and the search tests for that.
    If a single bellow collapses among stiff ones, norms of the displacement hardly show it.

    Args:
        model: model with the pressure among its controls.
        pressure: control of the pressure.
        volume: UFL form of the meshed cavity's volume (mm³).
        settings: of Newton's method.
        policy: lengths and number of steps.
    """

    def __init__(
        self,
        model: Model,
        pressure: Control,
        volume: ufl.Form,
        settings: Solver,
        policy: LimitPointPolicy = LimitPointPolicy(),
    ) -> None:
        self._policy = policy
        self._model = model
        self._pressure = pressure
        self._volume = volume
        few = min(settings.max_iterations, self._policy.iterations)
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
        smallest = self._policy.first * start
        volume, step, last = start, smallest, model.state()
        failed = 0
        try:
            for _ in range(self._policy.most):
                control.set(volume + step)
                if not newton.solve().converged:
                    model.restore(last)
                    step /= self._policy.shorter
                    failed += 1
                    if step < smallest or failed == self._policy.failures:
                        break
                    continue
                pressure = self._pressure.value
                if pressure < (1 - self._policy.fall) * highest:
                    return True
                if pressure > beyond_kPa:
                    return False
                highest = max(highest, pressure)
                volume, last = volume + step, model.state()
                step = min(2 * step, self._policy.longest * start)
            # a long step may have passed the maximum, where the next one fails as the volume turns
            model.restore(last)
            here = self._pressure.value
            control.set(volume - smallest)
            back = volume > start and newton.solve().converged
            return back and self._pressure.value > here
        finally:
            self._model.restore(good)
