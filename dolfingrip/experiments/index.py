"""The index of experiments, in the order in which the command lists them."""

from __future__ import annotations

from collections.abc import Mapping

from dolfingrip import plugins
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.lookup import classes

NAMES = (
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
    for name, kind in classes("experiments", "dolfingrip.experiments", NAMES, Experiment).items()
}
"""By the name of the file, those of plugins last."""


def find(name: str) -> Experiment:
    """Return an experiment by its name, or by its command's.

    Args:
        name: such as ``blocked_force`` or ``force``.

    Raises:
        ConfigError: one line that lists the allowed names.
    """
    by_name = {entry.command: entry for entry in EXPERIMENTS.values()} | {**EXPERIMENTS}
    if name not in by_name:
        allowed = [
            key if key == entry.command else f"{key} (or {entry.command})"
            for key, entry in EXPERIMENTS.items()
        ]
        raise ConfigError(f"experiment {name}: allowed: {', '.join(allowed)}; {plugins.hint(name)}")
    return by_name[name]
