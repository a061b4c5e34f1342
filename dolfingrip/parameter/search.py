"""The parameters of a configuration: what a parameter is, all of them, or one by its key.

``--set``, designs, derivatives and diagnoses all use these objects and find them by the same keys:
``material.mu_MPa``, ``finger.wall_mm``, ``extensions.prony.g[0]``. Pressures at equal angles, and
forces, are proportional to the moduli:

>>> moduli(Config())
{'material.mu_MPa': 2.93}
>>> scaled(Config(), 2.0)
{'material.mu_MPa': 5.86}
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Final

import numpy as np
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError

from dolfingrip.config import Change, Config, ConfigError, Film, Material, changed
from dolfingrip.extensions.effect import Effect, Prior
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.sections import errors
from dolfingrip.sections.errors import bare
from dolfingrip.sections.section import Entry, Role, Section
from dolfingrip.sections.units import unit

STEP: Final = 1e-4
"""Step of differences by a parameter, as a part of its scale. Functions of the configuration are
smooth, so a central difference has a relative error of 1e-8."""

_FINITE: Final = ConfigDict(allow_inf_nan=False)


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of a configuration.

    Attributes:
        key: ``section.name``, below ``extensions`` ``extensions.effect.name``; entries of a list
            are numbered from 0 in brackets.
        unit: unit that the key's name ends in; "" for a pure number.
        scale: an ordinary change of it, in its unit.
        prior: knowledge before anything is measured; None if there is none.
        low, high: bounds; infinite if there are none.
        section: class of the table that it stands in.
        integer: whether only whole numbers are allowed.
        field: pydantic's description of the key, which checks values.
    """

    key: str
    unit: str
    scale: float
    prior: Prior | None
    low: float
    high: float
    section: type[Section]
    integer: bool = False
    field: Any = None

    @property
    def entry(self) -> Entry:
        """How it enters; a choice of the model has no derivative, but a difference of two runs."""
        return self.section.entry_of(self._name)

    @property
    def is_modulus(self) -> bool:
        """True if the number is in proportion to the stiffness of the material."""
        return self.section.is_modulus(self._name)

    @property
    def _name(self) -> str:
        """Name in its section, without the number of an entry."""
        return self.key.rpartition(".")[2].partition("[")[0]

    def check(self, value: float, option: str) -> None:
        """Raise if ``value`` is out of the parameter's range.

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
            why = errors.reason(kind, self.field, name)
            raise ConfigError(f"{option} {self.key} = {errors.shown(given)}: {why}") from None

    def value(self, config: Config) -> float:
        """Return the parameter's value in ``config``."""
        section, _, key = self.key.partition(".")
        table: Section = getattr(config, section)
        return table.number_at(key)

    def at(self, config: Config, value: float) -> Config:
        """``config`` with another value of the parameter.

        Raises:
            ConfigError: one line naming the key, the value and the allowed range.
        """
        return changed(config, {self.key: value})

    def stencil(self, config: Config, step: float) -> Sequence[tuple[int, float]]:
        """Places (in steps) and weights (for a step of 1) of a difference of second order.

        The difference is central, or one-sided if a bound is near.
        """
        here = self.value(config)
        if here - step < math.nextafter(self.low, math.inf):
            return ((0, -1.5), (1, 2.0), (2, -0.5))
        if here + step > self.high:
            return ((0, 1.5), (-1, -2.0), (-2, 0.5))
        return ((1, 0.5), (-1, -0.5))

    def direction(self, config: Config) -> float:
        """Sign of a change that stays in the range: 1, or −1 at the upper end."""
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


PRINTED_MPa: Final = 2.93
"""Shear modulus of printed NinjaFlex; the effects' priors of moduli are valid for it."""


def scaled_priors(effect: type[Effect], shear_MPa: float) -> dict[str, Prior]:
    """Prior of each parameter that has one; priors of moduli are in proportion to the material's.

    Args:
        effect: an effect of the index.
        shear_MPa: the material's initial shear modulus.
    """
    factor = shear_MPa / PRINTED_MPa
    return {
        key: replace(prior, mean=factor * prior.mean, spread=factor * prior.spread)
        if effect.is_modulus(key)
        else prior
        for key, prior in effect.priors().items()
    }


PRIORS: Final = {
    "material.mu_MPa": Prior(2.93, 0.6, "printed NinjaFlex; spread 20 %, engineering guess", True),
    "finger.wall_mm": Prior(1.6, 0.08, "walls within 5 %, engineering guess", True),
    "plate.gap_mm": Prior(0.3, 0.3, "engineering guess", True),
}
"""Priors of the simple model's own numbers that something is known of."""


def every(config: Config) -> list[Parameter]:
    """Return all parameters of ``config``: the model's own, and those of effects that are on.

    Args:
        config: whose numbers they are.
    """
    parameters: list[Parameter] = []
    for name, table in config.tables.items():
        parameters += _of_table(config, table, name)
        for key, below in table.inner.items():
            parameters += _of_table(config, below, f"{name}.{key}")
    return parameters


def named(key: str, option: str = "--set") -> Parameter:
    """Return any number of the configuration as a parameter, choices of the model included.

    Args:
        key: ``section.name`` or ``extensions.effect.name``; the effect may be off.
        option: option of the command that asks.

    Raises:
        ConfigError: one line naming ``option``, where there is no such number.
    """
    info = _field(key, option)
    kind = bare(info.annotation)
    if kind not in (int, float):
        raise ConfigError(f"{option} {key}: no number; allowed: a number of the configuration")
    *sections, name = key.split(".")
    effect = next((effect for effect in EFFECTS if sections == ["extensions", effect.name()]), None)
    prior = effect.priors().get(name) if effect else PRIORS.get(key)
    scale, limits = _scale(float(info.default or 0.0), prior), _bounds(info.metadata)
    (section, *_) = (kind for kind in errors.kinds(sections, Config) if name in kind.model_fields)
    return Parameter(key, unit(name), scale, prior, *limits, section, kind is int, info)


def check(change: Change, option: str = "--set") -> None:
    """Check the numbers of a change as parameters.

    Texts, lists and tables are not checked here; the configuration checks them.

    Args:
        change: values by key.
        option: option of the command that asks.

    Raises:
        ConfigError: one line naming the option, the key, the value and the allowed range.
    """
    for key, value in change.items():
        number = isinstance(value, int | float) and not isinstance(value, bool)
        if number and bare(_field(key, option).annotation) in (int, float):
            named(key, option).check(value, option)


def _field(key: str, option: str) -> Any:
    """Pydantic's description of a key.

    Raises:
        ConfigError: one line naming ``option``, where there is no such key.
    """
    parts = key.split(".")
    info = None
    for i, part in enumerate(parts):
        fields = errors.fields(parts[:i], Config)
        tables = any(getattr(kind, "entries", None) for kind in errors.kinds(parts[:i], Config))
        if not fields and not tables:
            raise ConfigError(f"{option} {key}: {parts[i - 1]} is a value, not a section")
        info = fields.get(part)
        chosen = tables and i + 1 < len(parts)  # a table whose name a user chose
        if info is None and not chosen:
            raise ConfigError(f"{option} {errors.unknown(parts[: i + 1], Config)}")
    return info


def find(config: Config, keys: Sequence[str]) -> list[Parameter]:
    """Return the parameters of ``config`` with some keys.

    Args:
        config: whose numbers they are.
        keys: of the parameters; the key of a list means all of its entries.

    Raises:
        ConfigError: one line, if there is no such parameter.
    """
    by_key = {parameter.key: parameter for parameter in every(config)}
    parameters: list[Parameter] = []
    for key in keys:
        chosen = [p for name, p in by_key.items() if name == key or name.startswith(f"{key}[")]
        chosen = chosen or _of_chamber(config, key)
        if not chosen:
            raise ConfigError(
                f"--parameters {key}: no parameter of this configuration; "
                f"allowed: {', '.join(by_key)}"
            )
        parameters += chosen
    return parameters


def _of_chamber(config: Config, key: str) -> list[Parameter]:
    """The dimension of a single chamber that has none of its own yet, which then is its own."""
    table, _, inner = key.partition(".")
    if table != config.geometry_table or not inner.startswith("override."):
        return []
    named(key, "--parameters")
    single = changed(config, {key: getattr(config.geometry, key.rpartition(".")[2])})
    return [parameter for parameter in every(single) if parameter.key == key]


def _of_table(config: Config, table: Section, path: str) -> Iterator[Parameter]:
    effect = type(table) if isinstance(table, Effect) else None
    priors = scaled_priors(effect, config.material.shear_MPa) if effect else {}
    for key, info in type(table).model_fields.items():
        if table.entry_of(key) is Entry.CHOICE and effect is None:
            continue
        value = getattr(table, key)
        if not table.movable(key):
            continue
        if isinstance(table, Film) and key == "fibre_deg" and config.mesh.half:
            continue  # turned alone, a family is no mirror image any more
        if isinstance(table, Material) and key == "nu" and table.bulk_MPa is None:
            value = table.poisson
        prior = priors.get(key) if effect else PRIORS.get(f"{path}.{key}")
        for name, number, metadata in _numbers(key, value, info):
            scale, limits = _scale(number, prior), _bounds(metadata)
            yield Parameter(
                f"{path}.{name}", unit(key), scale, prior, *limits, type(table), field=info
            )


def _numbers(key: str, value: Any, info: Any) -> Iterator[tuple[str, float, Sequence[Any]]]:
    """Name, value and bounds of each real number of a key."""
    if isinstance(value, float):
        yield key, value, info.metadata
    elif isinstance(value, tuple) and errors.entry_of(info.annotation)[0] is float:
        bounded = errors.entry_of(info.annotation)[1]
        for i, number in enumerate(value):
            yield f"{key}[{i}]", float(number), bounded


def _scale(value: float, prior: Prior | None) -> float:
    """An ordinary change: the prior's standard deviation, else a tenth of the value."""
    if prior is not None:
        return prior.spread
    return 0.1 * abs(value) or 1.0


def bounds_of(table: type[BaseModel], key: str) -> tuple[float, float]:
    """Return lower and upper bound of a number, or of a list's entries; infinite if there is none.

    Args:
        table: class of a section.
        key: of the number or list.
    """
    info = table.model_fields[key]
    entry, bounded = errors.entry_of(info.annotation)
    return _bounds(bounded if entry is float else info.metadata)


def _bounds(metadata: Sequence[Any]) -> tuple[float, float]:
    """Pydantic's bounds; open bounds are taken for closed ones."""

    def limits(*names: str) -> list[float]:
        bounds = (getattr(item, name, None) for item in metadata for name in names)
        return [float(limit) for limit in bounds if limit is not None]

    return max(limits("gt", "ge"), default=-math.inf), min(limits("lt", "le"), default=math.inf)


Modulus = float | tuple[float, ...]


def moduli(config: Config) -> dict[str, Modulus]:
    """Return moduli by key (MPa; N/mm of films): of the material, of regions and of films.

    A bulk modulus is among them if it is given. Moduli of effects and contacts are not.

    Args:
        config: of the finger, or of a coupon.
    """
    bodies = {name: body for name, body in config.tables.items() if body.role is Role.BODY}
    inner = {f"{n}.{key}": t for n, body in bodies.items() for key, t in body.inner.items()}
    return {
        f"{path}.{key}": value
        for path, table in (bodies | inner).items()
        for key in type(table).model_fields
        if table.is_modulus(key) and table.movable(key)
        if (value := getattr(table, key)) not in (None, (), 0.0)
    }


def scaled(config: Config, factor: float) -> Change:
    """Return the change that makes all moduli ``factor`` times as large.

    Args:
        config: whose moduli they are.
        factor: above 0.
    """
    return {
        key: [factor * modulus for modulus in value] if isinstance(value, tuple) else factor * value
        for key, value in moduli(config).items()
    }
