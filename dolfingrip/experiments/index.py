"""The index of experiments, in the order in which the command lists them."""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip.experiments.experiment import Experiment
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.lookup import classes

FILES = (
    "bending",
    "blocked_force",
    "cycle",
    "coupon",
    "push",
    "vibration",
    "grasp",
)
"""The name of each experiment's file."""

EXPERIMENTS: Mapping[str, Experiment] = {
    name: kind()
    for name, kind in classes("experiments", "dolfingrip.experiments", FILES, Experiment).items()
}
"""By the name of the file, those of plugins last."""


def find(name: str) -> Experiment:
    """Return an experiment by its name, or by its command's.

    Args:
        name: such as ``blocked_force`` or ``force``.

    Raises:
        ConfigError: one line that lists the allowed names.
    """
    by_name = {each.command: each for each in EXPERIMENTS.values()} | {**EXPERIMENTS}
    if name not in by_name:
        told = [
            known if known == each.command else f"{known} (or {each.command})"
            for known, each in EXPERIMENTS.items()
        ]
        raise ConfigError(f"experiment {name}: allowed: {', '.join(told)}")
    return by_name[name]
