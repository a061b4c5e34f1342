"""Intervals of readings, from what is not known exactly, by the derivatives of one run.

A reading y changes by c_k = Σ_m ∂y/∂m Δm_k at one standard deviation of number k, where Δm_k are
the changes of parameters (:mod:`dolfingrip.parameter.nuisances`). The numbers are independent, so
that an interval of y reaches from

    y − √(Σ_k (z c_k)² + (z σ_n)²)   to   y + √(Σ_k (z c_k)² + (z σ_n)²),

with σ_n the noise of the instrument that reads it. That is exact where y is linear in the numbers.

The stiffness is a factor exp(s ζ) of all moduli and the least known of them. An angle grows about
as a power of the pressure by the moduli, y ∝ exp(t ζ) with t = c_k / y, so that its own part is
y (exp(z t) − 1) upwards and y (1 − exp(−z t)) downwards. Where a reading has just begun to grow, as
a force at the first touch, t is large and y no such power: what exp(z t) adds to 1 + z t counts up
to z t = 1.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from dolfingrip.channels import CHANNELS, PRESSURE, of_band
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.results.readings import Row
from dolfingrip.parameter import every
from dolfingrip.parameter.nuisances import NUISANCES, STIFFNESSES, USUAL, changes, neutral_stages

if TYPE_CHECKING:
    from dolfingrip.experiments.result import Result

LEVEL: Final = 0.95
"""Probability that a reading is within its band."""

WIDTH: Final = 1.959964
"""Half of that band by the standard deviation of a normal number."""

LEAST: Final = 0.01
"""Part of a reading's variance below which what makes it is not named."""


@dataclass(frozen=True)
class Bands:
    """Standard deviations of numbers that a run depends on, and the changes of its readings.

    Attributes:
        experiment: that is run.
        config: of the run, with the regulator's gain and offset as parameters.
        spreads: standard deviations by key of :data:`~dolfingrip.parameter.nuisances.NUISANCES`,
            by key of the configuration, or by column for the noise of its instrument.
    """

    experiment: Experiment
    config: Config
    spreads: Mapping[str, float]

    @classmethod
    def of(cls, experiment: Experiment, config: Config, told: Mapping[str, Any]) -> Self:
        """Make the bands of a run.

        Args:
            experiment: that is run.
            config: with its settings.
            told: standard deviations that replace the usual ones, or come beside them.

        Returns:
            The bands, with what the run feels.

        Raises:
            ConfigError: one line with a key that is nothing of this run, or a value that is no
                standard deviation.
        """
        pressurised = experiment.control is PRESSURE and config.experiment.control == "pressure"
        own = changed(config, neutral_stages(config)) if pressurised else config
        known = _felt(experiment, own)
        noisy = [each.name for each in CHANNELS.values() if each.noise]
        for key, value in told.items():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value < math.inf:
                raise ConfigError(f"--uncertain {key} = {value}: allowed: a number from 0 on")
            if key not in (*NUISANCES, *noisy, *known):
                allowed = ", ".join([*NUISANCES, *noisy])
                raise ConfigError(
                    f"--uncertain {key}: nothing of this run; allowed: {allowed}, or a number of "
                    "the configuration, as finger.wall_mm"
                )
        spreads = {key: float(std) for key, std in {**USUAL, **told}.items()}
        felt = {*cls(experiment, own, spreads).changes, *noisy}
        return cls(
            experiment, own, {key: std for key, std in spreads.items() if key in felt and std}
        )

    @cached_property
    def changes(self) -> dict[str, dict[str, float]]:
        """Changes of parameters at one standard deviation, by what is not known."""
        known = _felt(self.experiment, self.config)
        each = {k: changes(self.config, k, std) for k, std in self.spreads.items()}
        return {k: found for k, found in each.items() if found and known.issuperset(found)}

    def keys(self, further: Sequence[str] | None) -> tuple[str, ...]:
        """Return the parameters that readings are derived by.

        Args:
            further: what else is asked for; (): all; None: nothing.
        """
        if further is not None and not further:
            return ()
        own = [key for found in self.changes.values() for key in found]
        return tuple(dict.fromkeys([*(further or ()), *own]))

    def parts(self, column: str, slopes: Mapping[tuple[str, str], float]) -> dict[str, float]:
        """Return the change of a reading at one standard deviation of each number.

        Args:
            column: of the reading.
            slopes: derivatives at its row, by column and parameter.

        Returns:
            Changes in the column's unit, with the noise; empty where the reading has no derivative.
        """
        found = {
            name: sum(slopes[column, key] * amount for key, amount in own.items())
            for name, own in self.changes.items()
            if all((column, key) in slopes for key in own)
        }
        noise = {column: self.spreads[column]} if column in self.spreads else {}
        return {**found, **noise} if found else {}

    def ends(self, row: Row, entries: Iterable[Mapping[str, Any]], columns: Container[str]) -> Row:
        """Return the ends of the bands of a row.

        Args:
            row: readings.
            entries: derivatives at this row, as dictionaries of ``sensitivity.csv``.
            columns: that have a band.

        Returns:
            Both ends by column, in the readings' units.
        """
        slopes = by_column_and_parameter(entries)
        found: Row = {}
        for column in dict.fromkeys(name for name, _ in slopes):
            parts = self.parts(column, slopes)
            if column not in row or column not in columns or not math.isfinite(sum(parts.values())):
                continue
            value = row[column]
            if value == 0:  # at rest, where instruments are zeroed; a force has a kink there
                parts = {key: part for key, part in parts.items() if key == column}
            grows = column in CHANNELS and CHANNELS[column].grows
            down, up = (
                math.hypot(
                    *(
                        _of_power(WIDTH * part, value, side)
                        if grows and key in STIFFNESSES
                        else WIDTH * part
                        for key, part in parts.items()
                    )
                )
                for side in (-1.0, 1.0)
            )
            if value < 0:
                down, up = up, down
            found |= dict(zip(of_band(column), (value - down, value + up), strict=True))
        return found


def _felt(experiment: Experiment, config: Config) -> set[str]:
    """Keys of the parameters that an experiment feels."""
    return {each.key for each in every(config) if each.section.felt_on(experiment.parts)}


def _of_power(change: float, value: float, side: float) -> float:
    """How far a reading moves away from zero (side 1) or towards it, by its change to first order.

    Args:
        change: at the width of the band.
        value: of the reading.
        side: 1 or −1.
    """
    t = abs(change / value) if value else math.inf
    if side < 0:
        return -abs(value) * math.expm1(-t)
    return abs(change) + abs(value) * (math.expm1(min(t, 1.0)) - min(t, 1.0))


def by_column_and_parameter(entries: Iterable[Mapping[str, Any]]) -> dict[tuple[str, str], float]:
    """Return the derivatives of one row by column and parameter.

    Args:
        entries: as dictionaries of ``sensitivity.csv``.
    """
    return {(each["column"], each["parameter"]): float(each["derivative"]) for each in entries}


def band_sentences(experiment: Experiment, result: Result) -> list[str]:
    """Say the bands of an experiment's main readings at the highest load, and what makes them wide.

    Args:
        experiment: whose result it is.
        result: with its derivatives.

    Returns:
        A line for each curve of the experiment's plot; none where no bands were asked for.
    """
    told = result.facts.bands
    if not told or not result.rows:
        return []
    bands = Bands.of(experiment, result.config, told)
    found = []
    for curve in experiment.plot.curves:
        low, high = of_band(curve.column)
        if low not in result:
            continue
        row = int(np.nanargmax(np.abs(result.column(experiment.control.name))))
        at = [each for each in result.sensitivities if each["row"] == row]
        parts = bands.parts(curve.column, by_column_and_parameter(at))
        whole = sum(part**2 for part in parts.values())
        if not whole:
            continue
        shares = sorted(((part**2 / whole, key) for key, part in parts.items()), reverse=True)
        most = ", ".join(f"{key} {100 * share:.0f} %" for share, key in shares if share >= LEAST)
        channel, ends = CHANNELS[curve.column], (result.column(low)[row], result.column(high)[row])
        load = float(result.column(experiment.control.name)[row])
        at_load = f"{load:g} {experiment.control.symbol}"
        found.append(
            f"{channel.title} at {at_load}: {channel.said(result.column(curve.column)[row])}, "
            f"{100 * LEVEL:.0f} % between {channel.said(ends[0])} and {channel.said(ends[1])}; "
            f"of its variance: {most}"
        )
    return found
