"""The configuration: one TOML file, checked before anything is computed.

Every model is built from a :class:`Config` alone. Keys carry their unit in their name;
defaults are the reference finger. Units: mm, MPa, N, s; pressure in kPa at every
interface (:data:`KPA` converts once, where a form's constant is set).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

from dolfingrip.extensions.index import Extensions
from dolfingrip.foods.food import Food
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError, checked
from dolfingrip.sections.films import Film
from dolfingrip.sections.fixture import Gravity, Plate
from dolfingrip.sections.material import Material
from dolfingrip.sections.numerics import Contact, Solver
from dolfingrip.sections.procedure import Branch, Coupon, Experiment, Protocol
from dolfingrip.sections.setup import Setup
from dolfingrip.sections.specimen import Cog, Finger, Mesh, Morph
from dolfingrip.sections.units import KPA

__all__ = [
    "KPA",
    "Branch",
    "Cog",
    "Config",
    "ConfigError",
    "Contact",
    "Coupon",
    "Experiment",
    "Film",
    "Finger",
    "Gravity",
    "Material",
    "Mesh",
    "Morph",
    "Plate",
    "Protocol",
    "Setup",
    "Solver",
    "checked",
    "dumps",
    "from_dict",
    "load",
]


class Config(Setup):
    """All that a simulation depends on."""

    food: Food = Food()
    extensions: Extensions = Extensions()

    def overridden(self, assignments: Sequence[str]) -> Self:
        """A checked copy with ``section.key=value`` strings applied in order.

        Raises:
            ConfigError: one line naming the key, its value and the allowed range.
        """
        data = self.model_dump(exclude_none=True)
        for assignment in assignments:
            tables.override(data, assignment)
        return checked(type(self), data)

    def adapted(self) -> Self:
        """The configuration that is meshed and solved, with extensions of geometry applied."""
        done = self
        for effect in self.extensions.active("adapt"):
            done = effect.adapt(done)
        return done.model_copy(update={"extensions": done.extensions.without("adapt")})


def load(
    file: Path | str | None = None, overrides: Sequence[str] = (), defaults: Sequence[str] = ()
) -> Config:
    """Read, override and check the configuration.

    Args:
        file: TOML file, or the ``run.json`` of an earlier run; the reference finger where None.
            Its mesh file is relative to its folder.
        overrides: ``section.key=value`` strings, applied in order; a mesh file is relative
            to the working folder.
        defaults: ``section.key=value`` strings that a command has in place of the reference
            finger's; the file and the overrides take precedence.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    data: dict[str, Any] = {}
    if file is not None:
        file = Path(file)
        data = tables.read(file)
        tables.anchor(data, file.parent)
    for assignment in defaults:
        tables.override(data, assignment, replace=False)
    for assignment in overrides:
        tables.override(data, assignment)
    tables.anchor(data, Path())
    return from_dict(data)


def from_dict(data: dict[str, Any]) -> Config:
    """A checked configuration from nested dictionaries, as in ``run.json``.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    return checked(Config, data)


def dumps(config: Config) -> str:
    """The resolved configuration as TOML, each key with its meaning as a comment."""
    return tables.dumps(config)
