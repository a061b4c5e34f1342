"""Whether the pressure has a maximum just beyond a state."""

from __future__ import annotations

import ufl

from dolfingrip.config import Solver
from dolfingrip.mechanics.model import Control, Model
from dolfingrip.mechanics.newton import Newton
from dolfingrip.mechanics.volume_control import VolumeControl

FIRST = 1e-4
"""First step of the volume, relative to the cavity's at rest; each is twice the one before."""

MOST = 11
"""Steps: the last ends a fifth of the cavity's volume away."""

FALL = 1e-4
"""Part of the pressure by which it must fall to have had a maximum."""


class Summit:
    """Leads the cavity's volume on from a state at which the pressure could not be raised.

    A limit point is where equilibrium goes on at a falling pressure, so it is looked for. A single
    bellows that gives way among stiff ones hardly shows in any norm of the displacement.

    Args:
        model: with the pressure among its controls.
        pressure: that control.
        volume: UFL form of the meshed cavity's volume (mm³).
        settings: of Newton's method.
    """

    def __init__(self, model: Model, pressure: Control, volume: ufl.Form, settings: Solver) -> None:
        self._model = model
        self._pressure = pressure
        self._volume = volume
        self._settings = settings

    def is_near(self) -> bool:
        """Whether the pressure rises to a maximum and falls; the model is left as it was."""
        good = self._model.state()
        control = VolumeControl(self._model, self._pressure, self._volume)
        newton = Newton(self._model, self._settings, border=control)
        highest, volume, step = self._pressure.value, control.value, FIRST * control.value
        try:
            for _ in range(MOST):
                volume, step = volume + step, 2 * step
                control.set(volume)
                if not newton.solve().converged:
                    return False
                if self._pressure.value < (1 - FALL) * highest:
                    return True
                highest = max(highest, self._pressure.value)
        finally:
            self._model.restore(good)
        return False
