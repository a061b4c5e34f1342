"""Intervals of readings, from what is not known exactly, by the derivatives of one run.

A reading y changes by c_k = Σ_m ∂y/∂m Δm_k at one standard deviation of number k, where Δm_k are
the changes of parameters (:mod:`dolfingrip.parameter.nuisances`). The numbers are independent, so
that a reading which is linear in them has the variance Σ_k c_k², beside that of its instrument.

The stiffness is the least known of them, and readings are not linear in it. But the run has solved
other stiffnesses as well: a softer body is the same body under more pressure, and its reading is
ψ(t) by the softness t (:mod:`dolfingrip.experiments.derivatives.softness`). A number counts as a
change κ_k of t as far as that explains what it changes of the readings that grow with the load.
The rest r_k = c_k − κ_k ψ'(0) counts as linear:

    y = ψ(Σ_k κ_k ζ_k) + Σ_k r_k ζ_k,   ζ_k independent standard normal numbers.

The ends of a band are quantiles of that. ψ is known in pressure control alone. Else all is linear.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np
from scipy.optimize import brentq
from scipy.special import ndtr

from dolfingrip.channels import CHANNELS, PRESSURE, of_band
from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments.derivatives.softness import ReadingAt, Softness
from dolfingrip.experiments.experiment import Experiment
from dolfingrip.experiments.results.readings import Row
from dolfingrip.parameter import every
from dolfingrip.parameter.nuisances import changes, known, neutral_stages, usual

if TYPE_CHECKING:
    from dolfingrip.experiments.result import Result

LEVEL: Final = 0.95
"""Probability that a reading is within its band."""

GRID: Final = np.linspace(-6.0, 6.0, 2401)
"""Values of a standard normal number."""

CHANCES: Final = np.exp(-(GRID**2) / 2) / np.exp(-(GRID**2) / 2).sum()
"""Their probabilities."""

LEAST: Final = 0.01
"""Part of a reading's variance below which what makes it is not named."""


@dataclass(frozen=True)
class Bands:
    """Standard deviations of numbers that a run depends on, and the changes of its readings.

    Attributes:
        experiment: that is run.
        config: of the run, with the regulator's gain and offset as parameters.
        spreads: standard deviations by key of :func:`~dolfingrip.parameter.nuisances.known`,
            by key of the configuration, or by column for the noise of its instrument.
    """

    experiment: Experiment
    config: Config
    spreads: Mapping[str, float]

    @classmethod
    def of(cls, experiment: Experiment, config: Config, stated: Mapping[str, Any]) -> Self:
        """Make the bands of a run.

        Args:
            experiment: that is run.
            config: with its settings.
            stated: standard deviations that replace the usual ones, or come beside them.

        Returns:
            The bands, with what the run feels.

        Raises:
            ConfigError: one line with a key that is nothing of this run, or a value that is no
                standard deviation.
        """
        neutral = config
        if cls(experiment, config, {})._pressurised:
            neutral = changed(config, neutral_stages(config))
        felt_keys = _felt(experiment, neutral)
        noisy = [channel.name for channel in CHANNELS.values() if channel.noise]
        for key, value in stated.items():
            number = isinstance(value, int | float) and not isinstance(value, bool)
            if not number or not 0 <= value < math.inf:
                raise ConfigError(f"--uncertain {key} = {value}: allowed: a number from 0 on")
            if key not in (*known(), *noisy, *felt_keys):
                allowed = ", ".join([*known(), *noisy])
                raise ConfigError(
                    f"--uncertain {key}: nothing of this run; allowed: {allowed}, or a number of "
                    "the configuration, as finger.wall_mm"
                )
        spreads = {key: float(std) for key, std in {**usual(), **stated}.items()}
        felt = {*cls(experiment, neutral, spreads).changes, *noisy}
        return cls(
            experiment, neutral, {key: std for key, std in spreads.items() if key in felt and std}
        )

    @cached_property
    def changes(self) -> dict[str, dict[str, float]]:
        """Changes of parameters at one standard deviation, by what is not known."""
        felt = _felt(self.experiment, self.config)
        by_spread = {k: changes(self.config, k, std) for k, std in self.spreads.items()}
        return {k: moves for k, moves in by_spread.items() if moves and felt.issuperset(moves)}

    @cached_property
    def _softening(self) -> dict[str, float]:
        """All moduli, the changes that double them; none where pressure is not all that moves."""
        softens = self._pressurised and not self.config.experiment.dynamic
        return changes(self.config, "modulus", 1.0) if softens else {}

    @property
    def _pressurised(self) -> bool:
        """Say if stops are pressures."""
        return self.experiment.control is PRESSURE and self.config.experiment.control == "pressure"

    def keys(self, further: Sequence[str] | None) -> tuple[str, ...]:
        """Return the parameters that readings are derived by.

        Args:
            further: what else is asked for; (): all; None: nothing.
        """
        if further is not None and not further:
            return ()
        band_keys = [key for moves in (*self.changes.values(), self._softening) for key in moves]
        return tuple(dict.fromkeys([*(further or ()), *band_keys]))

    def parts(self, column: str, slopes: Mapping[tuple[str, str], float]) -> dict[str, float]:
        """Return the change of a reading at one standard deviation of each number.

        Args:
            column: of the reading.
            slopes: derivatives at its row, by column and parameter.

        Returns:
            Changes in the column's unit, with the noise; empty where the reading has no derivative.
        """
        parts = {
            name: sum(slopes[column, key] * amount for key, amount in moves.items())
            for name, moves in self.changes.items()
            if all((column, key) in slopes for key in moves)
        }
        noise = {column: self.spreads[column]} if column in self.spreads else {}
        return {**parts, **noise} if parts else {}

    def ends(
        self, rows: Sequence[Row], entries: Iterable[Mapping[str, Any]], columns: Container[str]
    ) -> Row:
        """Return the ends of the bands of the last row.

        Args:
            rows: readings at all stops up to this one.
            entries: derivatives at these rows, as dictionaries of ``sensitivity.csv``.
            columns: that have a band.

        Returns:
            Both ends by column, in the readings' units.
        """
        row, before = rows[-1], self._before(rows)
        slopes = _by_row(entries, (len(rows) - 1, before))
        here = slopes[len(rows) - 1]
        parts = {column: self.parts(column, here) for column in dict.fromkeys(c for c, _ in here)
                 if column in row and column in columns}  # fmt: skip
        softer = {column: self._softer(column, rows, slopes, before) for column in parts}
        equal = self._equal(parts, softer, row)
        bands: Row = {}
        for column, effects in parts.items():
            if not math.isfinite(sum(effects.values())):
                continue
            if row[column] == 0:  # at rest, where instruments are zeroed; a force has a kink there
                effects = {key: part for key, part in effects.items() if key == column}
            ends = _ends(row[column], effects, equal, softer[column])
            bands |= dict(zip(of_band(column), ends, strict=True))
        return bands

    def _before(self, rows: Sequence[Row]) -> int | None:
        """The last stop at half the pressure of the last row, or less; None where there is none."""
        loads = np.array([row[self.experiment.control.name] for row in rows])
        lower = np.flatnonzero(np.abs(loads) <= abs(loads[-1]) / 2)
        return int(lower[-1]) if self._softening and lower.size and loads[-1] else None

    def _softer(
        self,
        column: str,
        rows: Sequence[Row],
        slopes: Mapping[int, Mapping[tuple[str, str], float]],
        before: int | None,
    ) -> Softness | None:
        """A reading by the softness; None where that is not known."""
        if before is None or column not in rows[before]:
            return None
        here, there = (
            ReadingAt(
                rows[i][self.experiment.control.name], rows[i][column],
                sum(slopes[i].get((column, key), math.nan) * amount
                    for key, amount in self._softening.items()),
            )
            for i in (len(rows) - 1, before)
        )  # fmt: skip
        if not math.isfinite(here.slope + here.value + there.value):
            return None
        proportion = column in CHANNELS and CHANNELS[column].in_proportion
        return Softness(here, there, in_proportion=proportion)

    def _equal(
        self,
        parts: Mapping[str, Mapping[str, float]],
        softer: Mapping[str, Softness | None],
        row: Row,
    ) -> dict[str, float]:
        """Softness that one standard deviation of each number is equal to, by least squares.

        It explains the relative changes of the readings that grow with the load.
        """
        relative = [
            (curve.slope / row[column], {key: part / row[column] for key, part in changes.items()})
            for column, changes in parts.items()
            if (curve := softer[column]) and column in CHANNELS and CHANNELS[column].grows
            if row[column]
        ]
        total = sum(slope**2 for slope, _ in relative)
        if not total:
            return {}
        return {
            key: sum(slope * changes[key] for slope, changes in relative if key in changes) / total
            for key in self.changes
        }


def _felt(experiment: Experiment, config: Config) -> set[str]:
    """Keys of the parameters that an experiment feels."""
    return {p.key for p in every(config) if p.section.felt_on(experiment.parts)}


def _ends(
    value: float, parts: Mapping[str, float], equal: Mapping[str, float], softer: Softness | None
) -> tuple[float, float]:
    """Ends of the band of a reading.

    Args:
        value: of the reading.
        parts: its changes at one standard deviation of each number.
        equal: softness that each number is equal to.
        softer: the reading by the softness; None: it is linear in all numbers.
    """
    residual = np.array(list(parts.values()))
    kappa = np.zeros_like(residual)
    if softer is not None:
        kappa += np.array([equal.get(key, 0.0) for key in parts])
        residual = residual - kappa * softer.slope
    size = float(np.linalg.norm(kappa))
    along = float(residual @ kappa) / size if size else 0.0
    across = max(float(residual @ residual) - along**2, 0.0)
    center = along * GRID + (value if softer is None else softer(size * GRID))
    # each node of the grid is as wide as their distance
    widths = np.sqrt(across + np.gradient(center) ** 2) + 1e-12 * abs(value)
    if not widths.any():
        return value, value
    reach = 8.0 * float(widths.max())

    def beyond(end: float, chance: float) -> float:
        return float(CHANCES @ ndtr((end - center) / widths)) - chance

    low, high = (
        brentq(beyond, center.min() - reach, center.max() + reach, args=(chance,))
        for chance in (0.5 - LEVEL / 2, 0.5 + LEVEL / 2)
    )
    return min(low, value), max(high, value)


def _by_row(
    entries: Iterable[Mapping[str, Any]], rows: Container[int | None]
) -> dict[int, dict[tuple[str, str], float]]:
    """Derivatives by row, and by column and parameter.

    Args:
        entries: as dictionaries of ``sensitivity.csv``.
        rows: that are looked for.
    """
    slopes: dict[int, dict[tuple[str, str], float]] = defaultdict(dict)
    for entry in entries:
        if entry["row"] in rows:
            place = entry["column"], entry["parameter"]
            slopes[entry["row"]][place] = float(entry["derivative"])
    return slopes


def band_sentences(experiment: Experiment, result: Result) -> list[str]:
    """Say the bands of an experiment's main readings at the highest load, and what makes them wide.

    Args:
        experiment: whose result it is.
        result: with its derivatives.

    Returns:
        A line for each curve of the experiment's plot; none where no bands were asked for.
    """
    spreads = result.facts.bands
    if not spreads or not result.rows:
        return []
    bands = Bands.of(experiment, result.config, spreads)
    sentences = []
    for curve in experiment.plot.curves:
        low, high = of_band(curve.column)
        if low not in result:
            continue
        row = int(np.nanargmax(np.abs(result.column(experiment.control.name))))
        parts = bands.parts(curve.column, _by_row(result.sensitivities, (row,))[row])
        variance = sum(part**2 for part in parts.values())
        if not variance:
            continue
        shares = sorted(((part**2 / variance, key) for key, part in parts.items()), reverse=True)
        most = ", ".join(f"{key} {100 * share:.0f} %" for share, key in shares if share >= LEAST)
        channel, ends = CHANNELS[curve.column], (result.column(low)[row], result.column(high)[row])
        load = float(result.column(experiment.control.name)[row])
        at_load = f"{load:g} {experiment.control.symbol}"
        sentences.append(
            f"{channel.title} at {at_load}: {channel.said(result.column(curve.column)[row])}, "
            f"{100 * LEVEL:.0f} % between {channel.said(ends[0])} and {channel.said(ends[1])}; "
            f"of its variance: {most}"
        )
    return sentences
