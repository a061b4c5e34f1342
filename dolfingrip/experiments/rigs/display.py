"""The values that instruments display, from true readings."""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip.config import Config
from dolfingrip.extensions.effect import Displaying


def displayed(config: Config, true: Mapping[str, float]) -> dict[str, float]:
    """Distort a row of readings by the effects of the instruments, one after the other.

    Args:
        config: configuration with the instruments' effects.
        true: true readings by column, in the columns' units.

    Returns:
        What the instruments show by column, in the same units.
    """
    row = dict(true)
    for effect in config.extensions.active(Displaying):
        row |= effect.reading(row)
    return row
