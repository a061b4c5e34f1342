"""Fingers, and coupons beside them: simulations at the numbers of a hypothesis, with derivatives.

Elements at edges are small where the mesh is graded. All simulations but one have ungraded
elements, which take a third of the time; what grading changes is added to each, and a part of it is
what the mesh may still get wrong. So it is with steps in time: one simulation has shorter ones, and
all have them where what they change could be seen.
What an instrument shows follows from the simulated readings, so its errors cost no simulation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Final

import numpy as np

from dolfingrip.config import Change, Config, changed
from dolfingrip.diagnosis.core.blend import Tangents
from dolfingrip.diagnosis.core.unknown import MODULUS, Cause, Nuisance
from dolfingrip.diagnosis.coupon import CouponSimulation
from dolfingrip.diagnosis.data.measurement import Measurement, Rows, SpecimenTest
from dolfingrip.diagnosis.simulation.nuisances import displayed, keys, nuisances, told_of
from dolfingrip.diagnosis.simulation.point import Point
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import (
    ModelVariant,
    SimulatedReadings,
    SimulationGroup,
    groups,
    simulate,
)
from dolfingrip.experiments.request import MESH
from dolfingrip.extensions.effect import Displaying
from dolfingrip.extensions.index import effect, fitted_effects
from dolfingrip.parameter.nuisances import changes, modulus_keys, neutral_stages

STEP: Final = 1e-3
"""Of ζ, by which what an instrument shows is differentiated."""

ROUNDED: Final = "{:.5g}"
"""Of numbers that are simulated: like fits ask for the same simulations."""


@dataclass(eq=False)
class FingerSimulation:
    """Simulates fingers, and coupons beside them.

    Attributes:
        measurement: what is simulated.
        config: the model as configured.
        workers: where simulations are computed and kept.
        flat: change to the mesh that all is simulated on but one simulation.
        start: that the model without causes is simulated at; None: as configured.
        graded: whether what the mesh changes is told by a simulation on the mesh as configured.
        not_reached: tests with readings that the model does not reach, which are left out, and why.
        whole: the measurement with these; None where none is left out.
    """

    measurement: Measurement
    config: Config
    workers: Workers
    flat: Change
    start: Point | None = None
    graded: bool = True
    not_reached: Sequence[str] = ()
    whole: Measurement | None = None

    closed_form: ClassVar = False

    @property
    def at_once(self) -> int:
        """Simulations that are made side by side."""
        return max(self.workers.where.workers, 1)

    @cached_property
    def applied(self) -> Config:
        """Configuration of the first test's set-up; its material is that of all."""
        return self.measurement.tests[0].applied(self.config)

    @cached_property
    def groups(self) -> Sequence[SimulationGroup]:
        return groups(self.measurement, self.config)

    # -- the model without causes -----------------------------------------------------------------

    @property
    def _started(self) -> Change:
        """Change to the start, with the regulator's numbers as parameters."""
        start = {} if self.start is None else self.start.change(self.applied)
        return {**neutral_stages(self.config), **_rounded(start)}

    @cached_property
    def first(self) -> SimulatedReadings:
        """The model without causes at its start, on the mesh of all simulations."""
        values = {**self.flat, **self._started}
        variant = ModelVariant(values, keys(self.measurement, self.config))
        return simulate(self.measurement, self.config, [variant], self.workers)[0]

    @cached_property
    def fine(self) -> SimulatedReadings:
        """The model without causes at its start, on the mesh as configured, in shorter steps."""
        variant = ModelVariant({**self._started, **self.shorter}, mesh_check=not self.flat)
        return simulate(self.measurement, self.config, [variant], self.workers)[0]

    @property
    def shorter(self) -> Change:
        """Change to less than half the steps in time: a step's error is of third order in it."""
        solver, supply, change = self.config.solver, self.config.supply, dict[str, float]()
        if self.config.experiment.dynamic:
            change["solver.time_error_mm"] = max(solver.time_error_mm / 10, 1e-6)
        if supply is not None:
            change["supply.error_kPa"] = max(supply.error_kPa / 10, 1e-6)
        if change and solver.max_step_s is not None:
            change["solver.max_step_s"] = solver.max_step_s / 2
        return change

    @property
    def in_shorter_steps(self) -> FingerSimulation:
        """A simulation of the same measurement, all of it in shorter steps in time."""
        return replace(self, config=changed(self.config, self.shorter))

    @property
    def has_coarser(self) -> bool:
        """Tell whether mesh or steps of all simulations are others than those of the finest."""
        return self.graded and bool(self.flat or self.shorter)

    @cached_property
    def _finer(self) -> Rows:
        """True readings on the finest mesh in the shortest steps, less those of :attr:`first`."""
        fine = self.fine.true if self.has_coarser else self.first.true
        return {
            tests: {name: fine[tests][name] - values for name, values in columns.items()}
            for tests, columns in self.first.true.items()
        }

    @cached_property
    def delta(self) -> np.ndarray:
        """Change (n,) by the mesh as configured and shorter steps; 0 where no other tells it."""
        none = np.zeros(len(self.first.readings))
        return self.fine.readings - self.first.readings if self.has_coarser else none

    @cached_property
    def base(self) -> SimulatedReadings:
        """The model without causes at its start."""
        return replace(self.first, readings=self.first.readings + self.delta)

    @cached_property
    def configured(self) -> np.ndarray:
        """Readings (n,) of the model as configured; NaN where it does not come so far."""
        if self.start is None:
            return self.base.readings
        return replace(self, start=None, graded=False).base.readings + self.delta

    @property
    def mesh(self) -> np.ndarray:
        """Error (n,) that the mesh may have, with its sign; 0 where it cannot be told.

        It is a part of what grading and shorter steps change; of a mesh that is not graded one
        bisection tells it.
        """
        bisected = self.graded and not self.flat
        finer = self.fine.slopes.get(MESH, 0.0 * self.delta) if bisected else 0.0
        return np.nan_to_num(self.measurement.policy.mesh_share * self.delta + finer)

    @property
    def rig(self) -> Sequence[Nuisance]:
        """Numbers of rig and body by which the readings change, too."""
        numbers = nuisances(self.measurement, self.base)
        return [replace(number, change=np.nan_to_num(number.change)) for number in numbers]

    def additions(
        self, points: Sequence[Point], measurements: Sequence[Measurement], *, known_mesh: bool
    ) -> list[tuple[list[Tangents | None], Sequence[Nuisance]]]:
        """Simulate other measurements, on either mesh; the plate is set anew."""
        anew = {effect.told.key for effect in fitted_effects() if effect.told.each_time}
        others = [
            replace(self, measurement=other, graded=known_mesh, start=None)
            for other in measurements
        ]
        return [
            (other.at(points), [n for n in other.rig if n.name.partition(" at ")[0] not in anew])
            for other in others
        ]

    # -- with causes ------------------------------------------------------------------------------

    def at(self, points: Sequence[Point]) -> list[Tangents | None]:
        """Simulate other numbers, with exact derivatives; None where readings are not reached."""
        variants = [self._variant(point) for point in points]
        simulated = simulate(self.measurement, self.config, variants, self.workers)
        return [
            self._told(point, run) if np.isfinite(run.readings).all() else None
            for point, run in zip(points, simulated, strict=True)
        ]

    def plain(self, point: Point) -> Tangents:
        """The model without causes at its start, which is a point."""
        return self._told(point, self.first)

    def resting(self, causes: Sequence[Cause], start: Point) -> dict[str, Tangents] | None:
        """Simulate causes where they do nothing; None where readings are not reached."""
        on: Change = {}
        for cause in causes:
            on = {**on, **cause.resting(start.moduli)}
        wanted = tuple(n.gradient for cause in causes for n in cause.numbers if n.amplitude)
        values = {**self.flat, **_rounded(start.change(self.applied)), **on}
        variant = ModelVariant(values, (*wanted, *self._own_keys(start)))
        (simulated,) = simulate(self.measurement, self.config, [variant], self.workers)
        if not np.isfinite(simulated.readings).all():
            return None
        plain, felt = self._told(start, simulated), {}
        none = np.zeros(len(simulated.readings))
        for cause in causes:
            keys_of = [n.gradient if n.amplitude else "" for n in cause.numbers]
            if simulated.slopes.keys().isdisjoint(keys_of):
                continue
            by = [
                n.coordinate_of(cause.neutral(n))[1] * (start.moduli if n.modulus else 1.0)
                if key else 0.0
                for key, n in zip(keys_of, cause.numbers, strict=True)
            ]  # fmt: skip
            slopes = [simulated.slopes.get(key, none) for key in keys_of]
            felt[cause.name] = at_rest(cause, plain, np.column_stack(slopes) * by)
        return felt

    def _variant(self, point: Point) -> ModelVariant:
        """Simulations of a point, without errors of instruments, which cost none."""
        solid = tuple(pair for pair in point.causes if not shown(pair[0]))
        part = replace(point, causes=solid)
        gradients = [n.gradient for n, _ in part.numbers]
        values = {**self.flat, **_rounded(part.change(self.applied))}
        return ModelVariant(values, (*gradients, *self._own_keys(point)))

    def _own_keys(self, point: Point) -> tuple[str, ...]:
        return (*(n.gradient for n, _ in point.own), *modulus_keys(self.applied))

    def _told(self, point: Point, simulated: SimulatedReadings) -> Tangents:
        """Readings and derivatives by coordinates from simulations of all tests."""
        moduli = [n.gradient for n, _ in point.numbers if n.modulus]

        def stiffer(config: Config) -> Change:
            by_key = changes(config, MODULUS, 1.0)
            return {**{key: _value(config, key) for key in moduli if key not in by_key}, **by_key}

        numbers = [n.gradient for n, _ in point.numbers]
        along = [simulated.changes(stiffer), *map(simulated.by, numbers)]
        by = point.rates()
        if any(shown(cause) for cause, _ in point.causes):
            columns = self._displayed(point, simulated.true, along, by)
        else:
            slopes = np.nan_to_num([self.measurement.collected(rows) for rows in along])
            columns = np.vstack([simulated.readings + self.delta, slopes * by[:, None]])
        return Tangents(point.u, columns.T[None])

    def _displayed(
        self, point: Point, true: Rows, along: Sequence[Rows], by: np.ndarray
    ) -> np.ndarray:
        """Readings and derivatives, (1 + d, n), as instruments show them.

        Args:
            point: with errors of instruments.
            true: readings at all rows.
            along: their derivatives by ln of the moduli and by each of the point's numbers.
            by: derivatives of these by coordinates, shape (d,).
        """
        applied = self.measurement.applied(self.config)
        instrument = np.repeat(
            [False, *(shown(cause) for cause, _ in point.causes)],
            [1 + len(point.own), *(len(zeta) for _, zeta in point.causes)],
        )
        rates = np.array([1.0, *(float(n.coordinate(np.array(z))[1]) for n, z in point.numbers)])

        def shows(step: np.ndarray) -> np.ndarray:
            """Readings (n,) with the numbers a step of their coordinates (d,) on."""
            errors: list[tuple[Cause, np.ndarray]] = []
            first = 1 + len(point.own)
            for cause, zeta in point.causes:
                places = slice(first, first + len(zeta))
                first += len(zeta)
                if shown(cause):
                    errors.append((cause, zeta + (step / rates)[places]))
            configs = {
                test.number: changed(config, _errors(errors, test))
                for test, config in zip(self.measurement.tests, applied, strict=True)
            }
            moves = [(1.0, self._finer), *zip(step * by, along, strict=True)]
            moved = {
                tests: {
                    name: values + sum(size * rows[tests][name] for size, rows in moves if size)
                    for name, values in columns.items()
                }
                for tests, columns in true.items()
            }
            return displayed(self.measurement, moved, configs)

        here, steps = shows(0 * by), STEP * np.where(instrument, rates, 1.0)
        slopes = [(shows(step) - here) / step.sum() for step in np.diag(steps)]
        return np.vstack([here, *slopes])


Simulator = CouponSimulation | FingerSimulation
"""Simulates a measurement: readings at the numbers of any hypothesis, with derivatives.

Coupons are simulated in closed form, fingers by requests to a store. A simulator knows nothing of
inference.
"""


def shown(cause: Cause) -> bool:
    """Tell whether a cause acts on what instruments show alone.

    Args:
        cause: an effect of the catalogue.
    """
    return issubclass(effect(cause.name), Displaying)


def _errors(causes: Iterable[tuple[Cause, np.ndarray]], test: SpecimenTest) -> Change:
    """Change to a test's set-up by errors of instruments; a camera's act where one is told of."""
    change: Change = {}
    for cause, zeta in causes:
        kind = effect(cause.name)
        if not kind.told_by or told_of(kind, test):
            change = {**change, **cause.overrides(zeta)}
    return change


def _value(config: Config, key: str) -> float:
    """Value of a modulus by its key."""
    section, _, name = key.partition(".")
    return float(getattr(config, section).number_at(name))


def _rounded(values: Change) -> Change:
    """Numbers of a simulation at so many digits that like fits share it."""

    def one(value: object) -> object:
        if isinstance(value, list | tuple):
            return [one(entry) for entry in value]
        return float(ROUNDED.format(value)) if isinstance(value, float) else value

    return {key: one(value) for key, value in values.items()}


def at_rest(cause: Cause, plain: Tangents, slopes: np.ndarray) -> Tangents:
    """The model with a cause that does nothing.

    Args:
        cause: whose amplitudes are neutral.
        plain: the model without it, one simulation.
        slopes: derivatives by the coordinates of its numbers, shape (n, d).
    """
    u = [cause.resting_coordinate(number) for number in cause.numbers]
    readings = np.concatenate([plain.told, slopes[None]], axis=2)
    return Tangents(np.hstack([plain.u, [u]]), readings)


def coarser(config: Config) -> list[Change]:
    """Changes to the meshes that causes may be simulated on, the coarsest first.

    The first is not graded at all, the last is the mesh as configured. Those between are for thick
    walls: of a cast block one element, 4 mm wide, does not bear 5 kPa.
    """
    if config.mesh.file is not None or not config.hexahedra:
        return [{}]
    size_mm, edge_mm = config.mesh.hexahedra_mm(config.geometry)
    between = [by * edge_mm for by in (2**2, 2) if by * edge_mm < size_mm]
    sizes_mm = [size_mm, *between] if edge_mm < size_mm else []
    return [*({"mesh.edge_size_mm": h_mm} for h_mm in sizes_mm), {}]
