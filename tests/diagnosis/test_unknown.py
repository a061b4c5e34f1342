"""Numbers of causes, from standard normal ones by their priors."""

from __future__ import annotations

import numpy as np
import pytest

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.unknown import Cause, causes
from dolfingrip.extensions.index import effect

CAUSES = causes(Config())


@pytest.mark.parametrize("cause", CAUSES, ids=[each.name for each in CAUSES])
def test_each_number_that_is_tried_is_allowed(cause: Cause) -> None:
    """Also near an exponent of 0, which Ogden's law does not have."""
    middle = np.clip(np.zeros(len(cause.numbers)), *cause.box().T)
    for place, number in enumerate(cause.numbers):
        for zeta in np.linspace(number.low, number.high, 301):
            every = middle.copy()
            every[place] = zeta
            values = {}
            for own, z in zip(cause.numbers, every, strict=True):
                value = float(own.at(z))
                values[own.key.rpartition(".")[2]] = [value] if own.listed else value
            effect(cause.name).model_validate(values)
