"""A diagnosis of coupons alone: all hypotheses compared in closed form, in seconds."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.additions.protocols import Proposal
from dolfingrip.diagnosis.additions.worth import PredictedAddition, Rival
from dolfingrip.diagnosis.answer.diagnosis import Diagnosis, left
from dolfingrip.diagnosis.core.decision import sensitivity
from dolfingrip.diagnosis.core.evidence import MapFit
from dolfingrip.diagnosis.core.problem import Subset
from dolfingrip.diagnosis.core.search import ModelPosterior, pairs_above, search, searched_again
from dolfingrip.diagnosis.coupon.analysis import (
    CouponAnalysis,
    analyse_coupons,
    refined,
    with_pairs,
)
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation, Kept
from dolfingrip.diagnosis.data.measurement import Measurement
from dolfingrip.diagnosis.policy import POLICY
from dolfingrip.extensions.index import effect
from dolfingrip.parameter import scaled


@dataclass(eq=False)
class CouponDiagnosis(Diagnosis):
    """Everything that was found about coupons."""

    analysis: CouponAnalysis

    load: ClassVar[str] = "strain"
    beside: ClassVar[str] = "each coupon's own stiffness and slack"

    @property
    def model(self) -> Config:
        return self.config

    def setup_deviations(self, fit: MapFit) -> dict[str, float]:
        weighed, _ = left(self.analysis, fit)
        found = {each.name: float(each.change @ weighed) for each in self.analysis.errors.shared}
        for name, places in self.analysis.problem.places(fit.subset).items():
            if name in found:
                found[name] += POLICY.implausible_width * float(fit.zeta[places[0]])
        return found

    def as_configured(self) -> np.ndarray:
        return self.analysis.problem.base

    def with_best_modulus(self) -> np.ndarray:
        """(n,) readings as configured but for the modulus, the one that leaves least."""
        problem, scaled = self.analysis.problem, self.analysis.scaled
        proportional = problem.base * scaled
        square = float(proportional @ proportional)
        factor = float(proportional @ problem.value) / square if square > 0 else 1.0
        return np.where(scaled, factor, 1.0) * problem.base

    def hidden(self) -> str:
        unseen = self.analysis.unseen
        material = [n for n in unseen if effect(n).kind in ("elastic", "dissipative")]
        rest = [n for n in unseen if n not in material]
        sentences = []
        if material:
            sentences.append(f"{', '.join(material)} (other readings of coupons may tell)")
        if rest:
            sentences.append(f"what only a finger or another instrument feels: {', '.join(rest)}")
        return "; ".join(sentences)

    def cautions(self) -> list[str]:
        scatter = self.analysis.errors.scatter
        if not (scatter.estimated and scatter.scale > POLICY.scatters * scatter.prior_scale):
            return []
        return [
            f"the specimens' stiffness scatters by {100 * scatter.scale:.2g} %, where "
            f"{100 * scatter.prior_scale:.2g} % is believed (nuisance.specimen_scale)"
        ]

    def predict_addition(self, proposal: Proposal, fits: Sequence[MapFit]) -> PredictedAddition:
        other = CouponSimulation(proposal.measurement, self.config)
        # the rig's own errors are others then, and a new coupon is another specimen
        after = [
            Rival(e.zeta, *self.analysis.simulated(e.subset, e.zeta, other, rig=False))
            for e in fits
        ]
        scatter = self.analysis.errors.scatter
        stiff = max(scatter.scale, scatter.prior_scale) * after[0].readings
        return after, np.outer(stiff, stiff), 0.0, False

    def advice(self) -> str:
        decision, rig = self.decision, self.analysis.problem.rig
        if decision.answer == "unknown":
            return "a coupon, up and down at two rates: it would tell memory from elasticity"
        if decision.answer == "none":
            return "measure the finger: the coupons agree with the model"
        if decision.nuisance_only:
            return "measure the coupons' cross-section: it is told from the modulus by nothing else"
        named = [n for n in (*decision.first, *decision.second) if n not in rig]
        if self._once() and any(effect(name).kind == "dissipative" for name in named):
            return (
                "a coupon, loading and unloading, with a wait of 60 s between: the curve's shape "
                "alone tells memory here; a loop and a force that fades would prove it"
            )
        return "measure the finger: no other cause is nearly as probable as the first"

    def _once(self) -> bool:
        """Tell whether each coupon was pulled once, and no more."""
        listed = self.analysis.measurement.listed()
        return len(listed.groupby(["cycle", "branch"])) == 1

    def overrides(self, fit: MapFit) -> Change:
        factor = self.analysis.factor(fit)
        return {**scaled(self.config, factor), **self.analysis.at(fit, factor)}


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
    coupons = analyse_coupons(measurement, config, names, kept)
    say("comparing all causes, alone and in pairs")
    rng = np.random.default_rng(0)
    posterior = search(coupons.problem, rng, sample=False)
    likely = pairs_above(posterior, POLICY.joint)
    if likely:
        say(f"simulating {len(likely)} pairs of causes together")
        coupons = with_pairs(coupons, likely)
    posterior = searched_again(coupons.problem, posterior, rng)
    inexact = _inexact_fits(coupons, posterior)
    if inexact:
        say("simulating likely causes anew about their fits")
        coupons = refined(coupons, inexact)
        posterior = searched_again(coupons.problem, posterior, rng)
    while True:
        decision, under = sensitivity(posterior)
        best = decision.best
        left = coupons.emulator_error(best, coupons.exact(best))
        if np.isfinite(left):
            return CouponDiagnosis(config, coupons, posterior, decision, under, left)
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
