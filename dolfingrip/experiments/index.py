"""The experiments there are, in the order in which the command lists them."""

from __future__ import annotations

import importlib
from collections.abc import Mapping

from dolfingrip.config import ConfigError
from dolfingrip.experiments.experiment import Experiment

NAMES = (
    "bending",
    "blocked_force",
    "cycle",
    "coupon",
    "push",
)
"""One line an experiment: its file's name."""


def experiment(name: str) -> Experiment:
    """The experiment in the file of this name."""
    module = importlib.import_module(f"dolfingrip.experiments.{name}")
    (found,) = (
        item
        for item in vars(module).values()
        if isinstance(item, type)
        and issubclass(item, Experiment)
        and item.__module__ == module.__name__
    )
    made: Experiment = found()
    return made


EXPERIMENTS: Mapping[str, Experiment] = {name: experiment(name) for name in NAMES}


def find(name: str) -> Experiment:
    """The experiment of this name.

    Raises:
        ConfigError: one line with the names there are.
    """
    if name not in EXPERIMENTS:
        raise ConfigError(f"experiment {name}: allowed: {', '.join(EXPERIMENTS)}")
    return EXPERIMENTS[name]
