"""Choices of the model: they have no derivative, but the difference of two runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from dolfingrip.config import Config
from dolfingrip.experiments.results.readings import Row

NUMERICAL = tuple(
    f"extensions.{effect.name()}"
    for effect in type(Config().extensions).effects
    if effect.kind == "numerical"
)
"""Keys of all choices: tables of effects that describe the computation and not the finger."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice of the model, made in a configuration or not.

    Attributes:
        key: key of its table in the configuration.
        made: whether the configuration has that table.
        other: the configuration with the choice made the other way.
    """

    key: str
    made: bool
    other: Config

    @property
    def label(self) -> str:
        """Name of the choice in the column ``parameter`` of ``sensitivity.csv``."""
        return f"{self.key} (with minus without)"

    def difference(self, here: float, there: float) -> float:
        """Reading with the choice minus reading without it.

        Args:
            here: a reading of the configuration's run.
            there: this reading in the run of :attr:`other`.
        """
        return here - there if self.made else there - here

    def differences(
        self, here: Sequence[Row], there: Sequence[Row], columns: Sequence[str]
    ) -> list[Row]:
        """Rows of ``sensitivity.csv`` for the stops that both runs reached.

        Args:
            here: rows of the configuration's run.
            there: rows of the run of :attr:`other`.
            columns: names of the rows that are made.
        """
        found: list[Row] = []
        for i, (first, second) in enumerate(zip(here, there, strict=False)):
            for name, value in first.items():
                if name == "time_s" or not isinstance(value, float):
                    continue
                apart = self.difference(value, second[name])
                if math.isfinite(apart):
                    found.append(dict(zip(columns, (i, name, self.label, apart), strict=True)))
        return found


def choices(config: Config, keys: Sequence[str] | None) -> list[Choice]:
    """Return the choices of the model among the keys that derivatives are asked for.

    A choice that ``config`` does not make is made with its default values.

    Args:
        config: that the choices are made or not made in.
        keys: of parameters and choices; None: none.

    Raises:
        ConfigError: one line, where a choice cannot be made with the rest of ``config``.
    """
    found = []
    for key in dict.fromkeys(keys or ()):
        if key not in NUMERICAL:
            continue
        name = key.partition(".")[2]
        made = getattr(config.extensions, name) is not None
        other = config.changed(extensions={name: None if made else {}})
        other.adapted()  # raises where the choice does not go with the rest
        found.append(Choice(key, made, other))
    return found
