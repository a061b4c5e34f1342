"""Which further coupon would tell tied causes apart, from exact simulations of each."""

from __future__ import annotations

import numpy as np

from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.additions.worth import Comparison, Tied, tied
from dolfingrip.diagnosis.core.decision import Decision
from dolfingrip.diagnosis.core.evidence import Fit
from dolfingrip.diagnosis.core.search import Posterior
from dolfingrip.diagnosis.coupon.case import CouponCase
from dolfingrip.diagnosis.coupon.simulation import CouponSimulation
from dolfingrip.diagnosis.data.measurement import in_proportion
from dolfingrip.diagnosis.outcome import NextExperiment
from dolfingrip.diagnosis.policy import ADDITIONS


def next_experiments(
    coupons: CouponCase, posterior: Posterior, decision: Decision
) -> list[NextExperiment]:
    """Additions that tell the tied hypotheses apart, the best first; none where nothing is tied."""
    fits = tied(posterior, decision)
    if len(fits) < 2:
        return []
    simulation = coupons.simulation
    comparison = Comparison(
        simulation.measurement, coupons.errors.noise, coupons.case.covariance,
        np.array([p for p, _ in fits]), [_at(coupons, simulation, fit) for _, fit in fits],
    )  # fmt: skip
    scatter = coupons.errors.scatter
    std = max(scatter.scale, scatter.told_scale)
    found = []
    for proposal in proposals(simulation.measurement, simulation.config):
        other = CouponSimulation(proposal.measurement, simulation.config)
        after = [_at(coupons, other, fit) for _, fit in fits]
        stiff = std * after[0].readings  # a new coupon is another specimen
        found.append(comparison.worth(proposal, after, np.outer(stiff, stiff)))
    return sorted(found, key=lambda worth: worth.rank)


def _at(coupons: CouponCase, simulation: CouponSimulation, fit: Fit) -> Tied:
    """Exact readings of a hypothesis with derivatives by its numbers, the modulus' last."""
    case = coupons.case
    scaled = in_proportion(simulation.measurement)
    base = simulation.base()
    change = np.zeros(len(base))
    slopes: list[np.ndarray] = []
    c = coupons.factor(fit)
    factor = np.where(scaled, c, 1.0)
    for name, place in case.places(fit.subset).items():
        d, zeta = len(place), fit.zeta[place]
        if name in coupons.far:  # a nuisance of what was measured, another one next time
            slopes += [np.zeros(len(base))] * d
            continue
        cause = coupons.causes[name]
        low, high = case.boxes[name].T
        moved = np.clip(zeta + ADDITIONS.step * np.eye(d), low, high)
        all_changes = simulation.changed([cause], np.vstack([zeta, moved]))
        change += all_changes[0]
        for i in range(d):
            step = moved[i, i] - zeta[i]
            own = np.zeros(len(base))
            if step:
                own = (all_changes[1 + i] - all_changes[0]) / step
            slopes.append(factor * own)
    first = np.where(scaled, c * case.factor.std, 0.0) * (base + change)
    return Tied(fit.zeta, factor * (base + change), np.column_stack([first, *slopes]))
