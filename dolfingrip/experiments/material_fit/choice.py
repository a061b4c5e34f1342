"""The law that is chosen of those fitted: stable, as good as the best, with fewest constants."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dolfingrip.experiments.material_fit.coupons import MODES, CouponSeries, farthest
from dolfingrip.experiments.material_fit.fit import LawFit, allowed
from dolfingrip.experiments.material_fit.homogeneous import Mode, unstable_from


@dataclass(frozen=True, slots=True)
class LawChoice:
    """The law that is chosen.

    Attributes:
        best: its fit.
        reasons: sentences that say why it is, and why better fits are not.
    """

    best: LawFit
    reasons: tuple[str, ...]


def choose(fits: Sequence[LawFit], data: Sequence[CouponSeries]) -> LawChoice:
    """Choose a law.

    A law qualifies if it is stable by Drucker's criterion in all three modes of tension, up to the
    largest measured stretch: a finger's wall is stretched along two directions, whatever the
    coupons were. If none is, those qualify that are stable where they were measured, else those
    that a configuration can have, else all. Of those that qualify and whose scatter is at most
    ``policy.equal`` larger than the smallest, or below ``policy.finest``, the one with the fewest
    constants is chosen, and of several the one with the smallest criterion. A stable law with no
    more constants and a smaller criterion takes its place: its scatter is within what was asked.

    Args:
        fits: fits of the laws.
        data: series that they were fitted to.
    """
    reached, policy = farthest(data), fits[0].policy
    usable = [fit for fit in fits if allowed(fit)]
    everywhere = dict.fromkeys(MODES, reached)
    measured = {
        mode: farthest(series for series in data if series.mode == mode)
        for mode in {series.mode for series in data}
    }
    stable = [fit for fit in usable if not unstable(fit, everywhere)]
    where = f"stable (Drucker) in all modes of tension up to a stretch of {reached:.3g}"
    if not stable:
        stable = [fit for fit in usable if not unstable(fit, measured)]
        where = "stable (Drucker) where it was measured, which no law is in all modes of tension"
    if not stable:
        stable = usable or list(fits)
        where = "none of the laws is stable (Drucker) where it was measured"
    enough = max((1 + policy.equal) * min(map(_scatter, stable)), policy.finest)
    equal = [fit for fit in stable if _scatter(fit) <= enough]
    best = min(equal, key=lambda fit: (len(fit.values), fit.criterion))
    simpler = [
        fit for fit in stable
        if len(fit.values) <= len(best.values) and fit.criterion < best.criterion
    ]  # fmt: skip
    best = min(simpler, key=lambda fit: fit.criterion, default=best)
    reasons = [f"{best.law.title} is chosen: {where}; rms {100 * best.relative_rms:.2g} %"]
    if len(equal) > 1:
        count = len(best.values)
        constants = f"{count} constant" if count == 1 else f"{count} constants"
        others = "; ".join(fit.law.title for fit in equal if fit is not best)
        reasons[0] += f"; {constants}, no more than laws that fit as well: {others}"
    reasons += [
        f"{fit.law.title} is not chosen: {line}"
        for fit in fits
        if not any(fit is each for each in stable)
        and fit.relative_rms <= (1 + policy.equal) * best.relative_rms
        for line in instabilities(fit, reached)[-1:]
    ]
    return LawChoice(best, tuple(reasons))


def _scatter(fit: LawFit) -> float:
    """Return the relative scatter of readings about a law, estimated without bias.

    Each constant takes one degree of freedom from the residuals.
    """
    return fit.relative_rms * (fit.count / (fit.count - len(fit.values))) ** 0.5


def instabilities(fit: LawFit, reached: float) -> list[str]:
    """Return a sentence on each mode of tension in which a law becomes unstable.

    Args:
        fit: the law with its values.
        reached: largest measured stretch.
    """
    return [
        f"not stable (Drucker) in {mode} tension beyond a stretch of {end:.3g}; the data go to "
        f"{reached:.3g}"
        for mode, end in unstable(fit, dict.fromkeys(MODES, reached)).items()
    ]


def unstable(fit: LawFit, stretches: Mapping[Mode, float]) -> dict[Mode, float]:
    """Find the modes of tension in which a law becomes unstable.

    Args:
        fit: the law with its values.
        stretches: stretch up to which instabilities are sought, by mode.

    Returns:
        The stretch from which on the law is unstable, of each mode in which there is one.
    """
    ends = {
        mode: unstable_from(fit.law, mode, fit.values, highest)
        for mode, highest in stretches.items()
    }
    return {mode: end for mode, end in ends.items() if end is not None}
