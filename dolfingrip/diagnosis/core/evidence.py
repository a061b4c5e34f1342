"""One evidence for every hypothesis: which causes act, and how large a discrepancy stays.

The readings are linear in fixed columns, r = Z b(ζ) with Z = [y − y₀, Φ₀, Φ₁, …] and
b = [1, −g₀, −g₁, …]; g₀ are of the model's own numbers. For a covariance C of noise, nuisances and
discrepancy

    G = Zᵀ C⁻¹ Z

is computed once; each hypothesis then costs the same for any number of readings. With the prior's
density p(ζ), its precisions W at the most probable ζ, and H = JᵀGJ + W there (Laplace's method;
MacKay, Information Theory, 2003, chapter 27)

    ln p(y) = −½ bᵀGb + ln p(ζ) + d/2 ln 2π − ½ ln|H| − ½ ln|C| − n/2 ln 2π

Columns of an emulator's error are integrated out like a nuisance.

Likely hypotheses are sampled: weighted draws by adaptive importance sampling give the integral.
The first draws are of a multivariate t about the mode. Where few of them count, as on a curved
ridge, more are drawn about the mean of those before, with their covariance. For that mean their
weights are raised to a power that lets enough of them count (Koblents & Míguez, Stat. Comput. 25,
2015). Each draw is weighted against the mixture of all that were drawn from (Cornuet, Marin, Mira &
Robert, Scand. J. Stat. 39, 2012).

How strongly readings feel a cause is told with the model's own numbers left free.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final

import numpy as np
import scipy.linalg
import scipy.stats
from scipy.special import logsumexp

from dolfingrip.diagnosis.core.emulator import Emulator, Local
from dolfingrip.diagnosis.core.unknown import Factor, Unknown
from dolfingrip.diagnosis.policy import POLICY

Subset = tuple[str, ...]
"""Names of causes, in the order of the problem; then of the nuisances that are implausible."""


NONE: Subset = ()


def mixture(zeta: np.ndarray, tail: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Density of priors of which a rare part is wide: a mixture of N(0, 1) and N(0, tail²).

    Args:
        zeta: numbers by the standard deviation of the ordinary part, shape (..., d).
        tail: standard deviation of the wide part of each, shape (d,); 1 where there is none.

    Returns:
        −ln of the density less ½ ln 2π, and its slope by ζ as a part of ζ, (..., d) each: the
        precision of the normal distribution that pulls as much there.
    """
    near = np.log1p(-POLICY.rare) - 0.5 * zeta**2
    far = np.log(POLICY.rare / tail) - 0.5 * (zeta / tail) ** 2
    both = np.logaddexp(near, far)
    return -both, 1 - np.exp(far - both) * (1 - tail**-2.0)


def correction_name(subset: Subset) -> str:
    """Return the name of the correction where these causes act."""
    return "corrections: " + " with ".join(subset)


BASELINE = "baseline"
"""Name of the columns that the nuisances change."""


@dataclass(frozen=True, eq=False)
class InferenceProblem:
    """Readings, and what could explain them.

    Attributes:
        value: y, shape (n,).
        base: y₀ as configured, shape (n,).
        always: the model's own numbers, which every hypothesis fits; the factor of all moduli
            first.
        emulators: of the causes, by name; functions of the moduli's ζ and of their own numbers.
        covariance: of noise and nuisances, shape (n, n).
        kernel: of the discrepancy at a level of 1, shape (n, n).
        boxes: ranges of ζ of each cause, (d, 2).
        tails: standard deviations of the wide parts of its numbers' priors, (d,); it has none where
            it is not among them.
        corrections: what simulations give beyond the sum of the emulators, by the causes that act;
            functions of the nuisances and of the numbers of all these causes.
        local: ranges of ζ, (d, 2), of effects in which that holds, and what each emulator misses,
            too. It holds for these alone.
        rig: which of the causes are numbers of the rig; they come last in every subset.
        remembering: causes with memory, of which the readings tell a curve's shape alone.
        curves: of any smooth elastic curve, shape (n, k); causes with memory have to do better.
        baseline: what the nuisances change: all moduli, and others that are fitted in every
            hypothesis.
    """

    value: np.ndarray
    base: np.ndarray
    always: tuple[Unknown, ...]
    emulators: Mapping[str, Emulator]
    covariance: np.ndarray
    kernel: np.ndarray
    boxes: Mapping[str, np.ndarray]
    baseline: Emulator
    corrections: Mapping[Subset, Emulator] = field(default_factory=dict)
    local: Mapping[Subset, np.ndarray] = field(default_factory=dict)
    tails: Mapping[str, np.ndarray] = field(default_factory=dict)
    rig: frozenset[str] = frozenset()
    remembering: frozenset[str] = frozenset()
    curves: np.ndarray | None = None

    @property
    def factor(self) -> Factor:
        """The factor of all moduli, by the first of ζ."""
        prior = self.always[0].prior
        assert isinstance(prior, Factor)
        return prior

    @property
    def baseline_box(self) -> np.ndarray:
        """Ranges of ζ of the model's own numbers, (own, 2); that of the moduli first."""
        return np.array([[each.low, each.high] for each in self.always])

    @property
    def nuisance_count(self) -> int:
        """Count of the model's own numbers, which come first in every ζ."""
        return len(self.always)

    def rows(self, kept: np.ndarray) -> InferenceProblem:
        """Restrict the problem to some of the readings."""
        return replace(
            self, value=self.value[kept], base=self.base[kept],
            emulators={name: each.rows(kept) for name, each in self.emulators.items()},
            covariance=self.covariance[np.ix_(kept, kept)], kernel=self.kernel[np.ix_(kept, kept)],
            corrections={causes: each.rows(kept) for causes, each in self.corrections.items()},
            baseline=self.baseline.rows(kept),
            curves=None if self.curves is None else self.curves[kept],
        )  # fmt: skip

    @property
    def implausible(self) -> dict[str, int]:
        """Which of ζ each of the model's own numbers is that may be far off, by name."""
        return {each.names[0]: i for i, each in enumerate(self.always) if each.names}

    @property
    def simulated(self) -> dict[Subset, Local]:
        """Which of ``corrections`` hold what simulations at fits told."""
        return {each: own for each, own in self.corrections.items() if isinstance(own, Local)}

    def widths(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the priors of the model's own numbers, by those told, (own,)."""
        found = np.ones(self.nuisance_count)
        for name, place in self.implausible.items():
            if name in subset:
                found[place] = POLICY.implausible_width
        return found

    def tail(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the wide parts of the priors of a hypothesis' causes, (d,)."""
        return np.concatenate([
            np.zeros(0),
            *(self.tails.get(each, np.ones(len(self.boxes[each]))) for each in self.causes(subset)),
        ])  # fmt: skip

    def causes(self, subset: Subset) -> Subset:
        """Return the names with numbers of their own: all but the nuisances."""
        return tuple(name for name in subset if name in self.emulators)

    def effects(self, subset: Subset) -> Subset:
        """Causes that are no numbers of the rig."""
        return tuple(name for name in self.causes(subset) if name not in self.rig)

    def places(self, subset: Subset) -> dict[str, np.ndarray]:
        """Which of ζ are the numbers of each cause."""
        found, at = {}, self.nuisance_count
        for name in self.causes(subset):
            found[name] = np.arange(at, at + len(self.boxes[name]))
            at += len(self.boxes[name])
        return found

    def parts(self, subset: Subset) -> list[tuple[str, Emulator, np.ndarray]]:
        """Emulators of a hypothesis: name, function, and which of ζ it depends on."""
        found = [(BASELINE, self.baseline, np.arange(self.nuisance_count))]
        places, effects = self.places(subset), self.effects(subset)
        for name, own in places.items():
            each = self.emulators[name]
            found.append((name, each, np.r_[0, own]))
        for causes, each in self.corrections.items():
            if places.keys() >= {*causes} and (causes not in self.local or causes == effects):
                every = [np.arange(self.nuisance_count), *(places[name] for name in causes)]
                found.append((correction_name(causes), each, np.concatenate(every)))
        return found

    def box(self, subset: Subset) -> np.ndarray:
        """Ranges of ζ of a hypothesis' causes, (d, 2)."""
        effects, causes = self.effects(subset), self.causes(subset)
        if effects in self.local:
            rig = [self.boxes[name] for name in causes if name in self.rig]
            return np.vstack([self.local[effects], *rig])
        return np.vstack([np.zeros((0, 2)), *(self.boxes[name] for name in causes)])

    def predicted(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Readings at ζ, shape (n,)."""
        found = self.base.copy()
        for _, emulator, own in self.parts(subset):
            found = found + emulator.columns @ emulator.at(zeta[None, own])[0]
        return found

    def slopes(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Their derivatives by ζ, shape (n, d)."""
        found = np.zeros((len(self.base), len(zeta)))
        for _, emulator, own in self.parts(subset):
            found[:, own] += emulator.columns @ emulator.with_slopes(zeta[own])[1]
        return found

    def corrected(self, subset: Subset, zeta: np.ndarray, exact: np.ndarray) -> InferenceProblem:
        """The problem with what a simulation tells beyond the emulators.

        Args:
            subset: causes that acted in it.
            zeta: their numbers, the model's own first, shape (d,).
            exact: simulated readings and their derivatives by ζ, shape (n, 1 + d).
        """
        known = {causes: (own.places, own.exact) for causes, own in self.simulated.items()}
        places, every = zeta[None], exact[None]
        if (causes := self.causes(subset)) in known:
            places = np.concatenate([known[causes][0], places])
            every = np.concatenate([known[causes][1], every])
        known[causes] = places, every
        found = replace(self, corrections={})
        for each in sorted(known, key=len):  # fewer causes count where more act
            places, every = known[each]
            emulated = [
                np.column_stack([found.predicted(each, z), found.slopes(each, z)]) for z in places
            ]
            own = Local.of(places, every, np.array(emulated), POLICY.correction_length)
            found = replace(found, corrections={**found.corrections, each: own})
        return found


@dataclass(frozen=True, eq=False)
class Draws:
    """Weighted draws of a density.

    Attributes:
        places: shape (draws, d).
        weights: of each; their sum is 1.
        log_integral: ln of the density's integral.
    """

    places: np.ndarray
    weights: np.ndarray
    log_integral: float

    @property
    def effective(self) -> float:
        """Number of equally weighted draws that tell as much."""
        return float(1 / (self.weights**2).sum())


def drawn(
    log_density: Callable[[np.ndarray], np.ndarray],
    mode: np.ndarray,
    covariance: np.ndarray,
    rng: np.random.Generator,
) -> Draws | None:
    """Draws until enough of them count and the integral stays; None where too few ever do.

    Args:
        log_density: of places, shape (draws, d); −∞ where the density is 0.
        mode: shape (d,).
        covariance: about the mode, shape (d, d).
        rng: of the draws.
    """
    middle, spread = mode, covariance
    proposals, places = [], np.empty((0, len(mode)))
    densities, before = np.empty(0), np.inf
    for _ in range(POLICY.adaptations):
        fresh = [
            scipy.stats.multivariate_t(middle, wider * _regular(spread), POLICY.freedom)
            for wider in POLICY.wider
        ]
        proposals += fresh
        each = POLICY.draws // len(fresh)
        new = np.vstack([own.rvs(each, random_state=rng).reshape(each, len(mode)) for own in fresh])
        places, densities = np.vstack([places, new]), np.r_[densities, log_density(new)]
        mixture = logsumexp([each.logpdf(places) for each in proposals], axis=0)
        log = densities - (mixture - np.log(len(proposals)))
        if not np.isfinite(log.max()):
            return None
        total = float(logsumexp(log))
        found = Draws(places, np.exp(log - total), total - float(np.log(len(log))))
        steady = abs(found.log_integral - before) < POLICY.steady
        if found.effective >= POLICY.effective and (steady or found.effective > len(log) / 2):
            return found
        before, least = found.log_integral, 2 * len(mode) + 2
        if np.isfinite(log).sum() < least:  # nearly all are where the density is 0
            continue
        tempered = _tempered(log, least)
        middle = tempered @ places
        spread = np.cov(places.T, aweights=tempered, ddof=0).reshape(spread.shape)
    return found if found.effective >= POLICY.effective / 2 else None


def _tempered(log: np.ndarray, least: int) -> np.ndarray:
    """Weights raised to the largest power up to 1 by which so many draws count."""
    inside = np.isfinite(log)
    log = np.where(inside, log - log.max(), 0.0)  # a power of 0 leaves −∞ undefined
    low, high = 0.0, 1.0
    for _ in range(20):
        power = 0.5 * (low + high)
        weights = inside * np.exp(power * log)
        enough = weights.sum() ** 2 / (weights**2).sum() >= least
        low, high = (power, high) if enough else (low, power)
    weights = inside * np.exp(low * log)
    return np.asarray(weights / weights.sum())


def _regular(covariance: np.ndarray) -> np.ndarray:
    """The nearest covariance that rounding leaves positive definite."""
    sizes, ways = np.linalg.eigh(0.5 * (covariance + covariance.T))
    return np.asarray(ways * np.maximum(sizes, 1e-9 * sizes[-1]) @ ways.T)


@dataclass(frozen=True, eq=False)
class MapFit:
    """The most probable numbers of a hypothesis, with its evidence.

    Attributes:
        subset: its causes.
        level: of the discrepancy.
        log_evidence: ln p(y).
        zeta: of the modulus, then of each cause's numbers.
        hessian: H there.
        misfit: bᵀGb there.
        strengths: length of each cause's change after nuisances, standard deviations; of one of the
            model's own numbers how far it is from its prior's mean.
        draws: samples of ζ, shape (draws, d), and their weights; empty where not sampled.
    """

    subset: Subset
    level: float
    log_evidence: float
    zeta: np.ndarray
    hessian: np.ndarray
    misfit: float
    strengths: tuple[float, ...]
    draws: tuple[np.ndarray, np.ndarray] | None = None


@dataclass(eq=False)
class CovarianceModel:
    """All columns under one covariance.

    Attributes:
        problem: the readings.
        level: of the discrepancy.
        gram: G.
        log_det: ln|C| + n ln 2π.
    """

    problem: InferenceProblem
    level: float
    gram: np.ndarray = field(init=False)
    log_det: float = field(init=False)
    _lower: np.ndarray = field(init=False)
    _white: np.ndarray = field(init=False)
    _place: dict[str, slice] = field(init=False)

    def __post_init__(self) -> None:
        problem = self.problem
        total = problem.covariance + self.level**2 * problem.kernel
        lower = scipy.linalg.cholesky(total, lower=True)
        blocks = [(problem.value - problem.base)[:, None]]
        self._place = {}
        at = 1

        def add(name: str, columns: np.ndarray) -> None:
            nonlocal at
            blocks.append(columns)
            self._place[name] = slice(at, at + columns.shape[1])
            at += columns.shape[1]

        corrections = {
            correction_name(causes): each for causes, each in problem.corrections.items()
        }
        for name, each in {BASELINE: problem.baseline, **problem.emulators, **corrections}.items():
            add(name, each.columns)
            add(f"{name} error", each.errors)
        self._lower = lower
        self._white = self.whitened(np.hstack(blocks))
        self.gram = self._white.T @ self._white
        n = len(problem.value)
        self.log_det = 2 * float(np.log(np.diag(lower)).sum()) + n * np.log(2 * np.pi)

    def whitened(self, columns: np.ndarray) -> np.ndarray:
        """L⁻¹ columns for C = L Lᵀ, shape (n,) or (n, k)."""
        return np.asarray(scipy.linalg.solve_triangular(self._lower, columns, lower=True))

    def coloured(self, white: np.ndarray) -> np.ndarray:
        """L white: readings' errors of covariance C from independent ones, shape (n,)."""
        return np.asarray(self._lower @ white)

    def read(self, value: np.ndarray) -> CovarianceModel:
        """Return the model of other readings y, shape (n,), by the same columns."""
        found = copy(self)
        found.problem = replace(self.problem, value=value)
        off = self.whitened(value - self.problem.base)
        found._white = np.column_stack([off, self._white[:, 1:]])
        found.gram = self.gram.copy()
        found.gram[0] = found.gram[:, 0] = found._white[:, 0] @ found._white
        return found

    def largest(self, subset: Subset) -> float:
        """ln of the largest likelihood of any change within the columns of causes."""
        names = [name for name, _, _ in self.problem.parts(subset)]
        at = np.r_[*(self._place[name] for name in names)]
        inner = self.gram[np.ix_(at, at)]
        inner = inner + np.diag(1e-9 * np.diag(inner) + 1e-12)
        found = self.gram[at, 0] @ np.linalg.solve(inner, self.gram[at, 0])
        return -0.5 * float(self.gram[0, 0] - found + self.log_det)

    def of(self, subset: Subset) -> Hypothesis:
        """A hypothesis under this covariance."""
        names = [name for name, _, _ in self.problem.parts(subset)]
        at = np.r_[0, *(self._place[name] for name in names)]
        causes = {*self.problem.causes(subset)}
        seen = [each for each in self.problem.simulated if causes.issuperset(each)]
        by = dict.fromkeys((name for each in seen for name in each), POLICY.surer)
        if (effects := self.problem.effects(subset)) in self.problem.local:
            by = dict.fromkeys(effects, 0.0)
        errors, size = np.empty(0, int), np.empty(0)
        for name in names:
            own = np.r_[self._place[f"{name} error"]]
            errors = np.r_[errors, own]
            size = np.r_[size, np.full(len(own), by.get(name, 1.0))]
        gram, log_det = self.gram[np.ix_(at, at)], self.log_det
        if len(errors):
            inner = np.outer(size, size) * self.gram[np.ix_(errors, errors)] + np.eye(len(errors))
            cross = self.gram[np.ix_(at, errors)] * size
            factor = scipy.linalg.cho_factor(inner, lower=True)
            gram = gram - cross @ scipy.linalg.cho_solve(factor, cross.T)
            log_det += 2 * float(np.log(np.diag(factor[0])).sum())
        return Hypothesis(self.problem, subset, self.level, gram, log_det)


LEVELS: Final[Mapping[float, float]] = {
    0.0: POLICY.discrepancy_off,
    **dict.fromkeys(
        POLICY.discrepancy_levels, (1 - POLICY.discrepancy_off) / len(POLICY.discrepancy_levels)
    ),
}
"""Prior probability of each level of the discrepancy."""


def at_levels(problem: InferenceProblem) -> dict[float, CovarianceModel]:
    """All columns of a problem under the covariance of each level."""
    return {level: CovarianceModel(problem, level) for level in LEVELS}


@dataclass(eq=False)
class Hypothesis:
    """Causes under one covariance."""

    problem: InferenceProblem
    subset: Subset
    level: float
    gram: np.ndarray
    log_det: float

    def __post_init__(self) -> None:
        self._box = np.vstack([self.problem.baseline_box, self.problem.box(self.subset)])
        self._parts = self.problem.parts(self.subset)
        own, tails = self.problem.widths(self.subset), self.problem.tail(self.subset)
        self._width = np.r_[own, np.ones(len(tails))]
        self._tail = np.r_[np.ones(len(own)), tails]

    def _prior(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """−ln of the prior's density, but for ½ ln 2π a number, and each one's precision there."""
        value, precision = mixture(zeta / self._width, self._tail)
        return (value + np.log(self._width)).sum(axis=-1), precision / self._width**2

    def _factors(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """b, shape (k,), and J = db/dζ, shape (k, d)."""
        every = self._parts
        total = 1 + sum(emulator.columns.shape[1] for _, emulator, _ in every)
        value, columns = np.ones(total), np.zeros((total, len(zeta)))
        row = 1
        for _, emulator, own in every:
            g, dg = emulator.with_slopes(zeta[own])
            value[row : row + len(g)] = -g
            columns[row : row + len(g), own] = -dg
            row += len(g)
        return value, columns

    def fit(self, starts: Sequence[np.ndarray], settled: float | None = None) -> MapFit:
        """The most probable ζ from several starts, whose separate modes add.

        Args:
            starts: values of ζ.
            settled: ln of probability that the last step gains at most; the policy's where None.
        """
        least = POLICY.settled if settled is None else settled
        found = [self._descend(start, least) for start in starts]
        modes: list[tuple[float, np.ndarray, np.ndarray, float]] = []
        for value, zeta, hessian, misfit in sorted(found, key=lambda each: each[0]):
            apart = (
                (zeta - other) @ hessian_ @ (zeta - other) > 9 for _, other, hessian_, _ in modes
            )
            if all(apart) and value < found[0][0] + 50:
                modes.append((value, zeta, hessian, misfit))
        logs = [
            -value - 0.5 * float(np.linalg.slogdet(hessian)[1]) for value, _, hessian, _ in modes
        ]
        _, zeta, hessian, misfit = modes[int(np.argmax(logs))]
        log = float(np.logaddexp.reduce(logs)) - 0.5 * self.log_det
        return MapFit(self.subset, self.level, log, zeta, hessian, misfit, self._strengths(zeta))

    def misfit(self, zeta: np.ndarray) -> float:
        """bᵀGb at ζ, shape (d,)."""
        b, _ = self._factors(zeta)
        return float(b @ self.gram @ b)

    def _descend(
        self, start: np.ndarray, settled: float
    ) -> tuple[float, np.ndarray, np.ndarray, float]:
        low, high = self._box.T
        zeta = np.clip(start, low, high)
        b, slopes = self._factors(zeta)
        pull = self.gram @ b
        told_prior, precision = self._prior(zeta)
        value = 0.5 * float(b @ pull) + float(told_prior)
        damping = 1e-3
        for _ in range(60):
            gradient = slopes.T @ pull + precision * zeta
            hessian = slopes.T @ self.gram @ slopes + np.diag(precision)
            held = ((zeta <= low) & (gradient > 0)) | ((zeta >= high) & (gradient < 0))
            better = False
            for _ in range(12):
                matrix = hessian + damping * np.diag(np.diag(hessian))
                matrix[held], matrix[:, held] = 0.0, 0.0
                matrix[held, held] = 1.0
                step = -np.linalg.solve(matrix, np.where(held, 0.0, gradient))
                step = np.clip(step, -1.5, 1.5)
                if -float(gradient @ step) < settled:  # more than it can gain
                    break
                new = np.clip(zeta + step, low, high)
                told, told_slopes = self._factors(new)
                told_pull = self.gram @ told
                told_prior, told_precision = self._prior(new)
                there = 0.5 * float(told @ told_pull) + float(told_prior)
                if there < value:
                    better = True
                    break
                damping *= 5
            if not better:
                break
            gain = value - there
            zeta, b, slopes, pull, value = new, told, told_slopes, told_pull, there
            precision = told_precision
            damping = max(damping / 10, 1e-9)
            if gain < settled:
                break
        hessian = slopes.T @ self.gram @ slopes + np.diag(precision)
        return value, zeta, hessian, float(b @ pull)

    def _strengths(self, zeta: np.ndarray) -> tuple[float, ...]:
        """Return the strength of each name of the subset in standard deviations.

        The model's own numbers follow a cause's change as far as their priors let them.
        """
        b, slopes = self._factors(zeta)
        own = slice(0, self.problem.nuisance_count)
        free = slopes[:, own]
        inner = free.T @ self.gram @ free + np.diag(self._width[own] ** -2)
        found: dict[str, float] = {
            name: abs(float(zeta[place])) for name, place in self.problem.implausible.items()
        }
        row = 1
        for name, emulator, _ in self._parts:
            k = emulator.columns.shape[1]
            if name in self.subset:
                change = np.zeros(len(b))
                change[row : row + k] = b[row : row + k]
                pull = self.gram @ change
                cross = free.T @ pull
                square = float(change @ pull - cross @ np.linalg.solve(inner, cross))
                found[name] = float(np.sqrt(max(square, 0.0)))
            row += k
        return tuple(found[name] for name in self.subset)

    def sampled(self, fit: MapFit, rng: np.random.Generator) -> MapFit:
        """The evidence by importance sampling, with draws.

        The fit itself where too few of the draws count.
        """
        low, high = self._box.T

        def log_density(zeta: np.ndarray) -> np.ndarray:
            inside = ((zeta >= low) & (zeta <= high)).all(axis=1)
            b = self._many(np.clip(zeta, low, high))
            value = 0.5 * ((b @ self.gram) * b).sum(axis=1) + self._prior(zeta)[0]
            norm = 0.5 * zeta.shape[1] * np.log(2 * np.pi)
            return np.where(inside, -value - norm, -np.inf)

        found = drawn(log_density, fit.zeta, np.linalg.inv(fit.hessian), rng)
        if found is None:
            return fit
        log = found.log_integral - 0.5 * self.log_det
        return replace(fit, log_evidence=log, draws=(found.places, found.weights))

    def _many(self, zeta: np.ndarray) -> np.ndarray:
        """b at many places, shape (places, k)."""
        changes = [-emulator.at(zeta[:, own]) for _, emulator, own in self._parts]
        return np.hstack([np.ones((len(zeta), 1)), *changes])


@dataclass(frozen=True, eq=False)
class Visibility:
    """Changes of the readings by causes.

    Attributes:
        problem: the readings.
        at: ζ of the model's own numbers, shape (own,).
    """

    problem: InferenceProblem
    at: np.ndarray

    @cached_property
    def columns(self) -> CovarianceModel:
        """All columns without a discrepancy."""
        return CovarianceModel(self.problem, 0.0)

    @cached_property
    def own(self) -> np.ndarray:
        """Changes by the model's own numbers, for each standard deviation, shape (n, own)."""
        return self.problem.slopes(NONE, self.at)

    def change(self, name: str, zeta: np.ndarray) -> np.ndarray:
        """Return the change of the readings by a cause at ζ, shape (n,)."""
        with_it = self.problem.predicted((name,), np.r_[self.at, zeta])
        return np.asarray(with_it - self.problem.predicted(NONE, self.at))

    def strength(self, name: str, zeta: np.ndarray) -> float:
        """Length of a cause's change, the model's own numbers left free, standard deviations."""
        white = self.columns.whitened(self.change(name, zeta))
        rest = white - self.columns.whitened(self.own) @ taken(
            white, self.columns.whitened(self.own)
        )
        return float(np.sqrt(max(white @ rest, 0.0)))


def taken(change: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """How much of a change other numbers take over, in standard deviations of each, shape (k,).

    Args:
        change: of the readings, by their noise, shape (n,).
        columns: changes by one standard deviation of each number, shape (n, k). Their priors let
            them follow as far as that.
    """
    inner = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(inner, columns.T @ change))
