"""The values that instruments display, from true readings."""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip.config import Config
from dolfingrip.extensions.effect import Displaying


def displayed(config: Config, true: Mapping[str, float]) -> dict[str, float]:
    """A row of readings that the instruments' extensions distort one after the other."""
    row = dict(true)
    for effect in config.extensions.active(Displaying):
        row |= effect.reading(row)
    return row
