"""A finger that is not simulated: its readings are in proportion to the load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip.channels import ANGLE, FORCE, TIP_X, TIP_Z, TRANSVERSE_STRAIN
from dolfingrip.diagnosis.data.table import CONTROL
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.experiments.request import Answer, Request

READ: Final = (ANGLE, FORCE, TIP_X, TIP_Z, TRANSVERSE_STRAIN)


@dataclass(frozen=True, slots=True)
class Pretended(Workers):
    """Invented: all readings are the load by the modulus, a force beyond an offset."""

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        answers = []
        for request in requests:
            config = request.config
            load = np.array(getattr(config.protocol, CONTROL[request.experiment.name]))
            by = load / config.material.mu_MPa * config.extensions.pressure_gain.gain
            values = {channel.name: by * channel.noise for channel in READ}
            if config.extensions.force_offset:
                values[FORCE.name] = values[FORCE.name] + config.extensions.force_offset.offset_N
            answers.append(Answer(values))
        return answers
