"""A number of a configuration that can change: its unit, scale, prior and bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Final

import numpy as np
from pydantic import ConfigDict, TypeAdapter, ValidationError

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.extensions.effect import Prior
from dolfingrip.sections import errors
from dolfingrip.sections.section import Entry, Section

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
