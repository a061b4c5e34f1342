"""The values that instruments display, from true readings."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from dolfingrip.config import Config
from dolfingrip.extensions.effect import Displaying


def displayed(config: Config, true: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Distort the readings of a run so far by the effects of the instruments, one after the other.

    Args:
        config: configuration with the instruments' effects.
        true: true readings by column, (rows,) each in the order of time, in the columns' units.

    Returns:
        What the instruments show by column, (rows,) each, in the same units.
    """
    shown = dict(true)
    for effect in config.extensions.active(Displaying):
        shown |= effect.reading(shown)
    return shown
