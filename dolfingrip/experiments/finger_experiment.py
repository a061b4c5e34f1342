"""The base class of experiments on a pressurised finger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from dolfingrip.experiments.description import PRESSURE_OPTION, Option
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.notes import notes
from dolfingrip.experiments.protocol import pressurisation
from dolfingrip.experiments.protocol.schedule import Stop

if TYPE_CHECKING:
    from dolfingrip.config import Config
    from dolfingrip.sections.geometry.geometry import Geometry


class FingerExperiment(Experiment):
    """An experiment whose control is the pressure or the volume of the finger's cavity.

    Args:
        made_for: dimensions that the mesh is made for and moved from; None: the configuration's.
    """

    options: ClassVar[tuple[Option, ...]] = (PRESSURE_OPTION,)

    def __init__(self, made_for: Geometry | None = None) -> None:
        self.made_for = made_for

    def schedule(self, config: Config) -> Sequence[Stop]:
        return pressurisation.stops(config)

    def setup(self, config: Config) -> dict[str, Any]:
        data: dict[str, Any] = {
            "rate_kPa_per_s": config.experiment.rate_kPa_per_s,
            **config.drawn(),
        }
        if config.gravity.acceleration_m_s2:
            data["gravity"] = {"direction": list(config.gravity.direction)}
        return data

    def notes(self, config: Config) -> list[str]:
        return notes(config)
