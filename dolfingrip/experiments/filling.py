"""Pressure that a supply of air makes in a finger at rest, many times faster than real time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

from dolfingrip.config import KPA
from dolfingrip.experiments.results.following import REACHED, StepResponse
from dolfingrip.mechanics.model.pneumatics import OUTSIDE, REFERENCE_MPA, Air, Line

PLACES: Final = 1000
"""Pressures between which the cavity's is interpolated by what is in it."""

STEPS: Final = 100
"""Times in each half of a step response."""

RTOL: Final = 1e-5
"""Relative error of a step of the amounts of air."""

STILL: Final = 1e-3
"""Part of a step by which the pressure rises in half of the time where it rises no longer."""


@dataclass(frozen=True, slots=True)
class RestingFinger:
    """A finger at rest at each pressure of its cavity.

    Attributes:
        pressure_kPa: rising from 0 on, (n,).
        volume_mm3: of the cavity there, (n,).
        angle_deg: of the tip there, (n,).
    """

    pressure_kPa: np.ndarray
    volume_mm3: np.ndarray
    angle_deg: np.ndarray

    def volume_at(self) -> Callable[[float], float]:
        """Return the volume (mm³) as a function of pressure (kPa above that of the air around)."""
        inside = PchipInterpolator(self.pressure_kPa, self.volume_mm3)
        ends = self.pressure_kPa[[0, -1]]
        slopes = inside(ends, 1)

        def volume(kPa: float) -> float:
            nearest = min(max(kPa, ends[0]), ends[1])
            slope = slopes[0] if kPa < ends[0] else slopes[1]
            return float(inside(nearest) + slope * (kPa - nearest))

        return volume


def step_response(
    finger: RestingFinger, line: Line, set_kPa: float, wanted_kPa: float | None = None
) -> StepResponse:
    """Ask a supply for a pressure at once.

    Args:
        finger: volume of its cavity by the pressure.
        line: of a supply; no syringe.
        set_kPa: that it is asked for, unless its valve is commanded.
        wanted_kPa: that is wanted; None: the same.
    """
    wanted = set_kPa if wanted_kPa is None else wanted_kPa
    times = line.filling_s(finger.volume_mm3[-1]) * np.linspace(0.0, 1.0, 2 * STEPS + 1)
    while True:
        reached = filled_kPa(finger, line, list(times), len(times) * [set_kPa])
        rise = reached[-1] - reached[STEPS]
        if reached[-1] >= REACHED * wanted or rise < STILL * wanted:
            return StepResponse(wanted, times, reached)
        times = 2 * times


def filled_kPa(
    finger: RestingFinger, line: Line, time_s: Sequence[float], set_kPa: Sequence[float]
) -> np.ndarray:
    """Integrate the balances of tank, tube and cavity from rest.

    They are those of :class:`~dolfingrip.mechanics.model.pneumatics.Air`, with steps of LSODA's.

    Args:
        finger: volume of its cavity by the pressure.
        line: of a supply; no syringe.
        time_s: times that rise, (n,).
        set_kPa: pressure that the supply is asked for there, linear in between, (n,).

    Returns:
        Pressure (kPa) in the cavity at these times, (n,).
    """
    volume = finger.volume_at()
    air, n, ambient = Air(line), line.exponent, line.ambient
    air.rest(volume(0.0))
    pressures = np.linspace(0.01 * ambient, 2 * (ambient + finger.pressure_kPa[-1] * KPA), PLACES)
    volumes = np.array([volume((pressure - ambient) / KPA) for pressure in pressures])
    held = pressures ** (1 / n) * volumes

    def stand(t: float, invariants: np.ndarray) -> tuple[list[float], float]:
        prescribed = float(np.interp(t, time_s, set_kPa)) * KPA + ambient
        tank, tube, cavity = map(float, np.maximum(invariants, 0.0))
        source = (tank / line.tank_mm3) ** n if line.tank_mm3 else prescribed
        inside = float(np.interp(cavity, held, pressures))
        return [source, (tube / line.tube_mm3) ** n, inside], prescribed

    def slopes(t: float, y: np.ndarray) -> np.ndarray:
        (places, prescribed), (amounts, invariants) = stand(t, y[3:]), (y[:3], y[3:])
        shares = [
            s / a if a > 0 else REFERENCE_MPA for a, s in zip(amounts, invariants, strict=True)
        ]
        _, gain, entered, warmth = air.exchanged(places, prescribed, shares)
        rates = [
            REFERENCE_MPA * warmth[i] * p ** (1 / n - 1) - (entered[i] - gain[i]) * shares[i]
            for i, p in enumerate(places)
        ]
        return np.array([*gain[:OUTSIDE], *rates])

    start = np.concatenate([air.now.amounts, air.now.invariants])
    size = np.where(start > 0, start, 1.0)
    times = np.asarray(time_s, dtype=float)
    solved = solve_ivp(
        slopes, times[[0, -1]], start, "LSODA", times, rtol=RTOL, atol=RTOL * size,
        max_step=np.ptp(times) / len(times),
    )  # fmt: skip
    return np.array([(stand(t, y[3:])[0][2] - ambient) / KPA
                     for t, y in zip(times, solved.y.T, strict=True)])  # fmt: skip
