"""One evidence for every hypothesis: which causes act, and how large a discrepancy stays.

The readings are linear in fixed columns, r = Z b(ζ) with Z = [y − y₀, Φ₀, Φ₁, …] and
b = [1, −g₀, −g₁, …]; g₀ are of the model's own numbers. For a covariance C of noise, nuisances and
discrepancy

    G = Zᵀ C⁻¹ Z

is computed once; each hypothesis then costs the same for any number of readings. With the prior's
density p(ζ), its precisions W at the most probable ζ, and H = JᵀGJ + W there (Laplace's method;
MacKay, Information Theory, 2003, chapter 27)

    ln p(y) = −½ bᵀGb + ln p(ζ) + d/2 ln 2π − ½ ln|H| − ½ ln|C| − n/2 ln 2π

Columns of an emulator's error are integrated out like a nuisance. Their size follows that of the
change that they are of.

Likely hypotheses are sampled: weighted draws by adaptive importance sampling give the integral.
The first draws are of a multivariate t about the mode. Where few of them count, as on a curved
ridge, more are drawn about the mean of those before, with their covariance. For that mean their
weights are raised to a power that lets enough of them count (Koblents & Míguez, Stat. Comput. 25,
2015). Each draw is weighted against the mixture of all that were drawn from (Cornuet, Marin, Mira &
Robert, Scand. J. Stat. 39, 2012).

How strongly readings feel a cause is told with the model's own numbers left free.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
import scipy.linalg
import scipy.stats
from scipy.special import logsumexp

from dolfingrip.diagnosis.core.emulator import Emulator, Local
from dolfingrip.diagnosis.core.unknown import Unknown
from dolfingrip.diagnosis.policy import POLICY

Subset = tuple[str, ...]
"""Names of causes, in the order of the problem; then of the nuisances that are implausible."""

Key = tuple[Subset, float]
"""Causes, and the level of a discrepancy beside them."""

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
        rig: which of the causes are numbers of the rig; they come last in every subset.
        remembering: causes with memory, of which the readings tell a curve's shape alone.
        curves: of what has the shape of memory, (n, k); causes with memory have to do better.
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
    corrections: Mapping[Subset, Local] = field(default_factory=dict)
    tails: Mapping[str, np.ndarray] = field(default_factory=dict)
    rig: frozenset[str] = frozenset()
    remembering: frozenset[str] = frozenset()
    curves: np.ndarray | None = None

    @property
    def factor(self) -> Unknown:
        """The factor of all moduli, by the first of ζ."""
        return self.always[0]

    @property
    def baseline_box(self) -> np.ndarray:
        """Ranges of ζ of the model's own numbers, (own, 2); that of the moduli first."""
        return np.array([[each.low, each.high] for each in self.always])

    @property
    def nuisance_count(self) -> int:
        """Count of the model's own numbers, which come first in every ζ."""
        return len(self.always)

    @cached_property
    def levels(self) -> Mapping[float, CovarianceModel]:
        """All columns under the covariance of each level of the discrepancy."""
        return {level: CovarianceModel(self, level) for level in LEVELS}

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
        places = self.places(subset)
        for name, own in places.items():
            each = self.emulators[name]
            found.append((name, each, np.r_[0, own]))
        for causes, each in self.corrections.items():
            if places.keys() >= {*causes}:
                every = [np.arange(self.nuisance_count), *(places[name] for name in causes)]
                found.append((correction_name(causes), each, np.concatenate(every)))
        return found

    def box(self, subset: Subset) -> np.ndarray:
        """Ranges of ζ of a hypothesis' causes, (d, 2)."""
        own = (self.boxes[name] for name in self.causes(subset))
        return np.vstack([np.zeros((0, 2)), *own])

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
            found[:, own] += emulator.columns @ emulator.with_slopes(zeta[None, own])[1][0]
        return found

    def corrected(self, told: Iterable[tuple[Subset, np.ndarray, np.ndarray]]) -> InferenceProblem:
        """The problem with what simulations tell beyond the emulators.

        Args:
            told: of each simulation the causes that acted in it, their numbers, the model's own
                first, shape (d,), and readings and their derivatives by ζ, shape (n, 1 + d).
        """
        known = {causes: (own.places, own.exact) for causes, own in self.corrections.items()}
        for subset, zeta, exact in told:
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

    @cached_property
    def visible(self) -> Subset:
        """Names of the subset whose change could be seen."""
        pairs = zip(self.subset, self.strengths, strict=True)
        return tuple(name for name, strength in pairs if strength >= POLICY.visible_sigma)

    @property
    def shows_nothing(self) -> bool:
        """Tell if nothing is to be seen: no cause, and nothing beside them."""
        return self.level == 0 and not self.visible


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

    def __post_init__(self) -> None:
        problem = self.problem
        total = problem.covariance + self.level**2 * problem.kernel
        self._lower = scipy.linalg.cholesky(total, lower=True)
        blocks = {"": (problem.value - problem.base)[:, None]}
        corrections = {
            correction_name(causes): each for causes, each in problem.corrections.items()
        }
        for name, each in {BASELINE: problem.baseline, **problem.emulators, **corrections}.items():
            blocks |= {name: each.columns, f"{name} error": each.errors}
        self._place = dict(zip(blocks, _side_by_side([*blocks.values()]), strict=True))
        self._white = self.whitened(np.hstack([*blocks.values()]))
        self.gram = self._white.T @ self._white
        log_2_pi = len(problem.value) * float(np.log(2 * np.pi))
        self.log_det = 2 * float(np.log(np.diag(self._lower)).sum()) + log_2_pi

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
        """A hypothesis under this covariance alone."""
        return Hypothesis.under([self], subset)

    def products(self, subset: Subset) -> Products:
        """Products of a hypothesis' columns.

        Args:
            subset: its causes.
        """
        names = [name for name, _, _ in self.problem.parts(subset)]
        at = np.r_[0, *(self._place[name] for name in names)]
        causes = {*self.problem.causes(subset)}
        seen = [each for each in self.problem.corrections if causes.issuperset(each)]
        by = dict.fromkeys((name for each in seen for name in each), POLICY.surer)
        own = {name: np.r_[self._place[f"{name} error"]] for name in names}
        errors = np.concatenate([*own.values()])
        size = np.concatenate([np.full(len(each), by.get(n, 1.0)) for n, each in own.items()])
        inner = np.outer(size, size) * self.gram[np.ix_(errors, errors)]
        return Products(
            self.gram[np.ix_(at, at)], self.gram[np.ix_(at, errors)] * size, inner, self.log_det
        )


@dataclass(frozen=True, eq=False)
class Products:
    """Products of the columns of a hypothesis, without the errors of its emulators in C.

    Attributes:
        gram: G, shape (k, k).
        cross: of columns and errors, shape (k, l).
        inner: of errors, shape (l, l).
        log_det: ln|C| + n ln 2π of each.
    """

    gram: np.ndarray
    cross: np.ndarray
    inner: np.ndarray
    log_det: float | np.ndarray

    @classmethod
    def stacked(cls, every: Sequence[Products]) -> Products:
        """Return products of several covariances, each array with one more axis, the first.

        Args:
            every: of one hypothesis, shapes (k, k), (k, l) and (l, l) each.
        """
        return cls(**{
            each.name: np.array([getattr(own, each.name) for own in every]) for each in fields(cls)
        })  # fmt: skip

    def of(self, which: np.ndarray) -> Products:
        """Return some of those that are stacked.

        Args:
            which: their places, shape (places,).
        """
        return Products(**{each.name: getattr(self, each.name)[which] for each in fields(self)})

    def with_errors(
        self, b: np.ndarray, size: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """G at many places, with the errors of the emulators in C (Woodbury's identity).

        Args:
            b: shape (places, k).
            size: factors of the errors, shape (places, l).

        Returns:
            G, (places, k, k), ln|C| + n ln 2π, (places,), and derivatives of bᵀGb + ln|C| by the
            factors, (places, l).
        """
        gram = np.broadcast_to(self.gram, (len(b), *self.gram.shape[-2:]))
        if not size.shape[1]:
            return gram, np.zeros(len(b)) + self.log_det, size
        scaled = self.cross * size[:, None]
        by = self.inner * size[:, None]
        total = by * size[..., None] + np.eye(size.shape[1])
        inverse = np.linalg.inv(total)
        solved = inverse @ scaled.transpose(0, 2, 1)
        taken = (solved @ b[..., None])[..., 0]
        left = (self.cross.swapaxes(-1, -2) @ b[..., None])[..., 0]
        left = left - (by @ taken[..., None])[..., 0]
        slopes = 2 * (np.einsum("pij,pji->pi", by, inverse) - taken * left)
        return gram - scaled @ solved, self.log_det + np.linalg.slogdet(total)[1], slopes


def _side_by_side(blocks: Sequence[np.ndarray]) -> list[slice]:
    """Columns of each block of some that stand side by side."""
    ends = np.cumsum([0, *(each.shape[1] for each in blocks)])
    return [slice(first, end) for first, end in pairwise(map(int, ends))]


LEVELS: Final[Mapping[float, float]] = {
    0.0: POLICY.discrepancy_off,
    **dict.fromkeys(
        POLICY.discrepancy_levels, (1 - POLICY.discrepancy_off) / len(POLICY.discrepancy_levels)
    ),
}
"""Prior probability of each level of the discrepancy."""


STEPS: Final = 100
"""Newton's steps of a descent, at most."""

UNLIKE: Final = 50.0
"""ln of how much less probable a mode is that does not count."""


@dataclass(eq=False)
class _Places:
    """−ln of a density at several ζ.

    Attributes:
        zeta: shape (places, d).
        value: −ln of the density, but for ½ ln 2π a number, shape (places,).
        gradient, hessian: its derivatives, shapes (places, d) and (places, d, d).
        misfit: bᵀGb, shape (places,).
    """

    zeta: np.ndarray
    value: np.ndarray
    gradient: np.ndarray
    hessian: np.ndarray
    misfit: np.ndarray

    def of(self, rows: np.ndarray | slice) -> _Places:
        """Return some of the places."""
        return _Places(**{name: each[rows] for name, each in vars(self).items()})

    def move(self, rows: np.ndarray, there: _Places) -> None:
        """Take others in the place of some."""
        for name, each in vars(self).items():
            each[rows] = getattr(there, name)


@dataclass(eq=False)
class Hypothesis:
    """Causes under covariances, at numbers of the model that are as told or implausible.

    Attributes:
        problem: the readings.
        subset: the causes.
        products: of their columns, by the level of a discrepancy.
    """

    problem: InferenceProblem
    subset: Subset
    products: Mapping[float, Products]

    @classmethod
    def under(cls, every: Sequence[CovarianceModel], subset: Subset) -> Hypothesis:
        """Causes under the covariances of some levels of a problem, of one or more.

        Args:
            every: the covariances.
            subset: the causes.
        """
        return cls(every[0].problem, subset, {each.level: each.products(subset) for each in every})

    def __post_init__(self) -> None:
        self._box = np.vstack([self.problem.baseline_box, self.problem.box(self.subset)])
        self._parts = self.problem.parts(self.subset)
        self._rows = _side_by_side([np.ones((1, 1)), *(e.columns for _, e, _ in self._parts)])[1:]
        counts = [each.errors.shape[1] for _, each, _ in self._parts]
        self._errors = np.repeat(np.arange(len(counts)), counts)
        tails = self.problem.tail(self.subset)
        self._tail = np.r_[np.ones(self.problem.nuisance_count), tails]

    def _width(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the priors of ζ where some numbers are implausible, (d,)."""
        own = self.problem.widths(subset)
        return np.r_[own, np.ones(len(self._tail) - len(own))]

    def _prior(self, zeta: np.ndarray, width: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """−ln of the prior's density, but for ½ ln 2π a number, and each one's precision there."""
        value, precision = mixture(zeta / width, self._tail)
        return (value + np.log(width)).sum(axis=-1), precision / width**2

    def _factors(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """b, shape (places, k), and J = db/dζ, shape (places, k, d)."""
        value = np.ones((len(zeta), self._rows[-1].stop))
        slopes = np.zeros((*value.shape, zeta.shape[1]))
        for (_, emulator, own), rows in zip(self._parts, self._rows, strict=True):
            g, dg = emulator.with_slopes(zeta[:, own])
            value[:, rows], slopes[:, rows, own] = -g, -dg
        return value, slopes

    def _sizes(self, b: np.ndarray, slopes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Factors of the emulators' errors at several places, and derivatives by ζ.

        Shapes (places, l) and (places, l, d).
        """
        told = [
            emulator.uncertainty(b[:, rows], slopes[:, rows])
            for (_, emulator, _), rows in zip(self._parts, self._rows, strict=True)
        ]
        factors, rates = (np.stack(each, axis=1) for each in zip(*told, strict=True))
        return factors[:, self._errors], rates[:, self._errors]

    def misfit(self, zeta: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
        """bᵀGb at many places, and ln|C| + n ln 2π there, (places,) each.

        Args:
            zeta: shape (places, d).
            level: of the discrepancy.
        """
        changes = [-emulator.at(zeta[:, own]) for _, emulator, own in self._parts]
        b = np.hstack([np.ones((len(zeta), 1)), *changes])
        size, _ = self._sizes(b, np.zeros((*b.shape, 0)))
        gram, log_det, _ = self.products[level].with_errors(b, size)
        return np.einsum("pi,pij,pj->p", b, gram, b, optimize=True), log_det

    def fit(self, starts: Sequence[np.ndarray], settled: float = POLICY.settled) -> MapFit:
        """The most probable ζ from several starts, whose separate modes add, at the first level.

        Args:
            starts: values of ζ.
            settled: ln of probability that the last step gains at most.
        """
        return self.fits({(self.subset, next(iter(self.products))): starts}, settled)[0]

    def fits(
        self, starts: Mapping[Key, Sequence[np.ndarray]], settled: float = POLICY.settled
    ) -> list[MapFit]:
        """Fits at several levels, and with several numbers of the model implausible, all at once.

        Args:
            starts: values of ζ by the level and by the causes with what is implausible beside them.
            settled: ln of probability that the last step gains at most.
        """
        counts = [len(each) for each in starts.values()]
        widths = np.array([self._width(subset) for subset, _ in starts])
        products = Products.stacked([self.products[level] for _, level in starts])
        first = np.vstack([each for own in starts.values() for each in own])
        which = np.repeat(np.arange(len(counts)), counts)
        every = self._descended(first, which, products, widths, settled)
        best, logs = [], []
        for end, count in zip(np.cumsum(counts), counts, strict=True):
            modes: list[int] = []
            for place in end - count + np.argsort(every.value[end - count : end], kind="stable"):
                off = every.zeta[place] - every.zeta[modes]
                apart = (np.einsum("mi,mij,mj->m", off, every.hessian[modes], off) > 9).all()
                if not modes or (apart and every.value[place] < every.value[modes[0]] + UNLIKE):
                    modes.append(int(place))
            own = -every.value[modes] - 0.5 * np.linalg.slogdet(every.hessian[modes])[1]
            best.append(modes[int(np.argmax(own))])
            logs.append(float(np.logaddexp.reduce(own)))
        told = zip(
            starts, logs, every.zeta[best], every.hessian[best], map(float, every.misfit[best]),
            self._strengths([subset for subset, _ in starts], every.zeta[best], products, widths),
            strict=True,
        )  # fmt: skip
        return [
            MapFit(subset, level, log, zeta, hessian, misfit, strengths)
            for (subset, level), log, zeta, hessian, misfit, strengths in told
        ]

    def _at(self, zeta: np.ndarray, products: Products, width: np.ndarray) -> _Places:
        """−ln of the density of readings and ζ.

        Args:
            zeta: shape (places, d).
            products: of each.
            width: of the priors there, shape (places, d).
        """
        b, slopes = self._factors(zeta)
        size, rates = self._sizes(b, slopes)
        gram, log_det, by_size = products.with_errors(b, size)
        pull, (prior, precision) = (gram @ b[..., None])[..., 0], self._prior(zeta, width)
        misfit, along = (b * pull).sum(axis=1), slopes.transpose(0, 2, 1)
        hessian = along @ (gram @ slopes) + precision[..., None] * np.eye(zeta.shape[1])
        gradient = (along @ pull[..., None])[..., 0] + precision * zeta
        gradient += 0.5 * np.einsum("pl,pld->pd", by_size, rates)
        return _Places(zeta, 0.5 * (misfit + log_det) + prior, gradient, hessian, misfit)

    def _descended(
        self,
        starts: np.ndarray,
        which: np.ndarray,
        products: Products,
        width: np.ndarray,
        settled: float,
    ) -> _Places:
        """Minima by damped Newton's steps within the box (Levenberg–Marquardt).

        Damping follows how much of what a step should gain it gains (Madsen, Nielsen & Tingleff,
        Methods for Non-Linear Least Squares Problems, 2004, section 3.2). A descent that is far
        above another of the same hypothesis, and comes no nearer, ends early.

        Args:
            starts: shape (places, d).
            which: hypothesis of each, shape (places,).
            products: of these.
            width: of their priors, shape (d,) each.
            settled: ln of probability that the last step gains at most.
        """
        low, high = self._box.T
        here = self._at(np.clip(starts, low, high), products.of(which), width[which])
        damping, harder = np.full(len(starts), 1e-3), np.full(len(starts), 2.0)
        at, diagonal = np.arange(len(starts)), np.arange(starts.shape[1])
        for _ in range(STEPS):
            zeta, gradient, matrix = here.zeta[at], here.gradient[at], here.hessian[at]
            held = ((zeta <= low) & (gradient > 0)) | ((zeta >= high) & (gradient < 0))
            matrix[:, diagonal, diagonal] *= 1 + damping[at, None]
            matrix = np.where(held[:, None] | held[:, :, None], 0.0, matrix)
            matrix[:, diagonal, diagonal] += held
            gradient = np.where(held, 0.0, gradient)
            step = np.clip(-np.linalg.solve(matrix, gradient[..., None])[..., 0], -1.5, 1.5)
            best = np.full(len(width), np.inf)
            np.minimum.at(best, which, here.value)
            least = np.maximum(settled, (here.value - best[which] - UNLIKE) / STEPS)
            worth = -(gradient * step).sum(axis=1) >= least[at]  # less than it can gain
            at, there = at[worth], np.clip((zeta + step)[worth], low, high)
            if not len(at):
                break
            tried = self._at(there, products.of(which[at]), width[which[at]])
            gain = here.value[at] - tried.value
            better, moved = gain > 0, there - here.zeta[at]
            told = -(here.gradient[at] * moved).sum(axis=1)
            told -= 0.5 * np.einsum("pi,pij,pj->p", moved, here.hessian[at], moved)
            part = np.clip(gain / np.maximum(told, 1e-12), 0.0, 1.0)
            easier = np.maximum(1 / 3, 1 - (2 * part - 1) ** 3)
            damping[at] *= np.where(better, easier, harder[at])
            harder[at] = np.where(better, 2.0, 2 * harder[at])
            going = np.where(better, gain >= least[at], harder[at] < 2**8)
            here.move(at[better], tried.of(better))
            at = at[going]
        return here

    def _strengths(
        self, subsets: Sequence[Subset], zeta: np.ndarray, products: Products, width: np.ndarray
    ) -> list[tuple[float, ...]]:
        """Strengths of the names of each subset at its ζ, standard deviations.

        The model's own numbers follow a cause's change as far as their priors let them.
        """
        b, slopes = self._factors(zeta)
        gram, *_ = products.with_errors(b, self._sizes(b, slopes)[0])
        own = slice(0, self.problem.nuisance_count)
        free = slopes[..., own]
        along = free.transpose(0, 2, 1)
        inner = along @ gram @ free + width[:, own, None] ** -2 * np.eye(own.stop)
        found = {n: np.abs(zeta[:, place]) for n, place in self.problem.implausible.items()}
        for (name, *_), rows in zip(self._parts, self._rows, strict=True):
            if name in self.subset:
                pull = gram[..., rows] @ b[:, rows, None]
                cross = along @ pull
                left = (pull[:, rows, 0] * b[:, rows]).sum(axis=1)
                left -= (cross * np.linalg.solve(inner, cross)).sum(axis=(1, 2))
                found[name] = np.sqrt(np.maximum(left, 0.0))
        return [
            tuple(float(found[name][row]) for name in subset) for row, subset in enumerate(subsets)
        ]

    def sampled(self, fit: MapFit, rng: np.random.Generator) -> MapFit:
        """The evidence by importance sampling, with draws.

        The fit itself where too few of the draws count.
        """
        (low, high), width = self._box.T, self._width(fit.subset)

        def log_density(zeta: np.ndarray) -> np.ndarray:
            inside = ((zeta >= low) & (zeta <= high)).all(axis=1)
            misfit, log_det = self.misfit(np.clip(zeta, low, high), fit.level)
            value = 0.5 * (misfit + log_det) + self._prior(zeta, width)[0]
            norm = 0.5 * zeta.shape[1] * np.log(2 * np.pi)
            return np.where(inside, -value - norm, -np.inf)

        found = drawn(log_density, fit.zeta, np.linalg.inv(fit.hessian), rng)
        if found is None:
            return fit
        draws = found.places, found.weights
        return replace(fit, log_evidence=found.log_integral, draws=draws)


@dataclass(frozen=True, eq=False)
class Visibility:
    """Changes of the readings by causes.

    Attributes:
        problem: the readings.
        at: ζ of the model's own numbers, shape (own,).
    """

    problem: InferenceProblem
    at: np.ndarray

    @property
    def columns(self) -> CovarianceModel:
        """All columns without a discrepancy."""
        return self.problem.levels[0.0]

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
