"""How fast a cavity follows the pressure that its supply is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from dolfingrip.channels import CAVITY_PRESSURE, PRESSURE, TIME

if TYPE_CHECKING:
    from dolfingrip.experiments.results.readings import Readings

REACHED: Final = 0.95
"""Part of a pressure from which on it counts as reached."""


@dataclass(frozen=True, slots=True)
class StepResponse:
    """How the pressure in a cavity follows one that its supply is asked for.

    Attributes:
        wanted_kPa: that is wanted.
        time_s: since it is asked for in full, rising, (n,).
        cavity_kPa: pressure in the cavity, (n,).
    """

    wanted_kPa: float
    time_s: np.ndarray
    cavity_kPa: np.ndarray

    @property
    def reached_s(self) -> float:
        """Time to 95 % of the pressure; infinite where the cavity never has it."""
        wanted, rising = REACHED * self.wanted_kPa, np.maximum.accumulate(self.cavity_kPa)
        return float(np.interp(wanted, rising, self.time_s, right=np.inf))

    @property
    def sentence(self) -> str:
        """How fast it is."""
        what = f"{100 * REACHED:g} % of {self.wanted_kPa:.4g} kPa"
        if np.isinf(self.reached_s):
            return f"the cavity never has {what}: {self.cavity_kPa.max():.3g} kPa at most"
        if self.reached_s < 0:
            return f"the cavity has {what} before they are asked for in full"
        return f"the cavity has {what} {self.reached_s:.2g} s after they are asked for"


def remarks(result: Readings) -> list[str]:
    """Say when the cavity reaches the highest pressure that is asked for, where a supply fills it.

    Args:
        result: readings of a finger.
    """
    supply = result.config.supply
    if supply is None or supply.source == "syringe":
        return []
    names = (TIME.name, PRESSURE.name, CAVITY_PRESSURE.name)
    time_s, prescribed, inside = (result.column(name) for name in names)
    highest = float(prescribed.max(initial=0.0))
    if highest <= 0 or inside[0] >= REACHED * highest:
        return []
    return [StepResponse(highest, time_s - time_s[prescribed.argmax()], inside).sentence]
