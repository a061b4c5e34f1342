"""How fast a cavity follows the pressure that its supply is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from dolfingrip.channels import CAVITY_PRESSURE, PRESSURE, TIME

if TYPE_CHECKING:
    from dolfingrip.experiments.results.readings import Readings

REACHED: Final = 0.95
"""Part of a pressure from which on it counts as reached."""


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
    if highest <= 0:
        return []
    start_s, wanted = float(time_s[prescribed.argmax()]), REACHED * highest
    said = f"{100 * REACHED:g} % of the {highest:g} kPa"
    late = np.flatnonzero(inside >= wanted)
    if not late.size:
        return [f"the cavity never reaches {said}: {inside.max():.3g} kPa at most"]
    first = int(late[0])
    if first == 0:
        return []
    pair = slice(first - 1, first + 1)
    reached_s = float(np.interp(wanted, inside[pair], time_s[pair]))
    if reached_s < start_s:
        return [f"the cavity reaches {said} before these are asked for in full"]
    return [f"the cavity reaches {said} {reached_s - start_s:.2g} s after these are asked for"]
