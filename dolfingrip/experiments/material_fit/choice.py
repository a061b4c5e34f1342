"""The law that is chosen of those fitted: stable, as good as the best, with fewest constants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfingrip.experiments.material_fit import material_file
from dolfingrip.experiments.material_fit.coupons import MODES, Series
from dolfingrip.experiments.material_fit.fit import Fit
from dolfingrip.experiments.material_fit.homogeneous import Mode, stable_to
from dolfingrip.experiments.material_fit.policy import POLICY


@dataclass(frozen=True, slots=True)
class Choice:
    """The law that is chosen.

    Attributes:
        best: its fit.
        reasons: sentences that say why it is, and why better fits are not.
    """

    best: Fit
    reasons: tuple[str, ...]


def choose(fits: Sequence[Fit], data: Sequence[Series]) -> Choice:
    """Choose a law.

    A law qualifies if it is stable by Drucker's criterion in all three modes of tension, up to the
    largest measured stretch: a finger's wall is stretched along two directions, whatever the
    coupons were. If none is, those qualify that are stable where they were measured, else those
    that a configuration can have, else all. Of those that qualify and whose relative rms is at most
    ``POLICY.equal`` larger than the smallest, the one with the fewest constants is chosen, and of
    several the one with the smallest criterion.

    Args:
        fits: fits of the laws.
        data: series that they were fitted to.
    """
    farthest = max(float(series.stretch.max()) for series in data)
    usable = [fit for fit in fits if material_file.allowed(fit)]
    everywhere = dict.fromkeys(MODES, farthest)
    measured = {
        mode: max(float(series.stretch.max()) for series in data if series.mode == mode)
        for mode in {series.mode for series in data}
    }
    stable = [fit for fit in usable if not unstable(fit, everywhere)]
    where = f"stable (Drucker) in all modes of tension up to a stretch of {farthest:.3g}"
    if not stable:
        stable = [fit for fit in usable if not unstable(fit, measured)]
        where = "stable (Drucker) where it was measured, which no law is in all modes of tension"
    if not stable:
        stable = usable or list(fits)
        where = "none of the laws is stable (Drucker) where it was measured"
    least = min(fit.relative_rms for fit in stable)
    equal = [fit for fit in stable if fit.relative_rms <= (1 + POLICY.equal) * least]
    best = min(equal, key=lambda fit: (len(fit.values), fit.criterion))
    reasons = [f"{best.law.title} is chosen: {where}; rms {100 * best.relative_rms:.2g} %"]
    if len(equal) > 1:
        others = "; ".join(fit.law.title for fit in equal if fit is not best)
        reasons[0] += (
            f"; {len(best.values)} constants, no more than laws that fit as well: {others}"
        )
    reasons += [
        f"{fit.law.title} is not chosen: not stable (Drucker) in {mode} tension beyond a stretch "
        f"of {most:.3g}; the data go to {farthest:.3g}"
        for fit in fits
        if not any(fit is each for each in stable)
        and fit.relative_rms <= (1 + POLICY.equal) * best.relative_rms
        for mode, most in list(unstable(fit, everywhere).items())[-1:]
    ]
    return Choice(best, tuple(reasons))


def unstable(fit: Fit, stretches: dict[Mode, float]) -> dict[Mode, float]:
    """Modes in which a law becomes unstable before these stretches, and where it does."""
    ends = {mode: stable_to(fit.law, mode, fit.values)[1] for mode in stretches}
    return {mode: most for mode, most in ends.items() if most < stretches[mode]}
