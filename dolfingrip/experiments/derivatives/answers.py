"""Readings of a finger at chosen places of its path, with derivatives by parameters of its shape.

A place is a pressure, or where another reading has a value: the force at an angle, the pressure for
a force. There the implicit function theorem gives the derivative: with g(p, m) = a the pressure
moves by dp/dm = −(∂g/∂m)/(∂g/∂p).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import brentq

from dolfingrip.channels import CAVITY_VOLUME, CURVE_PARTS, PRESSURE
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.derivatives.adjoints import FingerAdjoints
from dolfingrip.experiments.finger_experiment import FingerExperiment
from dolfingrip.experiments.protocol import Stop
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.experiments.rigs.tip_load import STIFFNESSES, load
from dolfingrip.jobs.job import JobFailure
from dolfingrip.mechanics.model.model import Control, Prescribed
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.failure import Failure
from dolfingrip.mechanics.readings import peak_stretch, work
from dolfingrip.mechanics.readings.integrals import Integral
from dolfingrip.mechanics.readings.line import part_of_distance
from dolfingrip.mechanics.readings.peak_stretch import PeakStretch
from dolfingrip.mechanics.readings.reading import FromRest, Reading
from dolfingrip.mechanics.readings.tip import TipDisplacement
from dolfingrip.mechanics.readings.work import PressureWork
from dolfingrip.parameter import Parameter, find
from dolfingrip.sections.geometry.geometry import Geometry

if TYPE_CHECKING:
    from mpi4py import MPI

SIDE_STIFFNESS = STIFFNESSES[1].name
"""Reading of the experiment ``push``: the tip's stiffness against a load across the finger."""

PROBE_N = 0.1
"""Load of that reading. By symmetry its displacement has no even powers of it."""

CLOSE = 1e-9
"""Error of a pressure that is searched for, as a part of the highest one."""


Values = Mapping[str, float]
"""Readings at a place, by column."""

Slopes = Mapping[str, Mapping[str, float]]
"""For each column derivatives by key of the parameter."""


class _PressureRaised:
    """The prescribed pressure as a parameter (kPa)."""

    scale: float = 1.0
    direction: float = 1.0

    def __init__(self, controls: dict[str, Prescribed]) -> None:
        self._controls = controls

    @contextmanager
    def applied(self, amount: float) -> Iterator[None]:
        kept = self._controls[PRESSURE.name]
        assert isinstance(kept, Control)
        factor = kept.factor * (1 + amount / kept.value)
        self._controls[PRESSURE.name] = Control(kept.constant, factor)
        try:
            yield
        finally:
            self._controls[PRESSURE.name] = kept


def answers(
    experiment: FingerExperiment,
    config: Config,
    places: Sequence[tuple[str, float]],
    columns: Sequence[str],
    keys: Sequence[str],
    comm: MPI.Comm,
    made_for: Geometry | None = None,
) -> tuple[dict[str, np.ndarray], dict[tuple[str, str], np.ndarray]]:
    """Take readings at places of a finger's path, and their derivatives.

    Args:
        experiment: of one finger.
        config: configuration of the finger, with the experiment's settings.
        places: column and value of each, in any order; where a reading has a value, the pressure is
            searched for from 0 to ``experiment.max_pressure_kPa``.
        columns: of the readings, also :data:`SIDE_STIFFNESS` and those of
            :mod:`~dolfingrip.mechanics.readings.peak_stretch` and ``work``.
        keys: parameters that they are derived by; none: no derivatives.
        comm: ranks to run on.
        made_for: dimensions that the mesh is made for and moved from.

    Returns:
        (places,) readings by column, and (places,) derivatives by column and parameter.

    Raises:
        JobFailure: where the path does not reach a place.
        HasHistory: where the state remembers earlier ones.
        ConfigError: where there is no such finger, reading or parameter.
    """
    if config.experiment.control != "pressure":
        raise ConfigError(
            f'{experiment.name}, experiment.control = "{config.experiment.control}": allowed: '
            '"pressure" where readings are taken at places'
        )
    config.cavity.refuse_own("a reading at a place")
    rig = type(experiment)(made_for).prepare(config, comm, Profile())
    assert isinstance(rig, FingerRig)
    wanted = find(config, list(keys)) if keys else []
    taken = _Path(rig, config, columns, wanted).answers(places)
    values = {name: np.array([here[name] for here, _ in taken]) for name in columns}
    slopes = {
        (name, p.key): np.array([by.get(name, {}).get(p.key, np.nan) for _, by in taken])
        for name in columns
        for p in wanted
    }
    return values, slopes


def _ended(failure: Failure) -> JobFailure:
    return JobFailure(str(failure.kind), failure.sentence())


class _Path:
    """A finger that is taken from place to place."""

    def __init__(
        self, rig: FingerRig, config: Config, columns: Sequence[str], wanted: list[Parameter]
    ) -> None:
        self._rig, self._config, self._parameters = rig, config, wanted
        self._columns = list(columns)
        self._finger: FingerModel = rig.specimen
        self._path = rig.path(())
        self._readings: dict[str, Reading] = dict(rig.readings)
        self._further()

    def _further(self) -> None:
        """Readings that no instrument has."""
        finger = self._finger
        if peak_stretch.COLUMN in self._columns:
            full = self._config.integration != "reduced"
            self._readings[peak_stretch.COLUMN] = PeakStretch(finger.model, full=full)
        if work.COLUMN in self._columns:
            volume = Integral(finger.model, CAVITY_VOLUME.name, finger.driven)
            done = PressureWork(finger.by_pressure, volume, finger.cavity)
            self._readings[work.COLUMN] = FromRest(done)
        for column in self._columns:
            if column in CURVE_PARTS and self._config.curve is not None:
                part = part_of_distance(finger.model, self._config.curve, column)
                self._readings[column] = part
            if column == SIDE_STIFFNESS and load("y") in finger.parameters:
                continue
            if column not in self._readings:
                allowed = ", ".join(
                    name for name, one in self._readings.items() if one.differentiable
                )
                raise ConfigError(f"{column}: no such reading here; allowed: {allowed}")

    def answers(self, places: Sequence[tuple[str, float]]) -> list[tuple[Values, Slopes]]:
        failure = self._rig.start(self._path, Stop(0.0, 0.0, "loading"))
        if failure is not None:
            raise _ended(failure)
        self._rig.read()  # which takes the zero
        for reading in self._readings.values():
            if isinstance(reading, FromRest) and reading.column == work.COLUMN:
                reading.tare()
        by_pressure = [i for i, (column, _) in enumerate(places) if column == PRESSURE.name]
        by_pressure.sort(key=lambda i: places[i][1])
        others = [i for i in range(len(places)) if i not in by_pressure]
        taken: dict[int, tuple[Values, Slopes]] = {}
        for i in by_pressure:
            self._go(places[i][1])
            taken[i] = self._here(None)
        for i in others:
            self._search(*places[i])
            taken[i] = self._here(places[i][0])
        return [taken[i] for i in range(len(places))]

    # -- along the path --------------------------------------------------------------------------

    def _go(self, pressure_kPa: float) -> None:
        arrival = self._path.advance({PRESSURE.name: pressure_kPa})
        if arrival.failure is not None:
            raise _ended(arrival.failure)

    def _search(self, column: str, value: float) -> None:
        """Go to where a reading has a value."""
        reading = self._readings.get(column)
        if reading is None or not reading.differentiable:
            raise ConfigError(f"{column}: no such reading here")
        highest = self._config.experiment.max_pressure_kPa

        def off(pressure_kPa: float) -> float:
            self._go(pressure_kPa)
            return reading.value() - value

        low, before = 0.0, off(0.0)
        high = low
        step = math.copysign(self._config.experiment.step_kPa, highest)
        while high != highest:
            high = sorted((0.0, high + step, highest))[1]
            after = off(high)
            if before * after <= 0:
                brentq(off, low, high, xtol=CLOSE * abs(highest))
                return
            low, before = high, after
        raise JobFailure(
            "not reached",
            f"{column} = {value:g} is not reached up to {highest:g} kPa; "
            f"it is {after + value:.4g} there",
        )

    # -- at a place ------------------------------------------------------------------------------

    def _here(self, where: str | None) -> tuple[Values, Slopes]:
        """Readings and derivatives at the present state, at a fixed pressure or reading."""
        peak = self._readings.get(peak_stretch.COLUMN)
        if isinstance(peak, PeakStretch):
            peak.fit()
        plain = [name for name in self._columns if name != SIDE_STIFFNESS]
        values = {name: self._readings[name].value() for name in plain}
        slopes: dict[str, Mapping[str, float]] = {}
        if self._parameters and plain:
            slopes.update(self._derived(plain, where))
        if SIDE_STIFFNESS in self._columns:
            values[SIDE_STIFFNESS], slopes[SIDE_STIFFNESS] = self._stiffness()
        return values, slopes

    def _stiffness(self) -> tuple[float, Mapping[str, float]]:
        """Return P/(u₁ − u₀), with the tip's displacements u with and without a load P across.

        The load is spread over the tip face as it was built, so it grows with the face's area A in
        derivatives: dk = k (dA/A − (du₁ − du₀)/(u₁ − u₀)).
        """
        model = self._finger.model
        moved = TipDisplacement(model, "y")
        tip = model.domain.surface("tip", quadrature_degree=2)
        area = Integral(model, "tip_mm2", self._finger.site.fixed(1.0) * tip)
        state, force = model.state(), self._finger.parameters[load("y")]

        def at(*readings: Reading) -> tuple[float, list[dict[str, float]]]:
            if not self._parameters:
                return moved.value(), []
            adjoints = FingerAdjoints(self._finger, readings, self._rig.newton)
            slopes = adjoints.by_parameters(self._config, self._parameters)
            return moved.value(), [slopes[reading.column] for reading in readings]

        before, without = at(moved, area)
        force.value = PROBE_N
        try:
            if not Newton(model, self._config.solver).solve().converged:
                said = "the tip's stiffness: no equilibrium with the load"
                raise JobFailure("iteration limit", said)
            after, pushed = at(moved)
        finally:
            force.value = 0.0
            model.restore(state)
        stiffness = PROBE_N / (after - before)
        if not self._parameters:
            return stiffness, {}
        size = area.value()
        return stiffness, {
            key: stiffness * (without[1][key] / size - (slope - without[0][key]) / (after - before))
            for key, slope in pushed[0].items()
        }

    def _derived(self, columns: list[str], where: str | None) -> dict[str, dict[str, float]]:
        names = [name for name in columns if name != PRESSURE.name]
        if where is not None and where not in names:
            names.append(where)
        wanted = [self._readings[name] for name in names]
        adjoints = FingerAdjoints(self._finger, wanted, self._rig.newton)
        slopes = adjoints.by_parameters(self._config, self._parameters)
        if where is None:
            return slopes
        by_pressure = adjoints.derivatives(_PressureRaised(self._finger.model.controls))
        by_column = {}
        for name in columns:
            along = 1.0 if name == PRESSURE.name else by_pressure[name]
            by_column[name] = {
                key: (0.0 if name == PRESSURE.name else slopes[name][key])
                - along / by_pressure[where] * slope
                for key, slope in slopes[where].items()
            }
        return by_column
