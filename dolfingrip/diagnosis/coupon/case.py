"""A measurement of coupons as a case: emulators of all causes, and the covariance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.answer.analysed import Analysed
from dolfingrip.diagnosis.answer.errors import Errors
from dolfingrip.diagnosis.core import discrepancy
from dolfingrip.diagnosis.core.case import Case, Subset
from dolfingrip.diagnosis.core.emulator import Emulator, linear, places, trained
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.numbers import Cause, UnknownNumber, causes
from dolfingrip.diagnosis.core.scaled import Factor, Scaled
from dolfingrip.diagnosis.coupon.errors import errors
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation, Kept
from dolfingrip.diagnosis.data.measurement import Measurement, in_proportion
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.diagnosis.simulation.nuisances import Nuisance
from dolfingrip.extensions.effect import Prior


@dataclass(frozen=True, eq=False)
class CouponCase(Analysed[CouponSimulation]):
    """Coupons, and what could explain them."""

    def exact(self, fit: Fit) -> np.ndarray:
        """(n,) readings by an exact simulation at a fit's numbers, linear nuisances left out."""
        return self.readings(fit.subset, fit.zeta[None], self.simulation)[0]

    def simulated(
        self, subset: Subset, zeta: np.ndarray, simulation: CouponSimulation, *, rig: bool = True
    ) -> tuple[np.ndarray, np.ndarray]:
        """Readings, (m,), and their derivatives by ζ, (m, d); see :meth:`readings`."""
        high = np.vstack([self.case.ground_box, self.case.box(subset)])[:, 1]
        steps = np.where(zeta + POLICY.step > high, -POLICY.step, POLICY.step)
        every = np.vstack([zeta, zeta + np.diag(steps)])
        first, *moved = self.readings(subset, every, simulation, rig=rig)
        return first, (np.array(moved) - first).T / steps

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
        case, places = self.case, self.case.places(subset)
        found = np.tile(simulation.base(), (len(zeta), 1))
        if acting := [name for name in places if name in self.causes]:
            own = np.concatenate([places[name] for name in acting])
            found += simulation.changed([self.causes[name] for name in acting], zeta[:, own])
        scaled = in_proportion(simulation.measurement)
        found *= np.where(scaled, case.factor(zeta[:, :1]), 1.0)
        for name in [each for each in places if rig and each in self.far]:
            emulator = case.emulators[name]
            found += emulator.at(zeta[:, np.r_[0, places[name]]]) @ emulator.columns.T
        return found


def coupon_case(
    measurement: Measurement,
    config: Config,
    names: Sequence[str] | None = None,
    kept: Kept | None = None,
) -> CouponCase:
    """Simulate what every cause changes about the coupons, and make emulators of it.

    Args:
        measurement: of coupons that :func:`~dolfingrip.diagnosis.coupon.simulation.in_closed_form`.
        config: the model that is diagnosed.
        names: of the causes that are tried; the whole catalogue where None.
        kept: what was simulated before of coupons of this set-up on this way; it grows.

    Raises:
        ConfigError: one line, where the configured material has no equilibrium at some reading.
    """
    simulation = CouponSimulation(measurement, config, kept)
    base = simulation.base()
    if not np.isfinite(base).all():
        raise ConfigError(
            "coupons: the configured material has no equilibrium at some reading; allowed: a "
            "smaller coupon.max_strain, or another material"
        )
    off = errors(simulation)
    emulators: dict[str, Emulator] = {}
    boxes: dict[str, np.ndarray] = {}
    felt: dict[str, Cause] = {}
    far: dict[str, Cause] = {}
    unseen: list[str] = []
    for cause in causes(config, names):
        found = _emulated(simulation, cause, off)
        if found is None:
            unseen.append(cause.name)
            continue
        felt[cause.name] = cause
        emulators[cause.name], boxes[cause.name] = found, cause.box()
    for each in off.shared:  # far from what was told, it is a cause
        if np.abs(each.change / off.noise).max(initial=0.0) > POLICY.invisible:
            far[each.name] = _far(each)
            emulators[each.name] = linear(POLICY.far * each.change)
            boxes[each.name] = far[each.name].box()
    setups = [test.setup.nuisances for test in measurement.tests]
    std = float(max(np.hypot(each["modulus"], each["coupon_area"]) for each in setups))
    reach = float(np.log(POLICY.scaled_by) / max(std, POLICY.least_std))
    factor = Factor(std, -reach, reach)
    scaled = in_proportion(measurement)
    case = Case(
        measurement.listed()["value"].to_numpy(), base, factor,
        {name: Scaled.of(each, scaled, factor) for name, each in emulators.items()},
        off.covariance, discrepancy.kernel(off.along), boxes, Scaled.alone(base, scaled, factor),
        rig=frozenset(far),
        ground_names=(("modulus", "coupon_area"),),
    )  # fmt: skip
    return CouponCase(case, felt, off, simulation, tuple(unseen), far=far)


def _far(shared: Nuisance) -> Cause:
    """A number of the rig, in its unit, that may be far from what was told."""
    prior = Prior(0.0, POLICY.far * shared.std, "far from what was told")
    any_value = (-np.inf, np.inf)
    number = UnknownNumber(
        shared.name, prior, -POLICY.reach, POLICY.reach, any_value, amplitude=True, listed=False
    )
    return Cause(shared.name, (number,), ())


def with_pairs(coupons: CouponCase, pairs: Sequence[Subset]) -> CouponCase:
    """The case with what pairs of causes change beyond the sum of what each changes alone.

    The sum is not exact: a coupon that is pulled harder changes its volume more.
    """
    mended: dict[Subset, Emulator] = {}
    for pair in pairs:
        if len(coupons.case.effects(pair)) > 1:
            box = np.vstack([coupons.causes[name].box() for name in pair])
            mended[pair] = _beyond(coupons, pair, box)
    return replace(coupons, case=replace(coupons.case, mended=mended))


def refined(coupons: CouponCase, fits: Sequence[Fit]) -> CouponCase:
    """The case with emulators that are exact about some fits, where all of these are likely.

    Args:
        coupons: the case.
        fits: of likely hypotheses, several of the same causes where levels differ.
    """
    case = coupons.case
    mended, local = dict(case.mended), dict(case.local)
    for effects in dict.fromkeys(case.effects(fit.subset) for fit in fits):
        if not effects:
            continue
        ends = []
        wide = np.vstack([coupons.causes[name].box() for name in effects])
        for fit in fits:
            if case.effects(fit.subset) == effects:
                own = slice(1, 1 + len(wide))
                std = np.sqrt(np.diag(np.linalg.inv(fit.hessian)))[own]
                ends.append(fit.zeta[own] + POLICY.near * np.outer([-1, 1], np.maximum(std, 0.02)))
        reached = np.vstack(ends)
        box = np.column_stack([reached.min(axis=0), reached.max(axis=0)])
        box = np.clip(box, wide[:, :1], wide[:, 1:])
        mended[effects] = _beyond(coupons, effects, box, POLICY.fewer)
        local[effects] = box
    return replace(coupons, case=replace(case, mended=mended, local=local))


def _beyond(coupons: CouponCase, effects: Subset, box: np.ndarray, part: float = 1.0) -> Emulator:
    """What causes change together beyond the sum of their emulators, within a box of ζ."""
    case = coupons.case
    count = POLICY.training[min(len(box), len(POLICY.training)) - 1]
    zeta = places(box, int(part * count))
    together = coupons.simulation.changed([coupons.causes[name] for name in effects], zeta)
    at = 0
    for name in effects:
        d = len(case.boxes[name])
        emulator = case.emulators[name]
        alone = np.column_stack([np.zeros(len(zeta)), zeta[:, at : at + d]])
        together = together - emulator.at(alone) @ emulator.columns.T
        at += d
    solved = np.isfinite(together).all(axis=1)
    found = trained(zeta[solved], together[solved], coupons.errors.noise, box)
    return Scaled.of(found, coupons.scaled, case.factor)


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
    return trained(zeta[solved], changes[solved], off.noise, box)
