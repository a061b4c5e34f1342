"""What readings do not tell: effects that hide behind other numbers, and what else would do."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from dolfingrip.diagnosis.answer.analysis import Analysis
from dolfingrip.diagnosis.core.evidence import LEVELS, NONE, MapFit, Subset, Visibility, taken
from dolfingrip.diagnosis.core.search import ModelPosterior
from dolfingrip.diagnosis.policy import ADDITIONS, POLICY


@dataclass(frozen=True, eq=False)
class Alternative:
    """A cause that follows the readings about as well as none does, other numbers being others.

    Attributes:
        fit: the hypothesis.
        factor: its evidence by that of none, or by the best.
        behind: numbers that take its change over.
        stronger: the same where its cause does one standard deviation more.
    """

    fit: MapFit
    factor: float
    behind: tuple[str, ...]
    stronger: MapFit


def hidden_effects(analysis: Analysis, none: MapFit) -> dict[str, tuple[str, ...]]:
    """List the effects of which less than what counts as visible is seen.

    Args:
        analysis: the readings with all that could explain them.
        none: fit without causes.

    Returns:
        The numbers that take an effect's change over, by its name; none where it is faint by
        itself.
    """
    problem = analysis.problem
    seen = Visibility(problem, none.zeta[: problem.nuisance_count])
    found: dict[str, tuple[str, ...]] = dict.fromkeys(analysis.unseen, ())
    for name, cause in analysis.effects.items():
        zeta = cause.at_strength(problem.boxes[name])
        if seen.strength(name, zeta) < POLICY.visible_sigma:
            _, found[name] = _taken(analysis, seen, seen.change(name, zeta))
    return found


def _taken(
    analysis: Analysis, seen: Visibility, change: np.ndarray
) -> tuple[float, tuple[str, ...]]:
    """Length of a change, (n,), by the noise alone, and the numbers that take most of it over."""
    noise = analysis.errors.noise
    alone = float(np.linalg.norm(change / noise))
    if alone < POLICY.visible_sigma:
        return alone, ()
    always, shared = analysis.problem.always, analysis.errors.shared
    names = [each.names[0] if each.names else each.key for each in always]
    names += [each.name for each in shared]
    columns = np.column_stack([seen.own, *(each.change for each in shared)]) / noise[:, None]
    parts = np.abs(taken(change / noise, columns)) * np.linalg.norm(columns, axis=0)
    order = np.argsort(parts)[::-1]
    return alone, tuple(names[i] for i in order if parts[i] >= 0.5 * parts.max())


def alternatives(
    analysis: Analysis, posterior: ModelPosterior, *, off: bool = False
) -> list[Alternative]:
    """List single causes that the readings do not exclude beside none, the likeliest first.

    Prior odds do not count: that none acts needs evidence as strong as that a cause does. A cause
    whose own change could not be seen, whatever else is free, is none of them.

    Args:
        analysis: the readings with all that could explain them.
        posterior: of all hypotheses.
        off: whether something is off, so that the best evidence counts in the place of none's.
    """
    problem, evidence = posterior.problem, _evidence(posterior)
    against = max(evidence.values()) if off else evidence[NONE]
    fits = {(each.subset, each.level): each for each in posterior.fits}
    found = []
    for subset, log in evidence.items():
        factor = float(np.exp(log - against))
        if len(subset) != 1 or problem.causes(subset) != subset or factor < np.exp(-ADDITIONS.tied):
            continue
        fit, own = fits[subset, 0.0], problem.nuisance_count
        seen = Visibility(problem, fit.zeta[:own])
        change = problem.predicted(subset, fit.zeta) - problem.predicted(NONE, seen.at)
        more = _room(analysis, fit, change)
        more_of_readings = problem.slopes(subset, fit.zeta)[:, own:] @ more[own:]
        alone, behind = _taken(analysis, seen, change + more_of_readings)
        if alone >= POLICY.implausible_sigma:
            box = np.vstack([problem.baseline_box, problem.box(subset)])
            stronger = replace(fit, zeta=np.clip(fit.zeta + more, *box.T))
            found.append(Alternative(fit, factor, behind, stronger))
    return sorted(found, key=lambda each: -each.factor)


def _room(analysis: Analysis, fit: MapFit, change: np.ndarray) -> np.ndarray:
    """(d,) the step of ζ that changes most by a fit's causes, one standard deviation of these.

    Its sign is that of the change so far, (n,); the model's own numbers follow.
    """
    own = analysis.problem.nuisance_count
    slopes = analysis.problem.slopes(fit.subset, fit.zeta)[:, own:]
    covariance = np.linalg.inv(fit.hessian)
    lower = np.linalg.cholesky(covariance[own:, own:])
    white = slopes @ lower / analysis.errors.noise[:, None]
    way = np.linalg.svd(white, full_matrices=False)[2][0]
    step = covariance[:, own:] @ np.linalg.solve(lower.T, way)
    return np.asarray(step if (slopes @ lower @ way) @ change >= 0 else -step)


def _evidence(posterior: ModelPosterior) -> dict[Subset, float]:
    """ln p(y) of each set of causes, by all levels of a discrepancy."""
    logs: dict[Subset, list[float]] = defaultdict(list)
    for fit in posterior.fits:
        logs[fit.subset].append(fit.log_evidence + float(np.log(LEVELS[fit.level])))
    return {subset: float(np.logaddexp.reduce(each)) for subset, each in logs.items()}


def in_words(hidden: Mapping[str, tuple[str, ...]]) -> str:
    """Tell effects that cannot be seen by the numbers that they hide behind.

    Args:
        hidden: these numbers, by the names of the effects.
    """
    groups: dict[tuple[str, ...], list[str]] = defaultdict(list)
    for name, behind in hidden.items():
        groups[behind].append(name)
    faint = groups.pop((), [])
    parts = [f"behind {' and '.join(behind)}: {', '.join(own)}" for behind, own in groups.items()]
    if faint:
        parts.append(f"too faint for these readings: {', '.join(faint)}")
    return "; ".join(parts)
