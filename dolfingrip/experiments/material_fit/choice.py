"""The law that is chosen of those fitted, and what coupons do not determine of it.

It is stable, as good as the best, and has the fewest constants.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from dolfingrip.experiments.material_fit.coupons import MODES, CouponSeries, farthest
from dolfingrip.experiments.material_fit.fit import (
    EQUAL,
    FINEST,
    LOOSE,
    MIDDLE_STRETCH,
    WITHIN,
    LawFit,
    allowed,
    measured_MPa,
    predicted_MPa,
    residual_variance,
    tolerances_MPa,
)
from dolfingrip.experiments.material_fit.law import Mode, unstable_from


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
    ``EQUAL`` larger than the smallest, or below ``FINEST``, the one with the fewest
    constants is chosen, and of several the one with the smallest criterion. A stable law with no
    more constants and a smaller criterion takes its place: its scatter is within what was asked.

    Args:
        fits: fits of the laws.
        data: series that they were fitted to.
    """
    reached = farthest(data)
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
    enough = max((1 + EQUAL) * min(fit.scatter for fit in stable), FINEST)
    equal = [fit for fit in stable if fit.scatter <= enough]
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
        if not any(fit is candidate for candidate in stable)
        and fit.relative_rms <= (1 + EQUAL) * best.relative_rms
        for line in instabilities(fit, reached)[-1:]
    ]
    return LawChoice(best, tuple(reasons))


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


def doubts(fit: LawFit, data: Sequence[CouponSeries]) -> list[str]:
    """Return sentences on values, combinations and modes of tension that the data leave open.

    Args:
        fit: the fitted law.
        data: series that it was fitted to.
    """
    return [*_values(fit), *_combination(fit), *_modes(fit, data), *_ratio(fit, data),
            *instabilities(fit, farthest(data))]  # fmt: skip


def _names(fit: LawFit) -> list[str]:
    return [key.rpartition(".")[2].replace("_MPa", "") for key in fit.law.keys]


def _values(fit: LawFit) -> list[str]:
    loose = [
        name
        for name, value, half in zip(_names(fit), fit.values, fit.half_width, strict=True)
        if half > abs(value)
    ]
    if not loose:
        return []
    return [f"not fixed by these data (interval wider than the value): {', '.join(loose)}"]


def _combination(fit: LawFit) -> list[str]:
    """The direction of the largest relative change of the values that the data allow."""
    if len(fit.values) == 1:
        return []
    size = np.maximum(np.abs(fit.values), 1e-12 * np.abs(fit.values).max())
    spread, ways = np.linalg.eigh(fit.covariance / np.outer(size, size))
    half = WITHIN * np.sqrt(max(float(spread[-1]), 0.0))
    if half < 1:
        return []
    way = ways[:, -1] / np.abs(ways[:, -1]).max()
    moved = [
        f"{name} {'+' if part * way[np.argmax(np.abs(way))] > 0 else '−'}{abs(part):.2g}"
        for name, part in zip(_names(fit), way, strict=True)
        if abs(part) > 0.05
    ]
    together = " with ".join(moved)
    return [f"free: {together} (parts of each value) hardly changes the fit"]


def _modes(fit: LawFit, data: Sequence[CouponSeries]) -> list[str]:
    measured = " and ".join(sorted({series.mode for series in data}, key=MODES.index))
    at, sentences = np.array([min(MIDDLE_STRETCH, farthest(data))]), []
    for mode in _open_modes(data):
        middle, half = (float(values[0]) for values in fit.band(mode, at))
        if half > LOOSE * abs(middle):
            sentences.append(
                f"{measured} tension does not fix the {mode} response: at a stretch of {at[0]:.3g} "
                f"{middle:.3g} ± {half:.2g} MPa (90 %); a coupon in {mode} tension would fix it"
            )
    return sentences


def _open_modes(data: Sequence[CouponSeries]) -> list[Mode]:
    """Modes of tension in which nothing was measured."""
    measured = {series.mode for series in data}
    return [mode for mode in MODES if mode not in measured]


def _ratio(fit: LawFit, data: Sequence[CouponSeries]) -> list[str]:
    """A sentence on ratios C01/C10 that fit equally well, the other factors being refitted."""
    keys = [key.rpartition(".")[2] for key in fit.law.keys]
    if not {"C10_MPa", "C01_MPa"} <= set(keys) or len(keys) < 3:
        return []
    ratios = np.linspace(0.0, 2.0, 201)
    low, high = accepted(fit, data, ratios)
    if low is None or high is None or high - low < 0.1:
        return []
    top = "at least 2" if high >= ratios[-1] else f"{high:.2g}"
    return [
        f"C01/C10 from {low:.2g} to {top} fits equally, the other factors refitted; it decides the "
        "equibiaxial response, and with it ballooning: measure in equibiaxial or planar tension"
    ]


def apart(fits: Sequence[LawFit], data: Sequence[CouponSeries]) -> list[str]:
    """Return sentences on modes of tension in which laws that fit equally well differ.

    Laws fit equally well if their misfit is below one tolerance for each reading, or below twice
    the smallest misfit.

    Args:
        fits: the fitted laws.
        data: series that they were fitted to.
    """
    least = min(fit.misfit for fit in fits)
    equal = [fit for fit in fits if fit.misfit <= max(fit.count, 2 * least)]
    at, sentences = np.array([min(MIDDLE_STRETCH, farthest(data))]), []
    for mode in _open_modes(data) if len(equal) > 1 else ():
        stresses = [(float(fit.band(mode, at)[0][0]), fit.law.title) for fit in equal]
        (low, soft), (high, stiff) = min(stresses), max(stresses)
        if high - low > LOOSE * abs(high):
            sentences.append(
                f"laws that fit equally well differ in {mode} tension: at a stretch of {at[0]:.3g} "
                f"from {low:.3g} ({soft}) to {high:.3g} MPa ({stiff})"
            )
    return sentences


def accepted(
    fit: LawFit, data: Sequence[CouponSeries], ratios: np.ndarray
) -> tuple[float | None, float | None]:
    """Smallest and largest of ``ratios`` C01/C10 whose misfit is within a 90 % interval.

    Args:
        fit: fit of a law that is linear in its values; C10 and C01 are among them.
        data: data that it was fitted to.
        ratios: ratios that are tried.
    """
    keys = [key.rpartition(".")[2] for key in fit.law.keys]
    tolerance = tolerances_MPa(data)
    basis = np.stack(
        [predicted_MPa(fit.law, data, unit) for unit in np.eye(len(keys))], axis=1
    ) / tolerance[:, None]  # fmt: skip
    target = measured_MPa(data) / tolerance
    first, second = keys.index("C10_MPa"), keys.index("C01_MPa")
    others = [i for i in range(len(keys)) if i not in (first, second)]
    best = _least(basis, target)
    variance = residual_variance(best, len(keys), fit.effective, data)
    allowed = best + WITHIN**2 * variance * fit.count / fit.effective
    within = [
        float(ratio)
        for ratio in ratios
        if _least(
            np.column_stack([basis[:, first] + ratio * basis[:, second], basis[:, others]]), target
        )
        <= allowed
    ]
    return (min(within), max(within)) if within else (None, None)


def _least(basis: np.ndarray, target: np.ndarray) -> float:
    values = np.linalg.lstsq(basis, target)[0]
    return float(np.sum((basis @ values - target) ** 2))
