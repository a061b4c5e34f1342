"""The model of fingers without causes: any moduli, any walls that are fitted, and all errors.

A simulation costs what its mesh and its deformation cost, and a diagnosis makes some 150. So the
model is first simulated on the coarsest mesh. Where its moduli do not follow the readings, it is
simulated anew with those that do. A finer mesh is taken where it comes farther, or where the graded
one reads otherwise.

Without weight and memory a change of all moduli scales a simulation exactly
(:mod:`dolfingrip.diagnosis.simulation.simulated`). Where it does not, the model is simulated at
several moduli, and what lies between them follows from a polynomial of their inverse.

The base simulation has a graded mesh. Effects are tried on an ungraded one, which takes a third of
the time. What it gets wrong is wrong with and without an effect, so that changes are taken between
two simulations on it; a part of what grading changes is a nuisance, for what the graded mesh still
gets wrong.

Other walls are simulated. Where bellows touch one another, the derivative of the blocked force by
the walls' thickness jumps, and other walls move that jump. Taken as linear, walls that are 10 % too
thin leave 3 standard deviations of the reference finger's readings unexplained. So the base model
is simulated with walls to either side, and with others that readings may ask for. A polynomial
leads through all. Moduli scale each of the simulations exactly.

Readings on the ungraded mesh are mapped to those on the graded one by an elastic curve. What a
coarse mesh gets wrong grows with the deformation, so it is taken at the same reading, not at the
same pressure: δ(y) = graded − ungraded along the base model's curve, where the ungraded one reads
y. A softer finger bends further and is off by more. With moduli c times as large a force is off by
c δ(F/c). Displacements of the tip, which turn round or stand still on the way, keep what they are
off by at their pressure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from scipy.interpolate import PchipInterpolator

from dolfingrip.channels import CHANNELS
from dolfingrip.config import Change, Config, ConfigError, changed
from dolfingrip.diagnosis.answer.discrepancy import kernel
from dolfingrip.diagnosis.answer.errors import Errors, errors_of
from dolfingrip.diagnosis.core.emulator import (
    Coordinate,
    Emulator,
    SimulatedChanges,
    Stacked,
    trained_on,
)
from dolfingrip.diagnosis.core.evidence import (
    LEVELS,
    CovarianceModel,
    InferenceProblem,
    MapFit,
)
from dolfingrip.diagnosis.core.unknown import MODULUS, Nuisance, Unknown, factor_of_moduli
from dolfingrip.diagnosis.data.measurement import Measurement, Rows
from dolfingrip.diagnosis.policy import MODEL, POLICY, ROUTES
from dolfingrip.diagnosis.simulation.nuisances import base_variant, nuisances
from dolfingrip.diagnosis.simulation.runner import Workers
from dolfingrip.diagnosis.simulation.simulated import (
    ModelReadings,
    ModelVariant,
    SimulatedGroup,
    SimulatedReadings,
    SimulationGroup,
    scale_all,
    scaled_moduli,
    simulate,
)
from dolfingrip.diagnosis.simulation.stops import spline_weights
from dolfingrip.diagnosis.simulation.unknowns import WALLS
from dolfingrip.experiments.request import MESH
from dolfingrip.extensions.effect import Prior
from dolfingrip.jobs.run import silent
from dolfingrip.parameter import every, moduli
from dolfingrip.parameter.nuisances import WALL, modulus_keys, neutral_stages, wall, wall_key
from dolfingrip.sections.section import Role

MAPPED: Final = frozenset(each.name for each in CHANNELS.values() if each.grows)
"""Readings that grow with the load."""


@dataclass(frozen=True)
class _Curve:
    """δ of some readings by their value: ``places`` in the list."""

    places: np.ndarray
    delta: PchipInterpolator
    in_proportion: bool


@dataclass
class MeshMap:
    """The map from ungraded to graded readings.

    Attributes:
        measurement: of all arrays.
        graded, plain: base model on both meshes.
    """

    measurement: Measurement
    graded: SimulatedReadings
    plain: SimulatedReadings
    _curves: list[_Curve] = field(init=False)

    def __post_init__(self) -> None:
        """Prepare the curves; what has none keeps the difference that it has at its pressure."""
        self._curves = []
        for fine, rough in zip(self.graded.runs, self.plain.runs, strict=True):
            if rough.schedule is not rough.group.curve:
                continue
            for name, places in self.measurement.places(rough.group.tests).items():
                if name not in MAPPED:
                    continue
                at = rough.result.columns.get(name, np.empty(0))
                values = fine.result.columns.get(name, np.empty(0))
                count = min(len(at), len(values))
                if rough.schedule.value[:count] != fine.schedule.value[:count]:
                    continue
                rising = _rising(at[:count])
                if rising is not None:
                    order, own = rising
                    smooth = PchipInterpolator(own, (values[:count] - at[:count])[order])
                    self._curves.append(_Curve(places, smooth, CHANNELS[name].in_proportion))

    def to_graded(
        self, readings: np.ndarray, jacobian: np.ndarray, factor: float = 1.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings, shape (n,), and derivatives, shape (n, p), as the graded mesh would have them.

        Args:
            readings, jacobian: on the ungraded mesh.
            factor: of all moduli.
        """
        found = readings + np.nan_to_num(self.graded.readings - self.plain.readings)
        slopes = jacobian.copy()
        for curve in self._curves:
            scale = factor if curve.in_proportion else 1.0
            own = readings[curve.places] / scale
            ends = curve.delta.x  # beyond them a straight line goes on
            inside = np.clip(own, ends[0], ends[-1])
            slope = curve.delta(inside, 1)
            delta = curve.delta(inside) + slope * (own - inside)
            found[curve.places] = readings[curve.places] + scale * delta
            slopes[curve.places] *= (1 + slope)[:, None]
        return found, slopes


def _rising(values: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Order in which values rise, and the values; None where the curve turns round."""
    if len(values) < 3:
        return None
    steps = np.diff(values)
    way = 1.0 if values[-1] > values[0] else -1.0
    if (way * steps < 0).any():
        return None
    order = np.arange(len(values)) if way > 0 else np.arange(len(values))[::-1]
    at = values[order]
    new = np.concatenate([[True], np.diff(at) > 1e-9 * max(float(np.ptp(at)), 1e-12)])
    return (order[new], at[new]) if new.sum() > 2 else None


def coarser(config: Config) -> list[Change]:
    """Changes to the meshes that causes may be simulated on, the coarsest first.

    The first is not graded at all, the last is the mesh as configured. Those between are for thick
    walls: of a cast block one element, 4 mm wide, does not bear 5 kPa.
    """
    if config.mesh.file is not None or not config.hexahedra:
        return [{}]
    size_mm, edge_mm = config.mesh.hexahedra_mm(config.geometry)
    between = [by * edge_mm for by in MODEL.edges if by * edge_mm < size_mm]
    sizes_mm = [size_mm, *between] if edge_mm < size_mm else []
    return [*({"mesh.edge_size_mm": each} for each in sizes_mm), {}]


@dataclass(eq=False)
class FingerSimulation:
    """The model at any moduli, with other walls and on two meshes, simulated as it is asked for.

    Attributes:
        measurement: what is simulated.
        config: as configured.
        workers: where simulations are computed and kept.
        flat: changes to the mesh that causes are simulated on.
        centre: factor of all moduli that all is simulated at.
        headroom: pressure that simulations go on to, by the highest of the readings.
        rough: whether the mesh of the causes stands for the graded one; then there are no
            nuisances and no other walls, and readings beyond the pressure at which the simulation
            ends go on along a straight line, or are 0.
        tried_walls: thicknesses by that configured that are simulated beside the usual ones.
        failures: why the base simulation ended before readings that are left out.
        softest: least factor of all moduli; 0 where the readings alone bound it.
    """

    measurement: Measurement
    config: Config
    workers: Workers
    flat: Change
    centre: float = 1.0
    headroom: float = ROUTES.headroom
    rough: bool = True
    tried_walls: tuple[float, ...] = ()
    failures: Sequence[SimulatedGroup] = ()
    softest: float = 0.0

    closed_form: ClassVar = False

    def __post_init__(self) -> None:
        self._weights: dict[tuple[object, ...], np.ndarray] = {}

    def refined(self) -> FingerSimulation:
        """With the graded mesh, of the readings that its simulation comes to.

        Raises:
            ConfigError: one line: a set-up that cannot be built, a test of which no reading is
                reached, no workers, or a store in use.
        """
        found = replace(self, rough=False)
        base, measurement = found.base, self.measurement
        reached = np.where(np.isfinite(base.by_control), base.readings, np.nan)
        if not not_reached(measurement, measurement, reached, base.failures):
            return found
        kept = np.where(np.isnan(reached), np.nan, measurement.listed["value"])
        again = replace(self, measurement=measurement.reading(kept)).refined()
        return replace(again, failures=base.failures)

    # -- what is simulated ------------------------------------------------------------------------

    def _simulated(self, *variants: ModelVariant) -> list[SimulatedReadings]:
        own = [replace(each, headroom=self.headroom) for each in variants]
        return simulate(self.measurement, self.config, own, self.workers)

    def _by_moduli(
        self, stages: Change, there: SimulatedReadings
    ) -> dict[float, SimulatedReadings]:
        """Simulations by the factor of all moduli: one where these scale it, else several."""
        if scale_all(there.runs):
            return {self.centre: there}
        nodes = [self.centre * c for c in MODEL.weighing]
        every = self._simulated(*(ModelVariant({**stages, **self.moduli(c)}) for c in nodes))
        return dict(zip(nodes, every, strict=True))

    @cached_property
    def plain(self) -> SimulatedReadings:
        """On the mesh that causes are simulated on, with headroom."""
        return self._simulated(ModelVariant({**self.flat, **self.moduli(self.centre)}))[0]

    @cached_property
    def base(self) -> SimulatedReadings:
        """On the graded mesh, with derivatives by nuisances, and with headroom."""
        if self.rough:
            return replace(self.plain, readings=np.nan_to_num(self.base_at(self.centre)))
        wanted = base_variant(self.measurement, self.config, self.moduli(self.centre))
        # where no other mesh tells its error
        return self._simulated(replace(wanted, mesh_check=not self.flat))[0]

    @cached_property
    def fine(self) -> dict[float, SimulatedReadings]:
        """Base simulations by the factor of all moduli."""
        stages = neutral_stages(self.config)
        return self.coarse if self.rough else self._by_moduli(stages, self.base)

    @cached_property
    def coarse(self) -> dict[float, SimulatedReadings]:
        """Simulations on the mesh of the causes by the factor of all moduli."""
        return self._by_moduli(self.flat, self.plain)

    @property
    def wall_std(self) -> float:
        """Relative standard deviation of the walls; 0 where they are a linear nuisance."""
        return self._told_wall_std if self.walls else 0.0

    @property
    def _told_wall_std(self) -> float:
        return min(test.setup.nuisances[WALL] for test in self.measurement.tests)

    @cached_property
    def walls(self) -> dict[float, SimulatedReadings]:
        """Base simulations by the thickness of the walls, by that configured.

        Further ones that do not come to all readings are left out. It is empty where a linear
        nuisance serves, as nothing is blocked or the walls are known; where there are no walls; or
        where moduli do not scale, specimens have different walls, or thinner ones do not reach all
        readings.
        """
        bodies = [run for run in self.base.runs if run.group.experiment != "coupon"]
        blocked = any(run.group.experiment == "blocked_force" for run in bodies)
        found = {(wall_key(run.config), run.config.geometry.wall_mm) for run in bodies}
        linear = all(run.config.geometry.movable("wall_mm") for run in bodies) and not blocked
        known = self._told_wall_std < MODEL.walls_known or len(found) != 1
        if self.rough or known or linear or not self.scales:
            return {}
        ((key, wall_mm),) = found
        if key is None:
            return {}
        usual, base = (1 - MODEL.walls_by, 1 + MODEL.walls_by), self.base.variant
        every = (*usual, *self.tried_walls)
        simulated = self._simulated(*(  # coupons do not feel them: these are the base simulation's
            replace(base, overrides={**base.overrides, key: wall_mm * by}, gradients=())
            for by in every
        ))  # fmt: skip
        kept = np.isfinite(self.base.readings)
        reached = {
            by: each
            for by, each in zip(every, simulated, strict=True)
            if np.isfinite(each.readings[kept]).all()
        }
        return {**reached, 1.0: self.base} if set(usual) <= set(reached) else {}

    @cached_property
    def own(self) -> Sequence[Unknown]:
        """The body's numbers that the laboratory told a deviation of by their keys.

        Every hypothesis fits them, as far as there is such a body.
        """
        tests = self.measurement.applied(self.config)
        every_test = [
            {(p.key, p.value(own)) for p in every(own) if p.section.role is Role.BODY}
            for own in tests
        ]
        alike = dict(set.intersection(*every_test))
        known = {each.name: each for each in self.nuisances if each.name in alike}
        stiffnesses = modulus_keys(self.applied)
        return [
            _feasible(
                self.applied,
                replace(
                    each.unknown, prior=Prior(alike[key], each.std, "as reported"),
                    modulus=key in stiffnesses,
                ),
            )
            for key, each in known.items()
        ]  # fmt: skip

    @cached_property
    def nuisances(self) -> Sequence[Nuisance]:
        """Numbers of rig and body by which the readings change, too."""
        return [] if self.rough else nuisances(self.measurement, self.base)

    @property
    def rig(self) -> Sequence[Nuisance]:
        """Nuisances that no hypothesis fits."""
        fitted = {MODULUS, *(each.key for each in self.own)}
        fitted |= {WALL} if self.walls else set()
        own = [each for each in self.nuisances if each.name not in fitted]
        return [replace(each, change=np.nan_to_num(each.change)) for each in own]

    @cached_property
    def mesh(self) -> np.ndarray:
        """(n,) what the mesh may get wrong, with its sign; 0 where it cannot be told.

        It is a part of what grading changes, or as one bisection tells it.
        """
        none = np.zeros(len(self.base.readings))
        error = none if self.rough else self.base.slopes.get(MESH, none)
        if self.flat and not self.rough:
            error = MODEL.mesh_share * (self.base.readings - self.plain.readings)
        return np.nan_to_num(error)

    @cached_property
    def configured(self) -> np.ndarray:
        """(n,) readings with the moduli as configured; NaN where these are not reached."""
        if self.centre == 1.0:
            return self.base.readings
        variant = ModelVariant(coarser(self.config)[0], headroom=ROUTES.headroom)
        (first,) = simulate(self.measurement, self.config, [variant], self.workers)
        return self.graded(first.readings, 1.0)[0]

    @cached_property
    def _map(self) -> MeshMap:
        return MeshMap(self.measurement, self.base, self.plain)

    @property
    def groups(self) -> list[SimulationGroup]:
        """Which tests share a simulation."""
        return [run.group for run in self.base.runs]

    @property
    def scales(self) -> bool:
        """True if the moduli scale the base model exactly."""
        return scale_all(self.base.runs)

    @cached_property
    def applied(self) -> Config:
        """Configuration of the first test's set-up; its material is that of all."""
        return self.measurement.tests[0].applied(self.config)

    @property
    def lab(self) -> Config:
        """A test's configuration, with weight where one has it."""
        return self.measurement.lab(self.config)

    def moduli(self, factor: float) -> Change:
        """Return the change that makes all moduli ``factor`` times as large as configured."""
        return scaled_moduli(self.applied, factor)

    def at(self, values: Change, steps: Sequence[tuple[Unknown, float]]) -> ModelReadings:
        """Simulate other values, with exact derivatives by some.

        Raises:
            ConfigError: one line, where the simulation does not reach all readings.
        """
        stiffnesses = modulus_keys(self.applied)
        variant = ModelVariant(values, (*(number.gradient for number, _ in steps), *stiffnesses))
        (run,) = simulate(self.measurement, self.config, [variant], self.workers)
        if not np.isfinite(run.readings).all():
            names = [key.split(".")[1] for key in values if key.startswith("extensions.")]
            why = "; ".join(each.why for each in run.failures) or "no reading"
            raise ConfigError(f"{' with '.join(dict.fromkeys(names)) or 'the model'}: {why}")
        by_log = run.by_log_modulus(self.measurement)
        for number, _ in steps:
            key = number.gradient
            # the body's own stiffnesses are in the derivative already, those of effects are not
            if number.modulus and key in run.slopes and key not in stiffnesses:
                by_log = by_log + run.slopes[key] * float(np.ravel(values[number.key])[0])
        return replace(run, slopes={**run.slopes, MODULUS: by_log})

    def of(self, measurement: Measurement, *, known_mesh: bool = True) -> FingerSimulation:
        """Return the simulation of another measurement, on the mesh of fits or of causes."""
        config = self.config if known_mesh else changed(self.config, self.flat)
        return replace(self, measurement=measurement, config=config)

    # -- reading a simulation ---------------------------------------------------------------------

    def rows(self, simulated: SimulatedReadings, factor: float, slope: str | None = None) -> Rows:
        """Readings of each run at the measured rows, by its tests and column, (rows,) each.

        Args:
            simulated: with headroom, where it is read at other moduli.
            factor: of all moduli, by those of the simulation. Ignored where it has a memory.
            slope: key of a parameter that the readings are derived by.
        """
        count = len(self.measurement.readings)
        found = {}
        for run in simulated.runs:
            own = {}
            for name, values in run.columns(slope).items():
                if name == "time_s" or not len(values):
                    continue
                force = run.force(name)
                if run.schedule is not run.group.curve:
                    own[name] = run.schedule.at_rows(values, count, force=force)
                    continue
                (leg,) = run.schedule.legs
                by = 1.0 if run.group.experiment == "coupon" else 1 / factor
                told = np.full(count, np.nan)
                # simulations of a group are read alike, but where a force begins to act
                key = (
                    run.group.tests, len(leg.stops), len(values), by,
                    None if force is None else force.tobytes(),
                )  # fmt: skip
                if key not in self._weights:
                    self._weights[key] = leg.weights(
                        len(values), leg.rows_at * by, ROUTES.beyond, force=force
                    )
                # stops that were not reached have no weight
                told[leg.rows] = self._weights[key][:, : len(values)] @ values
                own[name] = told * (factor if CHANNELS[name].in_proportion else 1.0)
            found[run.group.tests] = own
        return found

    def read(
        self, simulated: SimulatedReadings, factor: float, slope: str | None = None
    ) -> np.ndarray:
        """(n,) readings; see :meth:`rows`. A slope that nothing feels is 0."""
        found = self.measurement.collected(self.rows(simulated, factor, slope))
        return found if slope is None else np.nan_to_num(found)

    def base_rows(self, factor: float) -> Rows:
        """Rows of the base model with all moduli ``factor`` times as configured."""
        return self._between(self.fine, factor)

    def _between(self, known: dict[float, SimulatedReadings], factor: float) -> Rows:
        """Rows at other moduli than those of some simulations, or between these."""
        # displacements are nearly proportional to the compliance, and forces nearly the same
        parts = spline_weights(1 / np.array([*known]), np.array([1 / factor]), 0)[0]
        every = [self.rows(s, factor / c) for c, s in known.items()]
        return {
            tests: {
                name: np.sum([p * own[tests][name] for p, own in zip(parts, every, strict=True)], 0)
                for name in columns
            }
            for tests, columns in every[0].items()
        }

    def base_at(self, factor: float) -> np.ndarray:
        """(n,) readings of the base model at other moduli."""
        return self.measurement.collected(self.base_rows(factor))

    def graded(
        self, readings: np.ndarray, factor: float, slopes: np.ndarray | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings, (n,), and derivatives, (n, d), as the graded mesh would have them."""
        jacobian = np.zeros((len(readings), 0)) if slopes is None else slopes
        return self._map.to_graded(readings, jacobian, factor / self.centre)

    def graded_at(self, factor: float) -> np.ndarray:
        """(n,) readings of the model at other moduli, mapped from the mesh of the causes."""
        plain = self.measurement.collected(self._between(self.coarse, factor))
        return self.graded(plain, factor)[0]

    def graded_by_log(self, factor: float) -> np.ndarray:
        """(n,) derivatives of :meth:`graded_at` by the logarithm of the moduli."""
        step = 1e-3
        more, less = (self.graded_at(factor * np.exp(way * step)) for way in (1, -1))
        return np.asarray((more - less) / (2 * step))


class NothingReached(ConfigError):
    """A test has no reading to which the base simulation comes."""


def not_reached(
    measurement: Measurement,
    known: Measurement,
    readings: np.ndarray,
    failures: Sequence[SimulatedGroup],
) -> list[str]:
    """For each test, readings that the base simulation does not come to, and why.

    Args:
        measurement: all that was measured.
        known: what was compared of it.
        readings: of the base simulation for that, (n,); NaN where it does not come so far.
        failures: of the base simulation.

    Raises:
        NothingReached: one line, where a test has none left.
    """
    every = measurement.listed["test"].to_numpy()
    reached = known.listed["test"].to_numpy()[np.isfinite(readings)]
    found = []
    for test in measurement.tests:
        count, left = (int((each == test.number).sum()) for each in (every, reached))
        ended = (each.why for each in failures if test.number in each.group.tests)
        why = "; ".join(filter(None, ended))
        who = f"{test.experiment} of {test.specimen}: the base simulation"
        if not left:
            raise NothingReached(f"{who} reaches no reading: {why}")
        if lost := count - left:
            found.append(
                f"{who} does not reach {lost} of {count} readings, which are left out: {why}"
            )
    return found


def baseline_problem(simulation: FingerSimulation, off: Errors) -> InferenceProblem:
    """The problem without causes, whose baseline is the model at any moduli and walls."""
    measurement = simulation.measurement
    listed = measurement.listed
    n = len(listed)
    std = max(t.setup.nuisances["modulus"] for t in measurement.tests)
    applied = measurement.applied(simulation.config)
    # one factor changes the moduli of one material
    free = len({str(moduli(each)) for each in applied}) == 1 and std > 0
    std = std if free else 1e-6
    ends = np.log(simulation.centre) + np.log(POLICY.stiffest) * np.array([-1.0, 1.0])
    if simulation.softest:
        ends[0] = np.log(simulation.softest)
    ends = ends / std if free else np.array([-1.0, 1.0])
    low, high = map(float, ends)
    factor = factor_of_moduli(std, low, high, (MODULUS,) if free else ())
    nodes = nodes_of(ends)
    spread = simulation.wall_std
    known = sorted(simulation.walls)
    values = []
    for c in map(float, factor.at(nodes)):
        by = c / simulation.centre
        told = [simulation.read(simulation.walls[walls], by) for walls in known]
        told = told or [simulation.base_at(c)]
        values.append([np.nan_to_num(each - simulation.base.readings) for each in told])
    told_values = np.array(values)
    zeta = (np.array(known)[:, None] - 1) / spread if spread else np.zeros((1, 0))
    slopes = np.zeros((len(nodes), len(zeta), zeta.shape[1], n))
    if spread:
        slopes[:] = np.nan
    own = [Coordinate.within(-1.0, 1.0)] if spread else []
    every = SimulatedChanges(zeta, told_values, slopes, nodes)
    baseline: Emulator = trained_on(every, own, off.noise, share=1.0, left_out=())
    always = [factor]
    if spread:
        key, wall_mm = wall(simulation.applied)
        prior, reach = Prior(wall_mm, wall_mm * spread, "as reported"), POLICY.walls_reach
        always.append(Unknown(key, prior, -reach, reach, role="always", names=(WALLS,)))
    if simulation.own:
        baseline = Stacked.of(baseline, _linear(simulation, off, nodes, factor, len(always) - 1))
        always += simulation.own
    return InferenceProblem(
        listed["value"].to_numpy(), simulation.base.readings, tuple(always), {},
        off.covariance, kernel(off.along), {}, baseline,
    )  # fmt: skip


def _linear(
    simulation: FingerSimulation, off: Errors, nodes: np.ndarray, factor: Unknown, first: int
) -> Emulator:
    """Emulate what the body's own numbers change, by their slopes at the base simulation.

    Args:
        simulation: of the model.
        off: its errors.
        nodes: ζ of the moduli.
        factor: c by it.
        first: how many of the model's numbers stand between these and the moduli.
    """
    own, base, centre = simulation.own, simulation.base, simulation.centre
    factors = factor.at(nodes) / centre if simulation.scales else np.ones(len(nodes))
    rates = [each.prior.spread * (centre if each.modulus else 1.0) for each in own]
    slopes = np.array([
        [simulation.read(base, by, each.key) * rate for each, rate in zip(own, rates, strict=True)]
        for by in factors
    ])  # fmt: skip
    d = len(own)
    steps = np.eye(d, first + d, first)
    known = np.full((len(nodes), d, first + d, slopes.shape[2]), np.nan)
    known[:, :, first:] = slopes[:, None]
    straight = [
        Coordinate(lambda zeta: zeta, amplitude=True, of=first + i, rate=1.0) for i in range(d)
    ]
    told = SimulatedChanges(steps, slopes, known, nodes)
    return trained_on(told, straight, off.noise, degree=1, share=1.0, left_out=())


def _feasible(config: Config, number: Unknown) -> Unknown:
    """Return a number within those that a body can be built of."""
    ends = []
    for sign in (-1.0, 1.0):
        end = 0.0
        while end < POLICY.walls_reach:
            try:
                changed(config, number.change(float(number.at(sign * (end + POLICY.read_beyond)))))
            except ConfigError:
                break
            end += POLICY.read_beyond
        ends.append(sign * end)
    low, high = ends
    return replace(number, low=low, high=high, role="always")


def spread(even: np.ndarray) -> np.ndarray:
    """ζ of moduli, nearer to one another where these are as told, from evenly spread numbers."""
    return np.asarray(np.sinh(MODEL.closer * even) / MODEL.closer)


def even(zeta: float | np.ndarray) -> np.ndarray:
    """The inverse of :func:`spread`."""
    return np.asarray(np.arcsinh(MODEL.closer * np.asarray(zeta)) / MODEL.closer)


def nodes_of(ends: np.ndarray) -> np.ndarray:
    """ζ of the moduli that a simulation is read at.

    Args:
        ends: range of ζ, shape (2,).
    """
    low, high = even(ends)
    return spread(np.linspace(low, high, POLICY.nodes))


def fitted_moduli(
    plain: InferenceProblem, simulation: FingerSimulation, *, scaled: bool = True
) -> float:
    """The fitted factor of all moduli; that of the simulation where this serves there, too.

    In few steps, so that another measurement of the finger finds its simulations. Where moduli
    scale the simulation, a stiffer finger is read from it at lower pressures. Where the model does
    not follow the readings, its moduli do what some cause may have done, and are left as they are
    as far as the simulation reaches.

    Args:
        plain: the model without causes.
        simulation: that it is of.
        scaled: whether moduli scale what is to be simulated at that factor.
    """
    fit, known = _fitted(plain), simulation.centre
    factor = float(plain.factor.at(fit.zeta[0]))
    softer = stiffer = POLICY.near_enough
    if simulation.scales:
        softer = POLICY.recentred if fit.level else softer
        stiffer = POLICY.stiffer if fit.level or scaled else stiffer
    if 1 / softer <= factor / known <= stiffer:
        return known
    step = np.log(POLICY.recentred)
    return float(np.exp(step * np.round(np.log(factor) / step)))


def plain_fit(plain: InferenceProblem, level: CovarianceModel) -> MapFit:
    """The fit of the model without causes, under one discrepancy; its numbers may be far off."""
    rest = np.zeros(plain.nuisance_count - 1)
    return level.of(tuple(plain.implausible)).fit([np.r_[start, rest] for start in POLICY.starts])


def _fitted(plain: InferenceProblem) -> MapFit:
    """The fit under whichever discrepancy the model without causes needs."""
    fits = [plain_fit(plain, level) for level in plain.levels.values()]
    return max(fits, key=lambda fit: fit.log_evidence + np.log(LEVELS[fit.level]))


def first_pass(
    measurement: Measurement,
    config: Config,
    workers: Workers,
    say: Callable[[str], None] = silent,
) -> FingerSimulation:
    """The model on the coarsest mesh that bears the load, with moduli that follow the readings.

    Args:
        measurement: of fingers, and of coupons beside them.
        config: the model that is diagnosed.
        workers: where simulations are computed and kept.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    say("simulating the measurement as configured")
    found: list[FingerSimulation] = []
    for mesh in coarser(config):
        told = FingerSimulation(
            measurement, config, workers, mesh, found[-1].centre if found else 1.0
        )
        for _ in range(POLICY.passes):
            reached = np.isfinite(told.base_at(told.centre))
            plain = baseline_problem(told, errors_of(told)).rows(reached)
            # walls are not fitted yet: they may take their part
            centre = fitted_moduli(plain, told)
            if centre == told.centre:
                break
            say(f"the moduli are about {centre:.2g} times those configured; simulating there")
            told = replace(told, centre=centre)
        told = truncate_before_failure(told)
        if found and _count_reached(told) <= _count_reached(found[-1]):
            break
        found.append(told)
        if _count_reached(told) == len(told.plain.readings):
            break
    return found[-1]


def refine_until_consistent(rough: FingerSimulation) -> FingerSimulation:
    """The whole simulation, its causes on a finer mesh where the graded one reads otherwise.

    Args:
        rough: of the first pass.

    Raises:
        ConfigError: one line, where the model cannot be simulated.
    """
    every = coarser(rough.config)
    for mesh in every[every.index(rough.flat) :]:
        found = replace(rough, flat=mesh).refined()
        if _off(found) < POLICY.coarse:
            break
    return found


def truncate_before_failure(simulation: FingerSimulation) -> FingerSimulation:
    """Simulate no farther than it comes, where it ends beyond the readings.

    To find out where a path ends takes many times what comes before.
    """
    headroom = simulation.headroom
    for run in simulation.plain.runs:
        values = np.abs(run.schedule.value)
        reached = min((len(v) for v in run.result.columns.values() if len(v)), default=0)
        rows = max(float(np.abs(leg.rows_at).max()) for leg in run.schedule.legs if leg.rows.size)
        if run.result.failure is not None and reached > 1:
            headroom = min(headroom, max(MODEL.reached * float(values[reached - 1]) / rows, 1.0))
    if headroom == simulation.headroom:
        return simulation
    return replace(simulation, headroom=headroom)


def _count_reached(rough: FingerSimulation) -> int:
    return int(np.isfinite(rough.plain.readings).sum())


def _off(found: FingerSimulation) -> float:
    """Largest difference of a channel between both meshes, by its size; root mean squares."""
    graded, plain = found.base.readings, found.plain.readings
    off = []
    for own in found.measurement.channels().values():
        mine = own & np.isfinite(graded + plain)
        size = float(np.square(graded[mine]).mean())
        off.append(float(np.square(graded[mine] - plain[mine]).mean()) / size if size else 0.0)
    return float(np.sqrt(max(off)))


def model(
    measurement: Measurement, config: Config, workers: Workers, say: Callable[[str], None]
) -> tuple[FingerSimulation, Errors, InferenceProblem]:
    """The model without causes, simulated where its moduli and walls follow the readings."""
    rough = first_pass(measurement, config, workers, say)
    simulation: FingerSimulation | None = None
    for _ in range(POLICY.passes):
        say("simulating the measurement on a graded mesh")
        try:
            simulation = refine_until_consistent(rough)
        except NothingReached as error:
            if simulation is None:
                raise
            # readings that were measured exclude moduli at which the finger ends before them
            say(f"{error}; the moduli are stiffer")
            simulation = replace(simulation, softest=simulation.centre / simulation.headroom)
        off = errors_of(simulation)
        plain = baseline_problem(simulation, off)
        while (walls := _beyond(simulation, plain)) is not None:
            say(f"the walls are about {walls:.2g} times as thick as configured; simulating there")
            simulation = replace(simulation, tried_walls=(*simulation.tried_walls, walls))
            plain = baseline_problem(simulation, off)
        centre = fitted_moduli(plain, simulation)
        if centre == simulation.centre or simulation.softest:
            break
        say(f"the moduli are about {centre:.2g} times those configured; simulating there")
        other = replace(rough, flat=simulation.flat, centre=centre, headroom=ROUTES.headroom)
        rough = truncate_before_failure(other)
    assert simulation is not None
    return simulation, off, plain


def _beyond(simulation: FingerSimulation, plain: InferenceProblem) -> float | None:
    """Walls by those configured that the readings ask for, in few steps.

    None where they do not ask beyond those that were simulated.
    """
    known, tried = simulation.walls, simulation.tried_walls
    if not known:
        return None
    prior = plain.always[1].prior
    walls = prior.at(float(_fitted(plain).zeta[1])) / prior.at(0.0)
    step = MODEL.walls_by / 2
    walls = float(np.round(step * np.round(walls / step), 9))
    if min(known) <= walls <= max(known) or walls in tried or walls <= 0:
        return None
    return walls
