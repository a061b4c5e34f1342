"""A simulator of a measurement: readings at the numbers of any hypothesis, with derivatives.

Coupons are simulated in closed form, fingers by requests to a store. A simulator knows nothing of
inference.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from dolfingrip import parameter
from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.unknown import Cause, Nuisance, Unknown
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.simulation.simulated import SimulatedReadings, SimulationGroup


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


class Simulator(Protocol):
    """Simulates a measurement.

    Attributes:
        measurement: what is simulated.
        config: the model as configured.
        closed_form: whether a simulation costs nothing.
        not_reached: tests with readings that the model does not reach, which are left out, and why.
    """

    measurement: Measurement
    config: Config
    not_reached: Sequence[str]
    closed_form: ClassVar[bool]

    @property
    def at_once(self) -> int:
        """Simulations that are made side by side."""

    @property
    def groups(self) -> Sequence[SimulationGroup]:
        """Tests that are simulated together."""

    @property
    def base(self) -> SimulatedReadings:
        """The model without causes."""

    @property
    def configured(self) -> np.ndarray:
        """(n,) readings of the model as configured; NaN where it does not come so far."""

    @property
    def rig(self) -> Sequence[Nuisance]:
        """Numbers of rig and body that readings are linear in."""

    @property
    def mesh(self) -> np.ndarray:
        """(n,) what the mesh may get wrong, one standard deviation with its sign."""

    def at(self, points: Sequence[Point]) -> list[Tangents | None]:
        """Simulate the model at other numbers.

        Args:
            points: the numbers.

        Returns:
            Readings and derivatives of each; None where a simulation does not reach all readings.
        """

    def plain(self, point: Point) -> Tangents:
        """Simulate the model without causes, at its start."""

    def resting(self, causes: Sequence[Cause], start: Point) -> dict[str, Tangents] | None:
        """Simulate causes where they do nothing: derivatives by the amplitudes of each.

        Args:
            causes: that are smooth there.
            start: the model's own numbers.

        Returns:
            By the name of each cause that is felt; None where no such simulation tells them.
        """

    def free(self, point: Point) -> Point | None:
        """Return a point of the same causes that costs nothing; None where there is none."""

    def additions(
        self, points: Sequence[Point], measurements: Sequence[Measurement], *, known_mesh: bool
    ) -> list[tuple[list[Tangents | None], Sequence[Nuisance]]]:
        """Simulate other measurements of the same model, made later by the same rig.

        Args:
            points: the numbers.
            measurements: what is simulated.
            known_mesh: whether on the mesh of the fits; else on the one that costs least.

        Returns:
            Of each measurement what :meth:`at` returns, and what the rig's numbers change about it,
            but for those that are set anew.
        """


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
