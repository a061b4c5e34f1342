"""What the instruments display of true readings."""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip.config import Config


def displayed(config: Config, true: Mapping[str, float]) -> dict[str, float]:
    """A row of readings as the instruments' extensions distort it, one after the other."""
    row = dict(true)
    for effect in config.extensions.active("reading"):
        row |= effect.reading(row)
    return row
