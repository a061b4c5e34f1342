"""Pressurise and vent again and again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.blocked_force import BlockedForce
from dolfingrip.experiments.experiment import (
    DYNAMIC_OPTION,
    PRESSURE_OPTION,
    SUCTION_OPTION,
    Config,
    Experiment,
    Option,
)


class Cycle(Bending):
    """Pressurise and vent again and again.

    Example: dolfingrip cycle --cycles 3 --rate-kPa-per-s 50

    Its results are those of free bending, or those of the blocked force with ``--blocked``.
    """

    command: ClassVar = "cycle"
    options: ClassVar = (
        Option("--cycles", int, 2, "Number of times up and down.", "experiment.cycles"),
        PRESSURE_OPTION,
        SUCTION_OPTION,
        DYNAMIC_OPTION,
        Option(
            "--rate-kPa-per-s",
            float,
            None,
            "Rate of the ramps (kPa/s).",
            "experiment.rate_kPa_per_s",
        ),
        Option(
            "--hold-s",
            float,
            None,
            "Length of the wait at the highest pressure (s).",
            "experiment.hold_s",
        ),
        Option("--blocked", bool, False, "Press on the force sensor's plate."),
    )
    protocol: ClassVar = False
    measured: ClassVar = False

    def settings(self, config: Config) -> Config:
        return config.changed(experiment={"unload": True})

    def with_options(self, given: Mapping[str, Any]) -> Experiment:
        return BlockedForce() if given["blocked"] else self
