"""Pressure that a supply of air makes in a finger at rest, many times faster than real time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.integrate import solve_ivp

from dolfingrip.config import KPA
from dolfingrip.experiments.feedforward import RestingFinger
from dolfingrip.experiments.results.following import REACHED
from dolfingrip.experiments.rigs.pneumatics import line_of
from dolfingrip.mechanics.model.pneumatics import OUTSIDE, REFERENCE_MPA, Air
from dolfingrip.sections.supply import AirLine

PLACES: Final = 1000
"""Pressures between which the cavity's is interpolated by what is in it."""

STEPS: Final = 100
"""Times in each half of a step response."""

RTOL: Final = 1e-5
"""Relative error of a step of the amounts of air."""


STILL: Final = 1e-3
"""Part of a step by which the pressure rises in half of the time where it rises no longer."""


@dataclass(frozen=True, slots=True)
class StepResponse:
    """How a supply fills a finger whose pressure is asked for at once.

    Attributes:
        highest_kPa: that is asked for.
        time_s: from then on, until it is reached, or not any more, (n,).
        cavity_kPa: pressure in the cavity, (n,).
    """

    highest_kPa: float
    time_s: np.ndarray
    cavity_kPa: np.ndarray

    @property
    def reached_s(self) -> float:
        """Time to 95 % of the pressure; infinite where the cavity never has it."""
        wanted = REACHED * self.highest_kPa
        return float(np.interp(wanted, self.cavity_kPa, self.time_s, right=np.inf))

    @property
    def sentence(self) -> str:
        """How fast it is."""
        what = f"{100 * REACHED:g} % of {self.highest_kPa:g} kPa"
        if np.isinf(self.reached_s):
            return f"never {what}: {self.cavity_kPa[-1]:.3g} kPa at most"
        return f"{what} after {self.reached_s:.2g} s"


def step_response(finger: RestingFinger, supply: AirLine, highest_kPa: float) -> StepResponse:
    """Ask a supply for a pressure at once.

    Args:
        finger: volume of its cavity by the pressure.
        supply: of air; no syringe.
        highest_kPa: that is asked for.
    """
    times = line_of(supply).filling_s(finger.volume_mm3[-1]) * np.linspace(0.0, 1.0, 2 * STEPS + 1)
    while True:
        reached = filled_kPa(finger, supply, list(times), len(times) * [highest_kPa])
        rise = reached[-1] - reached[STEPS]
        if reached[-1] >= REACHED * highest_kPa or rise < STILL * highest_kPa:
            return StepResponse(highest_kPa, times, reached)
        times = 2 * times


def filled_kPa(
    finger: RestingFinger, supply: AirLine, time_s: Sequence[float], set_kPa: Sequence[float]
) -> np.ndarray:
    """Integrate the balances of tank, tube and cavity from rest.

    They are those of :class:`~dolfingrip.mechanics.model.pneumatics.Air`, with steps of LSODA's.

    Args:
        finger: volume of its cavity by the pressure.
        supply: of air; no syringe.
        time_s: times that rise, (n,).
        set_kPa: pressure that the supply is asked for there, linear in between, (n,).

    Returns:
        Pressure (kPa) in the cavity at these times, (n,).
    """
    line, volume = line_of(supply), finger.volume_at()
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
