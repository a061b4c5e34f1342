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
        corrected = _corrected(coupons, posterior, rng)
        if corrected is coupons.case:
            break
        say("simulating likely causes at their fits")
        coupons = replace(coupons, case=corrected)
        posterior = searched_again(corrected, posterior)
    posterior = searched_again(coupons.case, posterior, rng)
    while True:
        decision, under = sensitivity(posterior)
        best = decision.best
        left = float(_left(coupons, best.subset, best.zeta[None])[0])
        if np.isfinite(left):
            return CouponDiagnosis(config, coupons, posterior, decision, under, left)
        posterior = _without(posterior, coupons.case.effects(best.subset))


def _without(posterior: Posterior, effects: Subset) -> Posterior:
    """Without effects at whose numbers some reading has no equilibrium: no emulator tells that."""
    own = [posterior.case.effects(fit.subset) == effects for fit in posterior.fits]
    rest = np.where(own, 0.0, posterior.probability + np.finfo(float).tiny)
    return replace(posterior, probability=rest / rest.sum())


def _left(coupons: CouponCase, effects: Subset, zeta: np.ndarray) -> np.ndarray:
    """Largest difference between emulators and exact simulations by the noise, shape (places,).

    Args:
        coupons: the case.
        effects: of the hypothesis.
        zeta: its numbers, shape (places, d).
    """
    told = [coupons.case.predicted(effects, each) for each in zeta]
    exact = coupons.readings(effects, zeta, coupons.simulation)
    return np.asarray(np.abs((exact - told) / coupons.errors.noise).max(axis=1))


def _corrected(coupons: CouponCase, posterior: Posterior, rng: np.random.Generator) -> Case:
    """The case with a simulation of each likely set of effects where its emulators are off.

    At the fit, or else at the worst of some draws about it. Numbers of the rig are linear.
    """
    case = found = coupons.case
    likely: dict[Subset, float] = defaultdict(float)
    best: dict[Subset, tuple[float, Fit]] = {}
    for p, fit in zip(posterior.probability, posterior.fits, strict=True):
        effects = case.effects(fit.subset)
        likely[effects] += float(p)
        if p > best.get(effects, (-1.0, fit))[0]:
            best[effects] = float(p), fit
    for effects, p in likely.items():
        if not effects or p < POLICY.verified:
            continue
        fit, places = best[effects][1], case.places(best[effects][1].subset)
        own = np.r_[np.arange(case.own), *(places[name] for name in effects)]
        middle, spread = fit.zeta[own], np.linalg.inv(fit.hessian)[np.ix_(own, own)]
        draws = rng.multivariate_normal(middle, spread, POLICY.held_against)
        box = np.vstack([case.ground_box, case.box(effects)])
        zeta = np.vstack([middle, np.clip(draws, *box.T)])
        left = np.nan_to_num(_left(coupons, effects, zeta))
        place = 0 if left[0] > POLICY.exact else int(left.argmax())
        if left[place] > POLICY.exact:
            exact = np.column_stack(coupons.simulated(effects, zeta[place], coupons.simulation))
            if np.isfinite(exact).all():  # beside a place there may be no equilibrium
                found = found.corrected(effects, zeta[place], exact)
    return found
