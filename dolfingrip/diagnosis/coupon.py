"""An analysis of coupons: their readings in closed form, emulators of all causes, and errors.

Readings are computed for many sets of an effect's numbers at once.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from dolfingrip.channels import FORCE, TIME, TRANSVERSE_STRAIN
from dolfingrip.config import NO_CHANGE, Change, Config, ConfigError, changed
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.analysis import Analysis, told_error
from dolfingrip.diagnosis.answer.discrepancy import kernel
from dolfingrip.diagnosis.answer.errors import Errors, errors_of
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.emulator import Emulator, Scaled, linear, places, trained
from dolfingrip.diagnosis.core.evidence import InferenceProblem, MapFit, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, search
from dolfingrip.diagnosis.core.unknown import (
    MODULUS,
    Cause,
    Nuisance,
    Unknown,
    factor_of_moduli,
)
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.simulated import ModelReadings, SimulationGroup, groups
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.experiments.rigs.uniaxial import UniaxialTension
from dolfingrip.extensions.effect import Energetic
from dolfingrip.extensions.index import effect
from dolfingrip.jobs.run import Say, silent
from dolfingrip.parameter import named


def in_closed_form(measurement: Measurement, config: Config) -> bool:
    """Tell whether all tests are coupons that stretch evenly, and forces and widths are read.

    Args:
        measurement: the tests.
        config: the model that is diagnosed.
    """
    applied = measurement.applied(config)
    known = {FORCE.name, TRANSVERSE_STRAIN.name}
    return set(measurement.listed["column"]) <= known and all(
        test.experiment == "coupon" and own.coupon.grip != "clamped" and not _sheared(own)
        for test, own in zip(measurement.tests, applied, strict=True)
    )


def _sheared(config: Config) -> bool:
    raster = getattr(config.extensions, "print_anisotropy")  # noqa: B009
    return raster is not None and bool(raster.raster_deg)


Solved = Sequence[tuple[SimulationGroup, Mapping[str, np.ndarray]]]
"""Readings at each group's stops, (places, stops) by column."""


class CouponSimulation:
    """Simulates the coupons of a measurement.

    Args:
        measurement: of coupons alone.
        config: the model that is diagnosed.
    """

    closed_form: ClassVar = True

    def __init__(self, measurement: Measurement, config: Config) -> None:
        self.measurement = measurement
        self.config = config
        self.groups: Sequence[SimulationGroup] = groups(measurement, config)
        self.mesh = np.zeros(len(measurement.listed))

    @cached_property
    def _plain(self) -> Solved:
        """Readings of the model as configured."""
        return self._solved({}, {})

    @cached_property
    def base(self) -> ModelReadings:
        """The model as configured."""
        shown = self._displayed({}, self._plain)[0]
        return ModelReadings(shown, self._read(self._plain, derivative=1)[0], {})

    @property
    def configured(self) -> np.ndarray:
        return self.base.readings

    @cached_property
    def rig(self) -> Sequence[Nuisance]:
        """Numbers that the laboratory told a deviation of by their key."""
        found = []
        for key, std in self.measurement.tests[0].setup.nuisances.items():
            if "." in key and std:
                moved = self._displayed({}, self._solved({}, {}, {key: std}))[0]
                number = Unknown.marginal(key, std, named(key).unit)
                found.append(Nuisance(number, moved - self.base.readings))
        return found

    def of(self, measurement: Measurement, *, known_mesh: bool = True) -> CouponSimulation:
        """Return the simulator of other coupons; these have no mesh."""
        return CouponSimulation(measurement, self.config)

    def at(self, values: Change, steps: Sequence[tuple[Unknown, float]] = ()) -> ModelReadings:
        """Simulate other values, and differences by steps of some; NaN without equilibrium."""
        moved = {}
        for place, (number, step) in enumerate(steps, 1):
            here = np.array(values[number.key], dtype=float)
            moved[number.key] = np.stack([here] * (1 + len(steps)))
            moved[number.key][place] += step
        first, *others = self._many({**values, **moved}, 1 + len(steps))
        slopes = {
            number.gradient: (other - first) / step
            for (number, step), other in zip(steps, others, strict=True)
        }
        by_log = np.where(in_proportion(self.measurement), first, 0.0)
        return ModelReadings(first, np.zeros_like(first), {**slopes, MODULUS: by_log})

    def changed(self, cause: Cause, zeta: np.ndarray) -> np.ndarray:
        """(places, n) changes by a cause; NaN without equilibrium.

        Args:
            cause: an effect that is not on.
            zeta: its numbers, shape (places, d).
        """
        every = {
            number.key: number.at(zeta[:, [i]] if number.listed else zeta[:, i])
            for i, number in enumerate(cause.numbers)
        }
        held = [number.change(value) for number, value in cause.held]
        fixed = {key: value for each in held for key, value in each.items()}
        return self._many({**fixed, **every}, len(zeta)) - self.base.readings

    def _many(self, values: Change, count: int) -> np.ndarray:
        """(places, n) readings at values by key; arrays hold one for each place, (places, …)."""
        along = {key: each for key, each in values.items() if isinstance(each, np.ndarray)}
        material = {
            key for key in values
            if not key.startswith("extensions.") or issubclass(effect(key.split(".")[1]), Energetic)
        }  # fmt: skip
        every = [
            {**values, **{key: each[place].tolist() for key, each in along.items()}}
            for place in range(1 if material >= along.keys() else count)
        ]
        own = {key: each for key, each in along.items() if key in material}
        solved = self._solved(every[0], own) if material else self._plain
        if len(every) < count:
            return self._displayed(every[0], solved)
        shown = []
        for place, one in enumerate(every):
            rows = [
                (group, {name: _row(values, place) for name, values in columns.items()})
                for group, columns in solved
            ]
            shown.append(self._displayed(one, rows)[0])
        return np.vstack(shown)

    def _solved(
        self,
        overrides: Change,
        parameters: Mapping[str, np.ndarray],
        moved: Mapping[str, float] = NO_CHANGE,
    ) -> Solved:
        """True readings at each group's stops, (places, stops) by column."""
        found = []
        for group in self.groups:
            config = changed(group.config, overrides)
            places = {key: named(key).value(config) + by for key, by in moved.items()}
            config = changed(config, places).adapted()
            coupon, route = config.coupon, group.in_time
            strain = [value / coupon.gauge_length_mm for value in route.value]
            pulled = UniaxialTension(config).pull(
                parameters, strain, route.time_s, coupon.step_strain
            )
            width = np.where(np.isfinite(pulled.stress_MPa), pulled.across - 1, np.nan)
            force_N = pulled.stress_MPa * coupon.area_mm2
            found.append((group, {FORCE.name: force_N, TRANSVERSE_STRAIN.name: width}))
        return found

    def _displayed(self, overrides: Change, solved: Solved) -> np.ndarray:
        """(places, n) what the instruments show."""
        shown = [
            (group, changed(group.config, overrides).extensions.displayed(
                {**values, TIME.name: np.array(group.in_time.time_s)}))
            for group, values in solved
        ]  # fmt: skip
        return self._read(shown)

    def _read(self, solved: Solved, derivative: int = 0) -> np.ndarray:
        """(places, n) readings, or their derivatives by the travel."""
        count = len(self.measurement.readings)
        return self.measurement.collected({
            group.tests: {
                name: group.in_time.at_rows(columns[name], count, derivative)
                for name in (FORCE.name, TRANSVERSE_STRAIN.name)
            }
            for group, columns in solved
        })  # fmt: skip


def _row(values: np.ndarray, place: int) -> np.ndarray:
    """One place's readings; all places' where they are the same for all."""
    return values[place : place + 1] if len(values) > 1 else values


@dataclass(frozen=True, eq=False)
class CouponAnalysis(Analysis[CouponSimulation]):
    """Coupons, and what could explain them."""

    def exact(self, fit: MapFit) -> np.ndarray:
        return self.simulated(fit, derived=False)[0]

    def covariances(
        self, addition: Proposal, readings: np.ndarray
    ) -> tuple[np.ndarray, float | np.ndarray]:
        """Return those by the stiffness of a new coupon, which is another specimen."""
        scatter = self.errors.scatter
        stiff = max(scatter.scale, scatter.prior_scale) * readings
        return np.outer(stiff, stiff), 0.0

    def verified(
        self, posterior: ModelPosterior, say: Say
    ) -> tuple[CouponAnalysis, ModelPosterior, float]:
        """Simulate likely causes at their fits; emulators learn what they miss there.

        A pair may look unlikely because its emulators do not know how one cause acts on the other.
        So every pair that may stand in the place of the leading fit is simulated, too.
        """
        coupons, known = self, defaultdict[Subset, list[tuple[MapFit, float]]](list)
        posterior = search(self.problem, np.random.default_rng(0), before=posterior)
        for _ in range(POLICY.rounds):
            told = []
            for fit in coupons._doubtful(posterior, known):
                exact = np.column_stack(coupons.simulated(fit))
                missed = coupons.emulator_error(fit, exact[:, 0])
                known[coupons.problem.effects(fit.subset)].append((fit, missed))
                if missed > POLICY.exact and np.isfinite(exact).all():
                    told.append((fit.subset, fit.zeta, exact))
            if not told:
                break
            say(f"comparing all causes anew, by simulations at {len(told)} fits")
            coupons = replace(coupons, problem=coupons.problem.corrected(told))
            changed = [coupons.problem.causes(subset) for subset, _, _ in told]
            posterior = search(
                coupons.problem, np.random.default_rng(0), before=posterior, changed=changed
            )
        # of effects at whose numbers some reading has no equilibrium no emulator tells
        impossible: dict[Subset, float] = {}
        while True:
            best = sensitivity(posterior)[0].best
            left = coupons.emulator_error(best, coupons.exact(best))
            if np.isfinite(left):
                return coupons, posterior, left
            impossible[coupons.problem.effects(best.subset)] = np.inf
            posterior = posterior.weakened(impossible, coupons.problem.effects)

    def _doubtful(
        self, posterior: ModelPosterior, known: Mapping[Subset, Sequence[tuple[MapFit, float]]]
    ) -> Iterator[MapFit]:
        """Fits that simulations may change: of likely effects, and of pairs with a leading one.

        Args:
            posterior: of all hypotheses.
            known: fits that were simulated, and what emulators missed there, by their effects.
        """
        effects = self.problem.effects
        leading = {*effects(sensitivity(posterior)[0].best.subset)}
        probability = posterior.by(lambda fit: effects(fit.subset))
        likely = posterior.leaders(lambda fit: effects(fit.subset))
        exactly = posterior.leaders(lambda fit: (effects(fit.subset), fit.level))
        for own, fit in likely.items():
            if own and probability[own] > POLICY.joint:
                if not any(np.array_equal(each.zeta, fit.zeta) for each, _ in known[own]):
                    yield fit
            elif len(own) > 1 and leading & {*own}:
                fit = exactly[own, 0.0]
                left = told_error(known[own], fit)
                if left > POLICY.surer * POLICY.exact and {*own} <= {*fit.visible}:
                    yield fit


def analyse_coupons(
    simulation: CouponSimulation, causes: Sequence[Cause], say: Say = silent
) -> CouponAnalysis:
    """Simulate what every cause changes about the coupons, and make emulators of it.

    Args:
        simulation: of coupons that are
            :func:`~dolfingrip.diagnosis.coupon.in_closed_form`.
        causes: that are tried.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the configured material has no equilibrium at some reading.
    """
    say("simulating what each effect changes about the coupons")
    measurement, base = simulation.measurement, simulation.base.readings
    if not np.isfinite(base).all():
        raise ConfigError(
            "coupons: the configured material has no equilibrium at some reading; allowed: a "
            "smaller coupon.max_strain, or another material"
        )
    off = errors_of(simulation)
    emulators: dict[str, Emulator] = {}
    every = {cause.name: cause for cause in causes}
    for name, cause in every.items():
        feels = effect(name).felt_on(EXPERIMENTS["coupon"].parts)
        if feels and (found := _emulated(simulation, cause, off)):
            emulators[name] = found
    unseen = tuple(name for name in every if name not in emulators)
    rig = {  # where it is implausible it is a cause
        each.name: each.unknown.implausible() for each in off.shared
        if np.abs(each.change / off.noise).max(initial=0.0) > POLICY.invisible
    }  # fmt: skip
    shared = {each.name: each.change for each in off.shared}
    emulators |= {name: linear(POLICY.implausible_width * shared[name]) for name in rig}
    felt = {name: {**every, **rig}[name] for name in emulators}
    setups = [test.setup.nuisances for test in measurement.tests]
    std = float(max(np.hypot(each["modulus"], each["coupon_area"]) for each in setups))
    reach = float(np.log(POLICY.scaled_by) / max(std, POLICY.least_std))
    factor = factor_of_moduli(std, -reach, reach, (MODULUS, "coupon_area"))
    scaled = in_proportion(measurement)
    problem = InferenceProblem(
        measurement.listed["value"].to_numpy(), base,
        (factor,),
        {name: Scaled.of(each, scaled, factor) for name, each in emulators.items()},
        off.covariance, kernel(off.along), {name: each.box() for name, each in felt.items()},
        Scaled.alone(base, scaled, factor), rig=frozenset(rig),
        tails={name: each.tails for name, each in felt.items()},
    )  # fmt: skip
    return CouponAnalysis(problem, felt, off, simulation, unseen)


def _emulated(simulation: CouponSimulation, cause: Cause, off: Errors) -> Emulator | None:
    """The emulator of a cause; None where no reading feels it."""
    box = cause.box()
    zeta = places(box, POLICY.training[min(len(box), len(POLICY.training)) - 1])
    changes = simulation.changed(cause, zeta)
    solved = np.isfinite(changes).all(axis=1)
    zeta, changes = zeta[solved], changes[solved]
    sizes = np.sqrt(((changes / off.noise) ** 2).mean(axis=1))
    if len(zeta) < 2 * len(box) + 2 or sizes.max() < POLICY.invisible:
        return None
    return trained(zeta, changes, off.noise, box)
