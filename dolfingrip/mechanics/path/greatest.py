"""The greatest pressure ahead, by a load path of the volume.

Beyond a limit point equilibrium goes on at a falling pressure, and the path tests for that. If a
single bellow collapses among stiff ones, norms of the displacement hardly show it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Final

import numpy as np
import ufl

from dolfingrip.mechanics.model.model import Control, Model
from dolfingrip.mechanics.model.state import State
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.volume_control import CONTROL, volume_controlled
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.path.policy import PathPolicy
from dolfingrip.sections.numerics import Solver

LONGEST: Final = 0.4
"""Longest step of the volume, relative to that at the start."""

LARGEST: Final = 10.0
"""Volume to which the maximum is sought, relative to that at the start."""

ITERATIONS: Final = 10
"""Largest number of Newton iterations of a step."""

SHORTEST: Final = 0.1
"""Shortest step of the volume, by the longest; where one fails that is shorter, the path ends."""

LEFT: Final = 0.01
"""Residual that is left, relative to the load, by the part by which the pressure is to fall."""

CUBIC: Final = 4
"""States of the path through which a cubic goes."""

FLAT: Final = 0.01
"""Part of the pressure by which it rises at most in one more step where walls that balloon have
their greatest one."""

SAMPLES: Final = 21
"""Places of a step at which the cubic is evaluated."""


def greatest(
    model: Model,
    pressure: Control,
    volume: ufl.Form,
    settings: Solver,
    beyond_kPa: float,
    fall: float,
    balloons: Callable[[], bool] = lambda: False,
) -> tuple[float, State] | None:
    """Inflate a model by its volume until the pressure falls; the model is left as it was.

    Args:
        model: model with the pressure among its controls.
        pressure: control of the pressure.
        volume: UFL form of the meshed cavity's volume (mm³).
        settings: of Newton's method.
        beyond_kPa: pressure that was not reached; if it is reached, there is no maximum.
        fall: part of the pressure by which it must fall after a maximum.
        balloons: whether the model's state is that of walls that balloon, and not of a fold that
            snaps: then the path ends where it is nearly flat.

    Returns:
        The greatest pressure (kPa), and the state of the model there; None if it does not fall.
    """
    good = model.state()
    few = {
        "max_iterations": min(settings.max_iterations, ITERATIONS),
        "min_step_kPa": SHORTEST * settings.max_step_kPa,
        "rtol": max(settings.rtol, LEFT * fall),
    }
    newton = Newton(volume_controlled(model, pressure, volume), settings.model_copy(update=few))
    start = newton.model.controls[CONTROL].value
    states, volumes, turned = [(pressure.value, good)], [start], False

    def over() -> bool:
        nonlocal turned
        states.append((pressure.value, model.state()))
        volumes.append(newton.model.controls[CONTROL].value)
        turned = _falls(states, fall) or (_flattens(volumes, states, beyond_kPa) and balloons())
        return turned or pressure.value > beyond_kPa

    halves = PathPolicy(halves_first=True)
    path = LoadPath(newton, {CONTROL: LONGEST * start}, over=over, damped=False, policy=halves)
    path.advance({CONTROL: LARGEST * start})
    model.restore(good)
    return max(states, key=itemgetter(0)) if turned else None


def _flattens(
    volumes: Sequence[float], states: Sequence[tuple[float, State]], beyond_kPa: float
) -> bool:
    """Return whether the pressure hardly rises over one more step as long as the last one.

    A cubic goes on through the last states. A pressure that is still reached there has no maximum
    before it.
    """
    if len(volumes) < CUBIC:
        return False
    ahead = np.array(volumes[-CUBIC:]) - volumes[-1]
    pressures = [pressure_kPa for pressure_kPa, _ in states[-CUBIC:]]
    cubic = np.polynomial.Polynomial.fit(ahead, pressures, CUBIC - 1)
    most = float(cubic(np.linspace(0.0, -ahead[-2], SAMPLES)).max())
    return most < min(beyond_kPa, (1 + FLAT) * pressures[-1])


def _falls(states: Sequence[tuple[float, State]], fall: float) -> bool:
    """Return whether the last pressure is below the greatest by more than a part of it."""
    return states[-1][0] < (1 - fall) * max(pressure_kPa for pressure_kPa, _ in states)
