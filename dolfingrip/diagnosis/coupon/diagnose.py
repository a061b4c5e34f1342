"""A diagnosis of coupons alone: every hypothesis in closed form, in seconds."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.core.search import Posterior, pairs_above, search
from dolfingrip.diagnosis.core.sensitivity import sensitivity
from dolfingrip.diagnosis.coupon.case import CouponCase, coupon_case, with_pairs
from dolfingrip.diagnosis.coupon.found import CouponDiagnosis, exact
from dolfingrip.diagnosis.coupon.gain import held_out
from dolfingrip.diagnosis.coupon.next_experiment import next_experiments
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.data.suspicion import suspicions
from dolfingrip.diagnosis.policy import POLICY


def diagnose_coupons(
    measurement: Measurement,
    config: Config,
    names: Sequence[str] | None = None,
    *,
    quick: bool = False,
    say: Callable[[str], None] = lambda text: None,
) -> CouponDiagnosis:
    """Find out what the simulation gets wrong about coupons, and why.

    Args:
        measurement: of coupons that stretch evenly.
        config: the model that is diagnosed.
        names: of the causes that are tried; the whole catalogue where None.
        quick: measure no gain and propose nothing.
        say: told what is being done.

    Raises:
        ConfigError: one line, where the configured material has no equilibrium at some reading.
    """
    say("simulating what each effect changes about the coupons")
    coupons = coupon_case(measurement, config, names)
    if not np.isfinite(coupons.case.base).all():
        raise ConfigError(
            "coupons: the configured material has no equilibrium at some reading; allowed: a "
            "smaller coupon.max_strain, or another material"
        )
    say("comparing all causes, alone and in pairs")
    posterior = search(coupons.case, np.random.default_rng(0), sample=False)
    likely = pairs_above(posterior, POLICY.joint)
    if likely:
        say(f"simulating {len(likely)} pairs of causes together")
        coupons = with_pairs(coupons, likely)
    posterior = search(coupons.case, np.random.default_rng(0))
    decision, under = sensitivity(posterior)
    found = CouponDiagnosis(
        config, coupons, posterior, decision, under, _left(coupons, posterior, decision.best)
    )
    found.suspicions = [each.sentence() for each in suspicions(measurement, coupons.case.base)]
    found.warnings = [*measurement.warnings, *_cautions(found)]
    if quick or decision.answer != "cause":
        return found
    say("measuring the gain on readings that are left out")
    found.held_out = held_out(coupons, posterior, exact)
    say("looking for the next experiment")
    found.next = next_experiments(coupons, posterior, decision)
    return found


def _left(coupons: CouponCase, posterior: Posterior, fit: object) -> float:
    """Largest difference between emulator and exact simulation at a fit, by the noise."""
    best = posterior.best(fit.subset)  # type: ignore[attr-defined]
    told = coupons.case.predicted(best.subset, best.zeta)
    return float(np.abs((exact(coupons, best) - told) / coupons.errors.noise).max())


def _cautions(found: CouponDiagnosis) -> list[str]:
    scatter = found.coupons.errors.scatter
    told = []
    if scatter.estimated and scatter.scale > 1.5 * scatter.told_scale:
        told.append(
            f"the specimens' stiffness scatters by {100 * scatter.scale:.2g} %, where "
            f"{100 * scatter.told_scale:.2g} % is believed (nuisance.specimen_scale)"
        )
    if found.left_by_emulator > 1.0:
        told.append(
            f"the fit's fast model is off by {found.left_by_emulator:.2g} standard deviations of "
            "the noise from an exact simulation at its numbers"
        )
    return told
