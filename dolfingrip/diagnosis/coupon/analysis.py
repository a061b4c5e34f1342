"""An analysis of coupons: emulators of all causes, and one covariance of all errors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.answer.errors import Errors, errors_of, kernel
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.emulator import Emulator, Scaled
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.polynomial import linear, places, trained
from dolfingrip.diagnosis.core.problem import InferenceProblem, Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, pairs_above, searched_again
from dolfingrip.diagnosis.core.unknown import (
    MODULUS,
    Cause,
    Factor,
    Unknown,
    causes,
    factor_of_moduli,
)
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.data.measurement import in_proportion
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import Nuisance
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import named


def errors(simulation: CouponSimulation) -> Errors:
    """Return the errors of a measurement's coupons, with their covariance.

    Args:
        simulation: of the coupons.
    """
    base = simulation.base()

    def reported(factor: np.ndarray) -> list[Nuisance]:
        """Numbers of the configuration that the laboratory gave a standard deviation."""
        return [
            Nuisance(
                Unknown.marginal(key, std, named(key).unit),
                (simulation.base(moved={key: std}) - base) * factor,
            )
            for key, std in simulation.measurement.tests[0].setup.nuisances.items()
            if "." in key and std
        ]

    return errors_of(simulation, base, np.nan_to_num(simulation.slopes()), reported)


@dataclass(frozen=True, eq=False)
class CouponAnalysis(Analysis[CouponSimulation]):
    """Coupons, and what could explain them."""

    closed_form: ClassVar = True

    @property
    def configured(self) -> np.ndarray:
        return self.problem.base

    def exact(self, fit: MapFit) -> np.ndarray:
        return self.readings(fit.subset, fit.zeta[None], self.simulation)[0]

    def simulated(
        self, fit: MapFit, addition: Proposal | None = None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Simulate a fit; NaN where there is no equilibrium."""
        simulation, rig = self.simulation, addition is None
        if addition is not None:
            simulation = CouponSimulation(addition.measurement, simulation.config)
        high = np.vstack([self.problem.baseline_box, self.problem.box(fit.subset)])[:, 1]
        steps = np.where(fit.zeta + POLICY.step > high, -POLICY.step, POLICY.step)
        every = np.vstack([fit.zeta, fit.zeta + np.diag(steps)])
        first, *moved = self.readings(fit.subset, every, simulation, rig=rig)
        return first, (np.array(moved) - first).T / steps

    def covariances(
        self, addition: Proposal, readings: np.ndarray
    ) -> tuple[np.ndarray, float | np.ndarray]:
        """Return those by the stiffness of a new coupon, which is another specimen."""
        scatter = self.errors.scatter
        stiff = max(scatter.scale, scatter.prior_scale) * readings
        return np.outer(stiff, stiff), 0.0

    def readings(
        self, subset: Subset, zeta: np.ndarray, simulation: CouponSimulation, *, rig: bool = True
    ) -> np.ndarray:
        """Exact readings at many places, (places, m); NaN where there is no equilibrium.

        Args:
            subset: the hypothesis.
            zeta: its numbers, shape (places, d).
            simulation: of these coupons, or of others.
            rig: whether numbers of the rig that are far out are so there, too.
        """
        problem, places = self.problem, self.problem.places(subset)
        found = np.tile(simulation.base(), (len(zeta), 1))
        if acting := [name for name in places if name not in problem.rig]:
            own = np.concatenate([places[name] for name in acting])
            found += simulation.changed([self.causes[name] for name in acting], zeta[:, own])
        scaled = in_proportion(simulation.measurement)
        found *= np.where(scaled, problem.factor(zeta[:, :1]), 1.0)
        for name in [each for each in places if rig and each in problem.rig]:
            emulator = problem.emulators[name]
            found += emulator.at(zeta[:, np.r_[0, places[name]]]) @ emulator.columns.T
        return found

    def verified(
        self, posterior: ModelPosterior, say: Callable[[str], None]
    ) -> tuple[CouponAnalysis, ModelPosterior, float]:
        """Simulate likely pairs together, and causes about their fits where emulators miss."""
        coupons, rng = self, np.random.default_rng(0)
        likely = pairs_above(posterior, POLICY.joint)
        if likely:
            say(f"simulating {len(likely)} pairs of causes together")
            corrections = {
                pair: _beyond(coupons, pair, self.problem.box(pair))
                for pair in likely
                if len(self.problem.effects(pair)) > 1
            }
            coupons = replace(self, problem=replace(self.problem, corrections=corrections))
        posterior = searched_again(coupons.problem, posterior, rng)
        inexact = _inexact_fits(coupons, posterior)
        if inexact:
            say("simulating likely causes anew about their fits")
            coupons = refined(coupons, inexact)
            posterior = searched_again(coupons.problem, posterior, rng)
        while True:
            best = sensitivity(posterior)[0].best
            left = coupons.emulator_error(best, coupons.exact(best))
            if np.isfinite(left):
                return coupons, posterior, left
            posterior = _without(posterior, coupons.problem.effects(best.subset))


def _without(posterior: ModelPosterior, effects: Subset) -> ModelPosterior:
    """Without effects at whose numbers some reading has no equilibrium: no emulator tells that."""
    own = [posterior.problem.effects(fit.subset) == effects for fit in posterior.fits]
    rest = np.where(own, 0.0, posterior.probability + np.finfo(float).tiny)
    return replace(posterior, probability=rest / rest.sum())


def _inexact_fits(coupons: CouponAnalysis, posterior: ModelPosterior) -> list[MapFit]:
    """Likely fits of those causes whose emulator is not exact there."""
    total: dict[Subset, float] = defaultdict(float)
    likely: dict[Subset, list[MapFit]] = defaultdict(list)
    for p, fit in posterior.weighed:
        effects = coupons.problem.effects(fit.subset)
        total[effects] += p
        if p > POLICY.joint:
            likely[effects].append(fit)
    return [
        fit
        for effects, fits in likely.items()
        if effects and total[effects] > POLICY.verified
        and max(coupons.emulator_error(each, coupons.exact(each)) for each in fits) > POLICY.exact
        for fit in fits
    ]  # fmt: skip


def analyse_coupons(
    simulation: CouponSimulation,
    names: Sequence[str] | None = None,
    say: Callable[[str], None] = lambda text: None,
) -> CouponAnalysis:
    """Simulate what every cause changes about the coupons, and make emulators of it.

    Args:
        simulation: of coupons that are
            :func:`~dolfingrip.diagnosis.coupon.simulation.in_closed_form`.
        names: of the causes that are tried; the whole catalogue where None.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the configured material has no equilibrium at some reading.
    """
    say("simulating what each effect changes about the coupons")
    measurement, base = simulation.measurement, simulation.base()
    if not np.isfinite(base).all():
        raise ConfigError(
            "coupons: the configured material has no equilibrium at some reading; allowed: a "
            "smaller coupon.max_strain, or another material"
        )
    off = errors(simulation)
    emulators: dict[str, Emulator] = {}
    boxes: dict[str, np.ndarray] = {}
    felt: dict[str, Cause] = {}
    unseen: list[str] = []
    rig: set[str] = set()
    for cause in causes(simulation.config, names):
        feels = effect(cause.name).felt_on(EXPERIMENTS["coupon"].parts)
        found = _emulated(simulation, cause, off) if feels else None
        if found is None:
            unseen.append(cause.name)
            continue
        felt[cause.name] = cause
        emulators[cause.name], boxes[cause.name] = found, cause.box()
    for each in off.shared:  # where it is implausible it is a cause
        if np.abs(each.change / off.noise).max(initial=0.0) > POLICY.invisible:
            rig.add(each.name)
            felt[each.name] = each.unknown.implausible()
            emulators[each.name] = linear(POLICY.implausible_width * each.change)
            boxes[each.name] = felt[each.name].box()
    setups = [test.setup.nuisances for test in measurement.tests]
    std = float(max(np.hypot(each["modulus"], each["coupon_area"]) for each in setups))
    reach = float(np.log(POLICY.scaled_by) / max(std, POLICY.least_std))
    factor = Factor.of(std, -reach, reach)
    scaled = in_proportion(measurement)
    problem = InferenceProblem(
        measurement.listed()["value"].to_numpy(), base,
        (factor_of_moduli(factor, (MODULUS, "coupon_area")),),
        {name: Scaled.of(each, scaled, factor) for name, each in emulators.items()},
        off.covariance, kernel(off.along), boxes, Scaled.alone(base, scaled, factor),
        rig=frozenset(rig),
    )  # fmt: skip
    return CouponAnalysis(problem, felt, off, simulation, tuple(unseen))


def refined(coupons: CouponAnalysis, fits: Sequence[MapFit]) -> CouponAnalysis:
    """The problem with emulators that are exact about some fits, where all of these are likely.

    Args:
        coupons: the problem.
        fits: of likely hypotheses, several of the same causes where levels differ.
    """
    problem = coupons.problem
    corrections, local = dict(problem.corrections), dict(problem.local)
    for effects in dict.fromkeys(problem.effects(fit.subset) for fit in fits):
        if not effects:
            continue
        ends = []
        wide = problem.box(effects)
        for fit in fits:
            if problem.effects(fit.subset) == effects:
                own = slice(1, 1 + len(wide))
                std = np.sqrt(np.diag(np.linalg.inv(fit.hessian)))[own]
                ends.append(fit.zeta[own] + POLICY.near * np.outer([-1, 1], np.maximum(std, 0.02)))
        reached = np.vstack(ends)
        box = np.column_stack([reached.min(axis=0), reached.max(axis=0)])
        box = np.clip(box, wide[:, :1], wide[:, 1:])
        corrections[effects] = _beyond(coupons, effects, box, POLICY.fewer)
        local[effects] = box
    return replace(coupons, problem=replace(problem, corrections=corrections, local=local))


def _beyond(
    coupons: CouponAnalysis, effects: Subset, box: np.ndarray, part: float = 1.0
) -> Emulator:
    """Emulate what causes change together beyond the sum of their emulators, within a box of ζ.

    The sum is not exact: a coupon that is pulled harder changes its volume more.
    """
    problem = coupons.problem
    count = POLICY.training[min(len(box), len(POLICY.training)) - 1]
    zeta = places(box, int(part * count))
    together = coupons.simulation.changed([coupons.causes[name] for name in effects], zeta)
    at = 0
    for name in effects:
        d = len(problem.boxes[name])
        emulator = problem.emulators[name]
        alone = np.column_stack([np.zeros(len(zeta)), zeta[:, at : at + d]])
        together = together - emulator.at(alone) @ emulator.columns.T
        at += d
    solved = np.isfinite(together).all(axis=1)
    stretches = [each for name in effects for each in coupons.causes[name].stretches]
    found = trained(zeta[solved], together[solved], coupons.errors.noise, box, stretches)
    return Scaled.of(found, coupons.scaled, problem.factor)


def _emulated(simulation: CouponSimulation, cause: Cause, off: Errors) -> Emulator | None:
    """The emulator of a cause; None where no reading feels it."""
    box = cause.box()
    count = POLICY.training[min(len(box), len(POLICY.training)) - 1]
    zeta = places(box, count)
    changes = simulation.changed([cause], zeta)
    solved = np.isfinite(changes).all(axis=1)
    white = changes[solved] / off.noise
    if solved.sum() < 2 * len(box) + 2 or np.sqrt((white**2).mean(axis=1)).max() < POLICY.invisible:
        return None
    return trained(zeta[solved], changes[solved], off.noise, box, cause.stretches)
