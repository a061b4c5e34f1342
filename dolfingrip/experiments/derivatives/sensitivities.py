"""Derivatives of every reading at every stop by parameters of the configuration.

A choice of the model has no derivative, but the difference of two runs.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.results.readings import Row
from dolfingrip.experiments.results.sensitivity_table import COLUMNS
from dolfingrip.mechanics.newton.callbacks import callback
from dolfingrip.mechanics.sensitivity.forward import CHANGE, ForwardSensitivity
from dolfingrip.parameter import Entry, Parameter, every, find

NUMERICAL = tuple(
    f"extensions.{effect.name()}"
    for effect in type(Config().extensions).effects
    if effect.kind == "numerical"
)
"""Keys of all choices: tables of effects that describe the computation and not the finger."""


@dataclass(frozen=True, slots=True)
class Choice:
    """A choice of the model, made in a configuration or not.

    Attributes:
        key: key of its table in the configuration.
        made: whether the configuration has that table.
        other: the configuration with the choice made the other way.
    """

    key: str
    made: bool
    other: Config

    @property
    def label(self) -> str:
        """Name of the choice in the column ``parameter`` of ``sensitivity.csv``."""
        return f"{self.key} (with minus without)"

    def difference(self, here: float, there: float) -> float:
        """Reading with the choice minus reading without it.

        Args:
            here: a reading of the configuration's run.
            there: this reading in the run of :attr:`other`.
        """
        return here - there if self.made else there - here

    def differences(
        self, here: Sequence[Row], there: Sequence[Row], columns: Sequence[str]
    ) -> list[Row]:
        """Rows of ``sensitivity.csv`` for the stops that both runs reached.

        Args:
            here: rows of the configuration's run.
            there: rows of the run of :attr:`other`.
            columns: names of the rows that are made.
        """
        rows: list[Row] = []
        for i, (first, second) in enumerate(zip(here, there, strict=False)):
            for name, value in first.items():
                if name == "time_s" or not isinstance(value, float):
                    continue
                apart = self.difference(value, second[name])
                if math.isfinite(apart):
                    rows.append(dict(zip(columns, (i, name, self.label, apart), strict=True)))
        return rows


def choices(config: Config, keys: Sequence[str] | None) -> list[Choice]:
    """Return the choices of the model among the keys that derivatives are asked for.

    A choice that ``config`` does not make is made with its default values.

    Args:
        config: that the choices are made or not made in.
        keys: of parameters and choices; None: none.

    Raises:
        ConfigError: one line, where a choice cannot be made with the rest of ``config``.
    """
    selected = []
    for key in dict.fromkeys(keys or ()):
        if key not in NUMERICAL:
            continue
        name = key.partition(".")[2]
        made = getattr(config.extensions, name) is not None
        other = config.changed(extensions={name: None if made else {}})
        other.adapted()  # raises where the choice does not go with the rest
        selected.append(Choice(key, made, other))
    return selected


if TYPE_CHECKING:
    from dolfingrip.experiments.rigs.rig import Rig


def chosen(config: Config, keys: Sequence[str] | None) -> list[Parameter]:
    """Return the parameters that readings are derived by.

    Keys of whole choices of the model are left out; they are in
    :mod:`dolfingrip.experiments.derivatives.sensitivities`.

    Args:
        config: of the simulation.
        keys: of parameters and choices; none, or None: all parameters.

    Raises:
        ConfigError: one line: an unknown key, a number of a choice of the model, or volume
            control with gravity.
    """
    numbers = [key for key in keys or () if key not in NUMERICAL]
    if keys and not numbers:
        return []
    if config.experiment.control == "auto":
        raise ConfigError(
            'experiment.control = "auto": allowed: "pressure" or "volume" with --gradients or '
            "--bands, as the stops beyond the limit point depend on the parameters"
        )
    if config.experiment.control == "volume" and config.adapted().gravity.acceleration_m_s2:
        raise ConfigError(
            'experiment.control = "volume": allowed: "pressure" with --gradients or --bands and '
            "gravity, as the volume at rest would change with all that the hanging finger feels"
        )
    if not numbers:
        return [parameter for parameter in every(config) if parameter.entry is not Entry.CHOICE]
    parameters = find(config, numbers)
    for parameter in parameters:
        if parameter.entry is Entry.CHOICE:
            raise ConfigError(
                f"--parameters {parameter.key}: a choice of the model, which has no derivative; "
                f"allowed: {parameter.key.rpartition('.')[0]}, the difference of two runs"
            )
    return parameters


class Sensitivities:
    """Collects the derivatives of a rig's readings as its path goes on.

    Args:
        rig: a rig at its start; it calls :meth:`rest` once the finger is at rest.
        config: configuration that the rig was prepared from.
        parameters: parameters that readings are derived by.

    Raises:
        ConfigError: one line, where a supply of air begins at a state that parameters change.

    Attributes:
        rows: one row for each stop, column and parameter, by :data:`COLUMNS`.
    """

    def __init__(self, rig: Rig, config: Config, parameters: Sequence[Parameter]) -> None:
        self._rig = rig
        self._config = config
        self._parameters = parameters
        self._perturbations = rig.perturbations(config, parameters)
        of_load = [] if rig.place_load is None else [rig.place_load]
        near = partial(rig.newton.linear, near=True)
        self.forward = ForwardSensitivity(rig.newton.model, near, [*self._perturbations, *of_load])
        self._loads_N: list[float] | None = None
        self._zero: list[dict[str, float]] | None = None
        self.rows: list[dict[str, int | float | str]] = []
        self._rows: list[dict[str, float]] = []
        self._slopes: list[list[dict[str, float]]] = [[] for _ in parameters]
        rig.tared, rig.held = callback(self.rest), callback(self.held)
        if rig.air is not None and rig.from_rest_shape:
            raise ConfigError(
                "supply = a table: allowed: without gravity and without trapped air of another "
                "pressure with --gradients or --bands, as they change the air at rest"
            )
        if rig.air is not None:
            self.forward.begun(rig.air, rig.air.begin)

    def _true(self) -> dict[str, float]:
        """The readings that have derivatives, without the distortions of instruments."""
        readings = self._rig.readings.values()
        true = {reading.column: reading.value() for reading in readings if reading.differentiable}
        return {**true, **self._rig.further()}

    def rest(self) -> None:
        """Store the derivatives at rest, where some readings and the plate's gap are zero."""
        with self._rig.newton.profile.phase("sensitivities"):
            self._zero = self.forward.readings(self._true)
            size = len(self._rig.newton.model.u.x.array)
            changes = self.forward.changes[: len(self._perturbations)]
            for perturbation, change in zip(self._perturbations, changes, strict=True):
                moved = change.unknowns[:size]
                placed = self._rig.from_rest_shape and moved.any()
                perturbation.at_rest = moved.copy() if placed else None

    def held(self, place_mm: Callable[[], float]) -> None:
        """Store the derivatives of the load that holds a place: 0 = ∂x/∂m + ∂x/∂L dL/dm."""
        slopes = self.forward.readings(lambda: {"place_mm": place_mm()})
        *by_parameter, by_load = (slope["place_mm"] for slope in slopes)
        self._loads_N = [-slope / by_load for slope in by_parameter]

    def _with_load(self, derived: list[dict[str, float]]) -> list[dict[str, float]]:
        """Let the load that holds a place, which readings are derived by last, change as well."""
        if self._loads_N is None:
            return derived
        *by_parameter, by_load = derived
        return [
            {name: slope + load_N * by_load[name] for name, slope in slopes.items()}
            for slopes, load_N in zip(by_parameter, self._loads_N, strict=True)
        ]

    def record(self, row: int) -> None:
        """Derive the readings of the present stop, which is row ``row`` of the result."""
        with self._rig.newton.profile.phase("sensitivities"):
            derived = self._with_load(self.forward.readings(self._true))
            self._rows.append(self._true())
        for i, (parameter, slopes) in enumerate(zip(self._parameters, derived, strict=True)):
            if self._zero is not None:
                slopes |= {
                    name: slopes[name] - self._zero[i][name]
                    for name in self._rig.from_rest
                    if name in slopes
                }
            self._slopes[i].append(slopes)
            for column, slope in self._displayed(parameter, _columns(self._slopes[i])).items():
                self.rows.append(
                    dict(zip(COLUMNS, (row, column, parameter.key, slope), strict=True))
                )

    def _displayed(self, parameter: Parameter, slopes: Mapping[str, np.ndarray]) -> Row:
        """Derivatives of what the instruments display at the present stop, by column.

        Args:
            parameter: that they are by.
            slopes: derivatives of the true readings so far, (rows,) by column.
        """
        amount = CHANGE * parameter.scale * parameter.direction(self._config)
        changed = self._config
        if parameter.entry is Entry.INSTRUMENT:
            changed = parameter.at(self._config, parameter.value(self._config) + amount)
        true = _columns(self._rows)
        here = self._rig.displayed(self._config, true)
        there = self._rig.displayed(
            changed, {name: value + amount * slopes[name] for name, value in true.items()}
        )
        return {
            name: float((there[name][-1] - here[name][-1]) / amount)
            for name in here
            if name != "time_s"
        }


def _columns(rows: Sequence[Mapping[str, float]]) -> dict[str, np.ndarray]:
    """Rows by column, (rows,) each."""
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}
