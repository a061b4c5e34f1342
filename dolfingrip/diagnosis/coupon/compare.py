"""All hypotheses of coupons alone, compared in closed form, in seconds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from dolfingrip.config import Config
from dolfingrip.diagnosis.core.case import Case, Subset
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior, search, searched_again
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.coupon.case import CouponCase, coupon_case
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
    for _ in range(POLICY.rounds):
        corrected = _corrected(coupons, posterior)
        if corrected is coupons.case:
            break
        say("simulating likely causes at their fits")
        coupons = replace(coupons, case=corrected)
        posterior = searched_again(corrected, posterior)
    posterior = searched_again(coupons.case, posterior, rng)
    decision, under = sensitivity(posterior)
    left = _left(coupons, decision.best, coupons.exact(decision.best))
    return CouponDiagnosis(config, coupons, posterior, decision, under, left)


def _left(coupons: CouponCase, fit: Fit, exact: np.ndarray) -> float:
    """Largest difference between emulator and exact simulation, (n,), at a fit, by the noise."""
    told = coupons.case.predicted(fit.subset, fit.zeta)
    return float(np.abs((exact - told) / coupons.errors.noise).max())


def _corrected(coupons: CouponCase, posterior: Posterior) -> Case:
    """The case with simulations at the fits of those likely causes that it is not exact at."""
    found = coupons.case
    likely: dict[Subset, float] = defaultdict(float)
    for subset, p in posterior.subsets.items():
        likely[found.causes(subset)] += p
    for causes, p in likely.items():
        if causes and p > POLICY.verified:
            fit = posterior.best(causes)
            exact = np.column_stack(coupons.simulated(fit, coupons.simulation))
            if _left(coupons, fit, exact[:, 0]) > POLICY.exact:
                found = found.corrected(fit.subset, fit.zeta, exact)
    return found
