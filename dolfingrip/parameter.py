"""The numbers of a configuration that can change: each with unit, scale, prior and bounds.

What ``--set`` changes, a design varies, a derivative is taken to and a diagnosis estimates are the
same objects, found by the same keys: ``material.mu_MPa``, ``finger.wall_mm``,
``extensions.prony.g[0]``.
"""

from __future__ import annotations

import math
import re
import types
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Any, Final, Union, get_args, get_origin

import numpy as np
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from dolfingrip.config import Config, ConfigError, Film, Material, checked
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.sections import complaint, tables
from dolfingrip.sections.units import unit

STEP: Final = 1e-4
"""Part of a parameter's scale by which numbers of the configuration are differentiated. What they
determine is smooth, so the error of a central difference is 1e-8 of it."""

SECTIONS: Final = ("material", "film", "finger", "cast", "pneunet", "morph", "plate", "gravity",
                   "extensions")  # fmt: skip
"""Those whose numbers are properties of a finger, its set-up or its instruments."""

NUMERICAL: Final = ("plate.normal", "plate.contact_length_mm", "plate.barrier_mm",
                    "plate.stiffness_MPa", "gravity.direction")  # fmt: skip
"""Keys in these sections that are choices of the model, or have an effect of their own: gravity's
direction has gravity_pitch."""

SHAPES: Final = ("finger", "cast", "pneunet")
"""Those with dimensions, one for each kind of geometry."""

PRIORS: Final = {
    "material.mu_MPa": Prior(2.93, 0.6, "printed NinjaFlex; spread 20 %, engineering guess", True),
    "finger.wall_mm": Prior(1.6, 0.08, "walls within 5 %, engineering guess", True),
    "plate.gap_mm": Prior(0.3, 0.3, "engineering guess", True),
}
"""Priors of the simple model's own numbers, where anything is known."""


_FINITE: Final = ConfigDict(allow_inf_nan=False)


class Entry(StrEnum):
    """How a parameter enters a simulation."""

    CONSTANT = "constant of a term"
    SHAPE = "reference mesh"
    POSE = "pose of the plate"
    SUPPLY = "stage of the supply"
    INSTRUMENT = "instrument"
    CHOICE = "choice of the model"


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of a configuration.

    Attributes:
        key: ``section.name``, below ``extensions`` ``extensions.effect.name``; entries of a list
            are numbered from 0 in brackets.
        unit: that the key's name ends in; "" for a pure number.
        scale: an ordinary change of it, in its unit.
        prior: what is known before anything is measured, where anything is.
        low, high: bounds, infinite where there are none.
        entry: how it enters. A choice of the model has no derivative, only a difference of runs.
        integer: whether only whole numbers are meant.
        field: pydantic's description of the key, which it is checked by.
    """

    key: str
    unit: str
    scale: float
    prior: Prior | None
    low: float
    high: float
    entry: Entry
    integer: bool = False
    field: Any = None

    def check(self, value: float, option: str) -> None:
        """Raise where ``value`` is not allowed by itself.

        Raises:
            ConfigError: one line naming the option, the key, the value and the allowed range.
        """
        given = int(value) if float(value).is_integer() and abs(value) < 2**53 else value
        hint = self.field.annotation
        if self.field.metadata:
            hint = Annotated[(hint, *self.field.metadata)]
        try:
            TypeAdapter(hint, config=_FINITE).validate_python(given, strict=True)
        except ValidationError as error:
            kind, name = error.errors()[0]["type"], self.key.rpartition(".")[2]
            why = complaint.reason(kind, self.field, name)
            raise ConfigError(f"{option} {self.key} = {complaint.shown(given)}: {why}") from None

    def value(self, config: Config) -> float:
        """Its value in ``config``."""
        section, _, region = self.key.removesuffix(".nu").partition(".")
        if section == "material" and self.key.endswith(".nu"):  # which may be absent
            return config.material.of(region).poisson
        value: Any = config
        for part in _parts(self.key):
            value = value[part] if isinstance(part, int) else getattr(value, part)
        return float(value)

    def at(self, config: Config, value: float) -> Config:
        """``config`` with another value of it.

        Raises:
            ConfigError: one line naming the key, the value and the allowed range.
        """
        data = config.model_dump(exclude_none=True)
        *sections, last = _parts(self.key)
        place: Any = data
        for part in sections:
            if isinstance(place[part], tuple):
                place[part] = list(place[part])
            place = place[part]
        place[last] = value
        return checked(type(config), data)

    def stencil(self, config: Config, step: float) -> Sequence[tuple[int, float]]:
        """Places (in steps) and weights (by step) of a difference of second order.

        Central, or one-sided where a bound is near.
        """
        here = self.value(config)
        if here - step < math.nextafter(self.low, math.inf):
            return ((0, -1.5), (1, 2.0), (2, -0.5))
        if here + step > self.high:
            return ((0, 1.5), (-1, -2.0), (-2, 0.5))
        return ((1, 0.5), (-1, -0.5))

    def direction(self, config: Config) -> float:
        """Sign of its changes: 1, or −1 at the upper end of its range."""
        return 1.0 if self.value(config) + STEP * self.scale <= self.high else -1.0

    def derivative[T: (float, np.ndarray)](
        self, config: Config, function: Callable[[Config], T]
    ) -> T:
        """Derivative of a smooth function of the configuration, for each unit of the parameter."""
        here, step = self.value(config), STEP * self.scale
        terms = [
            weight / step * function(self.at(config, here + place * step) if place else config)
            for place, weight in self.stencil(config, step)
        ]
        return sum(terms[1:], start=terms[0])


def every(config: Config) -> list[Parameter]:
    """All parameters that ``config`` has: those of effects that are on, and the model's own."""
    found: list[Parameter] = []
    for section in SECTIONS:
        if section == "gravity" and not config.gravity.acceleration_m_s2:
            continue
        if section in SHAPES and section != config.geometry_table:
            continue
        if section == "extensions":
            for effect in config.extensions.active():
                found += _of_table(config, effect, f"extensions.{effect.name()}", effect)
        else:
            table = getattr(config, section)
            found += _of_table(config, table, section, None)
            for name, below in (table.model_extra or {}).items():
                found += _of_table(config, below, f"{section}.{name}", None)
    return found


def named(key: str, option: str = "--set") -> Parameter:
    """Any number of the configuration by its key, those of the model's own choices included.

    Args:
        key: ``section.name`` or ``extensions.effect.name``; the effect may be off.
        option: of the command that asks.

    Raises:
        ConfigError: one line naming ``option``, where there is no such number.
    """
    info = _field(key, option)
    kind = _bare(info.annotation)
    if kind not in (int, float):
        raise ConfigError(f"{option} {key}: no number; allowed: a number of the configuration")
    *sections, name = key.split(".")
    effect = next((each for each in EFFECTS if sections == ["extensions", each.name()]), None)
    low, high = _bounds(info.metadata)
    prior = effect.priors().get(name) if effect else PRIORS.get(key)
    scale = _scale(float(info.default or 0.0), prior)
    entry = _entry(sections[0], name, effect) if sections[0] in SECTIONS else Entry.CHOICE
    return Parameter(key, unit(name), scale, prior, low, high, entry, kind is int, info)


def check_assignment(assignment: str, option: str = "--set") -> None:
    """Check a number that ``section.key=value`` sets, as the parameter that it is.

    Texts, lists and tables are left to the configuration, which checks all of it together.

    Raises:
        ConfigError: one line naming the option, the key, the value and the allowed range.
    """
    key, value = tables.assigned(assignment, option)
    number = isinstance(value, int | float) and not isinstance(value, bool)
    if number and _bare(_field(key, option).annotation) in (int, float):
        named(key, option).check(value, option)


def _field(key: str, option: str) -> Any:
    """Pydantic's description of a key.

    Raises:
        ConfigError: one line naming ``option``, where there is no such key.
    """
    parts = key.split(".")
    info = None
    for i, part in enumerate(parts):
        known, entries = complaint.below(parts[:i], Config)
        if not known and entries is None:
            raise ConfigError(f"{option} {key}: {parts[i - 1]} is a value, not a section")
        info = known.get(part)
        chosen = entries is not None and i + 1 < len(parts)  # a table that a user named
        if info is None and not chosen:
            raise ConfigError(f"{option} {complaint.unknown(parts[: i + 1], Config)}")
    return info


def find(config: Config, keys: Sequence[str]) -> list[Parameter]:
    """The parameters of ``config`` by their keys; a key of a list means all of its entries.

    Raises:
        ConfigError: one line, where there is no such parameter.
    """
    known = {parameter.key: parameter for parameter in every(config)}
    found: list[Parameter] = []
    for key in keys:
        chosen = [p for name, p in known.items() if name == key or name.startswith(f"{key}[")]
        if not chosen:
            raise ConfigError(
                f"--parameters {key}: no parameter of this configuration; "
                f"allowed: {', '.join(known)}"
            )
        found += chosen
    return found


def bounds_of(table: type[BaseModel], key: str) -> tuple[float, float]:
    """Bounds of a number in a table, of each entry of a list; infinite where there are none."""
    info = table.model_fields[key]
    entries = _of_floats(info.annotation)
    return _bounds(_bounds_of_entries(info.annotation) if entries else info.metadata)


def _parts(key: str) -> list[str | int]:
    return [int(part) if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", key)]


def _of_table(
    config: Config, table: BaseModel, path: str, effect: Effect | None
) -> Iterator[Parameter]:
    for key, info in type(table).model_fields.items():
        if f"{path}.{key}" in NUMERICAL:
            continue
        if isinstance(table, Material) and key == "mu_MPa" and table.law != "neo-hooke":
            continue  # another law has numbers of its own
        value = getattr(table, key)
        if f"{path}.{key}" == "cast.cup_mm" and not value:
            continue  # without a cup there is no face that could move
        if isinstance(table, Film) and key == "fibre_deg" and config.mesh.half:
            continue  # turned alone, a family is no mirror image any more
        if isinstance(table, Material) and key == "nu" and table.bulk_MPa is None:
            value = table.poisson
        for name, number, metadata in _numbers(key, value, info):
            prior = effect.priors().get(key) if effect else PRIORS.get(f"{path}.{key}")
            low, high = _bounds(metadata)
            yield Parameter(
                f"{path}.{name}",
                unit(key),
                _scale(number, prior),
                prior,
                low,
                high,
                _entry(path.partition(".")[0], key, effect),
                field=info,
            )


def _numbers(key: str, value: Any, info: Any) -> Iterator[tuple[str, float, Sequence[Any]]]:
    """Name, value and bounds of each real number of a key."""
    if isinstance(value, float):
        yield key, value, info.metadata
    elif isinstance(value, tuple) and _of_floats(info.annotation):
        bounded = _bounds_of_entries(info.annotation)
        for i, number in enumerate(value):
            yield f"{key}[{i}]", float(number), bounded


def _bare(hint: Any) -> Any:
    if get_origin(hint) in (Union, types.UnionType):
        return next(part for part in get_args(hint) if part is not type(None))
    return hint


def _of_floats(hint: Any) -> bool:
    arguments = get_args(_bare(hint))
    first = arguments[0] if arguments else None
    return first is float or (get_origin(first) is Annotated and get_args(first)[0] is float)


def _entry_metadata(hint: Any) -> Sequence[Any]:
    first = get_args(_bare(hint))[0]
    return get_args(first)[1:] if get_origin(first) is Annotated else ()


def _bounds_of_entries(hint: Any) -> Sequence[Any]:
    return [item for field in _entry_metadata(hint) for item in getattr(field, "metadata", [field])]


def _bounds(metadata: Sequence[Any]) -> tuple[float, float]:
    """Pydantic's bounds; an open one is taken for a closed one."""

    def limits(*names: str) -> list[float]:
        found = (getattr(item, name, None) for item in metadata for name in names)
        return [float(limit) for limit in found if limit is not None]

    return max(limits("gt", "ge"), default=-math.inf), min(limits("lt", "le"), default=math.inf)


def _scale(value: float, prior: Prior | None) -> float:
    """An ordinary change: the prior's spread, else a tenth of the value."""
    if prior is not None:
        return prior.spread
    return 0.1 * abs(value) or 1.0


def _entry(section: str, key: str, effect: Effect | type[Effect] | None) -> Entry:
    if effect is None:
        return {
            **dict.fromkeys((*SHAPES, "morph"), Entry.SHAPE),
            "plate": Entry.POSE if key in ("gap_mm", "tilt_deg") else Entry.CONSTANT,
        }.get(section, Entry.CONSTANT)
    if effect.kind == "numerical":
        return Entry.CHOICE
    if effect.has("outlet_kPa"):
        return Entry.SUPPLY
    if effect.has("reading"):
        return Entry.INSTRUMENT
    if effect.kind == "geometry":
        return Entry.SHAPE
    if effect.has("adapt") and effect.name().startswith("plate"):
        return Entry.POSE
    return Entry.CONSTANT
