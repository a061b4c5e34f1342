"""All hypotheses of coupons alone, compared in closed form, in seconds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.case import Subset
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior, pairs_above, search, searched_again
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.coupon.case import CouponCase, coupon_case, refined, with_pairs
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis
from dolfingrip.diagnosis.coupon.simulation import Kept
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import POLICY


def compared(
    measurement: Measurement,
    config: Config,
    names: Sequence[str] | None = None,
    *,
    say: Callable[[str], None] = lambda text: None,
    kept: Kept | None = None,
) -> CouponDiagnosis:
    """Find out what the simulation gets wrong about coupons, and why, up to the answer.

    Args:
        measurement: of coupons that stretch evenly.
        config: the model that is diagnosed.
        names: of the causes that are tried; the whole catalogue where None.
        say: told what is being done.
        kept: what was simulated before of coupons of this set-up on this way; it grows.

    Raises:
        ConfigError: one line, where the configured material has no equilibrium at some reading.
    """
    say("simulating what each effect changes about the coupons")
    coupons = coupon_case(measurement, config, names, kept)
    say("comparing all causes, alone and in pairs")
    rng = np.random.default_rng(0)
    posterior = search(coupons.case, rng, sample=False)
    likely = pairs_above(posterior, POLICY.joint)
    if likely:
        say(f"simulating {len(likely)} pairs of causes together")
        coupons = with_pairs(coupons, likely)
    posterior = searched_again(coupons.case, posterior, rng)
    far_off = _far_off(coupons, posterior)
    if far_off:
        say("simulating likely causes anew about their fits")
        coupons = refined(coupons, far_off)
        posterior = searched_again(coupons.case, posterior, rng)
    while True:
        decision, under = sensitivity(posterior)
        best = decision.best
        left = _left(coupons, best)
        if np.isfinite(left):
            return CouponDiagnosis(config, coupons, posterior, decision, under, left)
        posterior = _without(posterior, coupons.case.effects(best.subset))


def _without(posterior: Posterior, effects: Subset) -> Posterior:
    """Without effects at whose numbers some reading has no equilibrium: no emulator tells that."""
    own = [posterior.case.effects(fit.subset) == effects for fit in posterior.fits]
    rest = np.where(own, 0.0, posterior.probability + np.finfo(float).tiny)
    return replace(posterior, probability=rest / rest.sum())


def _left(coupons: CouponCase, fit: Fit) -> float:
    """Largest difference between emulator and exact simulation at a fit, by the noise."""
    told = coupons.case.predicted(fit.subset, fit.zeta)
    return float(np.abs((coupons.exact(fit) - told) / coupons.errors.noise).max())


def _far_off(coupons: CouponCase, posterior: Posterior) -> list[Fit]:
    """Likely fits of those causes whose emulator is not exact there."""
    total: dict[Subset, float] = defaultdict(float)
    likely: dict[Subset, list[Fit]] = defaultdict(list)
    for p, fit in zip(posterior.probability, posterior.fits, strict=True):
        effects = coupons.case.effects(fit.subset)
        total[effects] += float(p)
        if p > POLICY.joint:
            likely[effects].append(fit)
    return [
        fit
        for effects, fits in likely.items()
        if effects and total[effects] > POLICY.verified
        and max(_left(coupons, each) for each in fits) > POLICY.exact
        for fit in fits
    ]  # fmt: skip
