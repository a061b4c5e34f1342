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
from pydantic import BaseModel, TypeAdapter, ValidationError

from dolfingrip.config import Config, ConfigError, Film, Material, checked
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.sections import complaint
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
        whole = self.integer and float(value).is_integer()
        hint = self.field.annotation
        if self.field.metadata:
            hint = Annotated[(hint, *self.field.metadata)]
        try:
            TypeAdapter(hint).validate_python(int(value) if whole else value, strict=True)
        except ValidationError:
            allowed = complaint.bounds(self.field, self.key.rpartition(".")[2]) or "a number"
            raise ConfigError(f"{option} {self.key} = {value:g}: allowed: {allowed}") from None

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

    def way(self, config: Config) -> float:
        """The way in which it may change: 1, or −1 at the upper end of its range."""
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

    Raises:
        ConfigError: one line naming ``option``, where there is no such number.
    """
    section, _, name = key.partition(".")
    info = Config.model_fields.get(section)
    table = _bare(info.annotation) if info is not None else None
    below, _, last = name.rpartition(".")
    entries = getattr(table, "entries", None)
    if below and entries is not None:
        table, name = entries, last
    fields = getattr(table, "model_fields", {})
    allowed = "allowed: a number of the configuration"
    if name not in fields:
        raise ConfigError(f"{option} {key}: unknown key; {allowed}")
    kind = _bare(fields[name].annotation)
    if kind not in (int, float):
        raise ConfigError(f"{option} {key}: no number; {allowed}")
    low, high = _bounds(fields[name].metadata)
    prior = PRIORS.get(key)
    scale = _scale(float(fields[name].default or 0.0), prior)
    entry = _entry(section, name, None) if section in SECTIONS else Entry.CHOICE
    return Parameter(key, unit(name), scale, prior, low, high, entry, kind is int, fields[name])


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


def _parts(key: str) -> list[str | int]:
    return [int(part) if part.isdigit() else part for part in re.findall(r"[^.\[\]]+", key)]


def _of_table(
    config: Config, table: BaseModel, path: str, effect: Effect | None
) -> Iterator[Parameter]:
    for key, info in type(table).model_fields.items():
        if f"{path}.{key}" in NUMERICAL:
            continue
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
        bounded = [
            item
            for field in _entry_metadata(info.annotation)
            for item in getattr(field, "metadata", [field])
        ]
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


def _entry(section: str, key: str, effect: Effect | None) -> Entry:
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
