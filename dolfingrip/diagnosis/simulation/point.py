"""Numbers of a hypothesis that a simulation is of, and what they change of a configuration."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dolfingrip import parameter
from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.core.unknown import Cause, Unknown


@dataclass(frozen=True, eq=False)
class Point:
    """Numbers that a simulation is of.

    Attributes:
        factor: of all moduli.
        zeta: of it.
        own: further numbers of the body and the rig, with ζ of each.
        causes: that act, with ζ of their numbers, shape (d,) each.
    """

    factor: Unknown
    zeta: float
    own: tuple[tuple[Unknown, float], ...] = ()
    causes: tuple[tuple[Cause, np.ndarray], ...] = ()

    @classmethod
    def of(
        cls, numbers: Sequence[Unknown], zeta: Sequence[float] | np.ndarray,
        causes: Sequence[tuple[Cause, np.ndarray]] = (),
    ) -> Point:  # fmt: skip
        """Return the point of the model's own numbers, the factor first, and of causes."""
        factor, *others = zip(numbers, map(float, zeta), strict=False)
        return cls(*factor, tuple(others), tuple(causes))

    @property
    def moduli(self) -> float:
        """Factor of all moduli, by those configured."""
        return float(self.factor.at(self.zeta))

    @property
    def numbers(self) -> Iterator[tuple[Unknown, float]]:
        """All numbers but the factor, and ζ of each, in the order of a hypothesis."""
        yield from self.own
        for cause, zeta in self.causes:
            yield from zip(cause.numbers, map(float, zeta), strict=True)

    @property
    def u(self) -> np.ndarray:
        """Coordinates of all numbers, shape (1, 1 + d)."""
        every = [(self.factor, self.zeta), *self.numbers]
        return np.array([[float(n.coordinate(np.array(zeta))[0]) for n, zeta in every]])

    def rates(self) -> np.ndarray:
        """Derivatives of ln c, and of what is configured, by the coordinates, shape (1 + d,)."""
        c = self.moduli
        rates = [self.factor.coordinate_of(c)[1] / c]
        for number, zeta in self.numbers:
            rate = number.coordinate_of(float(number.at(zeta)))[1]
            rates.append(rate * (c if number.modulus else 1.0))
        return np.array(rates)

    def change(self, config: Config) -> Change:
        """Return the change of a configuration to these numbers.

        Args:
            config: whose moduli are scaled.
        """
        c = self.moduli
        change: dict[str, Any] = {**scaled_moduli(config, c)}
        for number, zeta in self.own:
            change |= number.change(float(number.at(zeta)) * (c if number.modulus else 1.0))
        for cause, zetas in self.causes:
            change |= cause.overrides(zetas, c)
        return change


def scaled_moduli(config: Config, factor: float) -> dict[str, float]:
    """Return the change that makes all moduli ``factor`` times as large, contacts' stiffness too.

    Args:
        config: whose moduli they are.
        factor: above 0; 1 changes nothing.
    """
    if factor == 1.0:
        return {}
    return {
        **parameter.scaled(config, factor),
        "contact.stiffness_MPa": config.contact.stiffness_MPa * factor,
        "plate.stiffness_MPa": config.plate.stiffness_MPa * factor,
    }
