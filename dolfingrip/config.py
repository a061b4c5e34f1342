"""The configuration: one TOML file, checked before anything is computed.

Every model is built from a :class:`Config` alone. Keys carry their unit in their name;
defaults are the reference finger. Units: mm, MPa, N, s; pressure in kPa at every
interface (:data:`KPA` converts once, where a form's constant is set).
"""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Mapping
from html import escape
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final, Self

from dolfingrip.channels import Part
from dolfingrip.extensions.effect import Adapting
from dolfingrip.extensions.index import Extensions
from dolfingrip.files.text_table import TextTable
from dolfingrip.foods.food import Food, Obstacle
from dolfingrip.sections import tables
from dolfingrip.sections.errors import ConfigError, checked, shown
from dolfingrip.sections.films import Film
from dolfingrip.sections.material import Material
from dolfingrip.sections.numerics import Contact, Solver
from dolfingrip.sections.section import EVERYWHERE
from dolfingrip.sections.setup import Setup
from dolfingrip.sections.specimen import Finger, Mesh
from dolfingrip.sections.tables import dumps
from dolfingrip.sections.units import KPA

__all__ = [
    "KPA",
    "NO_CHANGE",
    "Change",
    "Config",
    "ConfigError",
    "Contact",
    "Film",
    "Finger",
    "Material",
    "Mesh",
    "Solver",
    "changed",
    "checked",
    "dumps",
    "felt",
    "followed",
    "from_dict",
    "load",
]


Change = Mapping[str, Any]
"""Values by key of the configuration, such as ``{"finger.wall_mm": 1.8}``."""

NO_CHANGE: Final[Change] = MappingProxyType({})
"""A change of nothing."""


class Config(Setup):
    """All that a simulation depends on."""

    food: Food = Food()
    obstacle: Obstacle | None = None
    extensions: Extensions = Extensions()

    def overview(self) -> TextTable:
        """Return the table of values that differ from the reference finger's."""
        plain = self.model_dump(mode="json", exclude_none=True)
        reference = Config().model_dump(mode="json", exclude_none=True)
        rows = [
            [f"{section}.{key}", shown(value), shown(usual[key]) if key in usual else "–"]
            for section, values in plain.items()
            for usual in [reference.get(section, {})]
            for key, value in values.items()
            if usual.get(key) != value
        ]
        title = "Configuration: the reference finger" + (" but for" if rows else "")
        return TextTable(["key", "value", "reference"] if rows else [], rows, title)

    def __repr__(self) -> str:
        """The overview, as a console shows it."""
        return self.overview().text()

    __str__ = __repr__

    def _repr_html_(self) -> str:
        """The overview and all keys, as a notebook shows them."""
        keys = f"<details><summary>All keys</summary><pre>{escape(dumps(self))}</pre></details>"
        return f"{self.overview().html()}\n{keys}"

    def adapted(self) -> Self:
        """The configuration that is meshed and solved, with extensions of geometry applied."""
        done = self
        for effect in self.extensions.active(Adapting):
            done = effect.adapt(done)
        return done.model_copy(update={"extensions": done.extensions.without(Adapting)})


def load(
    file: Path | str | Change | None = None,
    overrides: Change = NO_CHANGE,
    defaults: Change = NO_CHANGE,
) -> Config:
    """Read, override and check the configuration.

    Args:
        file: TOML file, or the ``run.json`` of an earlier run; the reference finger where None.
            Its mesh file is relative to its folder. Values by key are overrides.
        overrides: values by key (``section.name``); a mesh file is relative to the working folder.
        defaults: values that a command has in place of the reference finger's; the file and the
            overrides take precedence.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    data: dict[str, Any] = {}
    if isinstance(file, Mapping):
        overrides = {**file, **overrides}
        file = None
    if file is not None:
        file = Path(file)
        data = tables.read(file)
        tables.anchor(data, file.parent)
    tables.put(data, defaults, replace=False)
    tables.put(data, overrides)
    tables.anchor(data, Path())
    config = from_dict(data)
    # with a mesh file, the table of another kind may say what the mesh was made of
    return followed(config, overrides) if config.geometry.of_file else config


def changed(config: Config, change: Change) -> Config:
    """Return a checked copy of a configuration with other values of some keys.

    Args:
        config: stays as it is.
        change: values by key (``section.name``); a table that is absent, as of an effect that is
            off, is added. Entries of a list are numbered from 0 in brackets.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    data = config.opened({tables.parts(key)[0] for key in change})
    tables.put(data, change)
    return followed(checked(type(config), data), change)


def followed(config: Config, change: Change) -> Config:
    """Return a configuration; refuse a change of dimensions that its mesh file does not follow.

    Args:
        config: with the change.
        change: values by key that someone asks for.

    Raises:
        ConfigError: one line naming the key and its value.
    """
    geometry, table = config.geometry, config.geometry_table
    # of another kind, commands take the outer dimensions from the table
    allowed = geometry.effort if geometry.of_file else ("kind", "length_mm", "width_mm", "depth_mm")
    # whoever names the file, too, tells what it is of
    stays = config.mesh.file is not None and "mesh.file" not in change
    for key, value in change.items() if stays else ():
        section, _, name = key.partition(".")
        if section == table and name and name not in allowed:
            raise ConfigError(
                f"{key} = {value}: a dimension of the solid in mesh.file, which stays as it is; "
                "allowed: draw it anew and adopt it"
            )
    return config


def from_dict(data: dict[str, Any]) -> Config:
    """Return the checked configuration of nested dictionaries, as in ``run.json``.

    Args:
        data: values by section and key; what is absent has its default.

    Raises:
        ConfigError: one line naming the key, its value and the allowed range.
    """
    return checked(Config, data)


def felt(
    config: Config | Mapping[str, Any], parts: Collection[Part] = EVERYWHERE
) -> dict[str, Any]:
    """Return the part of a configuration that a result depends on, as plain data.

    Equal results have equal data, so that its hash is a key of a store. Left out are sections and
    effects that no part feels, values that are absent, what only says how a solution is found, and
    the ramps where a protocol takes their place. A mesh file counts by its content.

    Args:
        config: of the simulation; or its plain data, which need not be checked.
        parts: of the experiment's rig (``Experiment.parts``).

    Returns:
        Values by section and key.

    Raises:
        ConfigError: one line, if the mesh file cannot be read.
    """
    plain = config.model_dump(mode="json") if isinstance(config, Config) else config
    counted = Config.counted(plain, parts)
    if counted["protocol"].get("time_s"):
        counted["experiment"] = {k: v for k, v in counted["experiment"].items() if k == "snaps"}
    for name in ("mesh", "obstacle"):
        if not (file := counted.get(name, {}).get("file")):
            continue
        try:
            counted[name]["file"] = hashlib.sha256(Path(file).read_bytes()).hexdigest()
        except OSError as error:
            raise ConfigError(f"{name}.file = {file}: {error.strerror}") from None
    return {name: values for name, values in counted.items() if values}
