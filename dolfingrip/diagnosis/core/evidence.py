"""One evidence for every hypothesis: which causes act, and how large a discrepancy stays.

The readings are linear in fixed columns, r = Z b(ζ) with Z = [y, Φ₀, Φ₁, …] and b = [1, −g₀, −g₁,
…]; g₀ is of the model's own numbers. For a covariance C of noise, nuisances and discrepancy

    G = Zᵀ C⁻¹ Z

is computed once; each hypothesis then costs the same for any number of readings. With the prior's
density p(ζ), its precisions W at the most probable ζ, and H = JᵀGJ + W there (Laplace's method;
MacKay, Information Theory, 2003, chapter 27)

    ln p(y) = −½ bᵀGb + ln p(ζ) + d/2 ln 2π − ½ ln|H| − ½ ln|C| − n/2 ln 2π

How strongly readings feel a cause is told with the model's own numbers left free.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Final

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.core.blend import TangentBlend, Tangents
from dolfingrip.diagnosis.core.sampling import drawn
from dolfingrip.diagnosis.core.unknown import Unknown
from dolfingrip.diagnosis.policy import Policy

Subset = tuple[str, ...]
"""Names of causes, as the problem has them; then of the model's own numbers that are far off."""

Key = tuple[Subset, float]
"""Causes, and the level of a discrepancy beside them."""

NONE: Subset = ()


def mixture(
    zeta: np.ndarray, tail: np.ndarray, rare: float = Policy().rare
) -> tuple[np.ndarray, np.ndarray]:
    """Density of priors of which a rare part is wide: a mixture of N(0, 1) and N(0, tail²).

    Args:
        zeta: numbers by the standard deviation of the ordinary part, shape (..., d).
        tail: standard deviation of the wide part of each, shape (d,); 1 where there is none.
        rare: probability of the wide part.

    Returns:
        −ln of the density less ½ ln 2π, and its slope by ζ as a part of ζ, (..., d) each: the
        precision of the normal distribution that pulls as much there.
    """
    near = np.log1p(-rare) - 0.5 * zeta**2
    far = np.log(rare / tail) - 0.5 * (zeta / tail) ** 2
    both = np.logaddexp(near, far)
    return -both, 1 - np.exp(far - both) * (1 - tail**-2.0)


@dataclass(frozen=True, eq=False)
class InferenceProblem:
    """Readings, and what could explain them.

    Attributes:
        value: y, shape (n,).
        base: of the model as configured, shape (n,).
        noise: of instruments and gauge, standard deviations, shape (n,).
        always: the model's own numbers, which every hypothesis fits; the factor of all moduli
            first, those that readings are linear in last.
        linear: changes by one standard deviation of these, shape (n, l).
        numbers: of the causes, by name.
        covariance: of noise and nuisances, shape (n, n).
        kernel: of the discrepancy at a level of 1, shape (n, n).
        runs: simulations by the causes that acted in them, as functions of the model's own numbers
            that are not linear and of the causes' numbers, in this order.
        blends: of them: of the model alone, of what each cause changes, and of what several change
            beyond their sum.
        impossible: sets of causes that cannot be simulated at their numbers.
        elastic: causes that are elastic laws.
        remembering: causes with memory, of which the readings tell a curve's shape alone.
        curves: of what has the shape of memory, (n, k); causes with memory have to do better.
        policy: numbers of the priors, and of how they are compared.
    """

    value: np.ndarray
    base: np.ndarray
    noise: np.ndarray
    always: tuple[Unknown, ...]
    linear: np.ndarray
    numbers: Mapping[str, Sequence[Unknown]]
    covariance: np.ndarray
    kernel: np.ndarray
    runs: Mapping[Subset, Tangents] = field(default_factory=dict)
    blends: Mapping[Subset, TangentBlend] = field(default_factory=dict)
    impossible: frozenset[Subset] = frozenset()
    elastic: frozenset[str] = frozenset()
    remembering: frozenset[str] = frozenset()
    curves: np.ndarray | None = None
    policy: Policy = Policy()

    @property
    def factor(self) -> Unknown:
        """The factor of all moduli, by the first of ζ."""
        return self.always[0]

    @property
    def nuisance_count(self) -> int:
        """Count of the model's own numbers, which come first in every ζ."""
        return len(self.always)

    @property
    def simulated_count(self) -> int:
        """Count of those that simulations are of, which come first."""
        return len(self.always) - self.linear.shape[1]

    @cached_property
    def levels(self) -> Mapping[float, CovarianceModel]:
        """All columns under the covariance of each level of the discrepancy."""
        return {level: CovarianceModel(self, level) for level in self.policy.levels}

    def rows(self, kept: np.ndarray) -> InferenceProblem:
        """Restrict the problem to some of the readings."""
        both = np.ix_(kept, kept)
        return replace(
            self, value=self.value[kept], base=self.base[kept], noise=self.noise[kept],
            linear=self.linear[kept], covariance=self.covariance[both], kernel=self.kernel[both],
            runs={causes: run.rows(kept) for causes, run in self.runs.items()},
            blends={causes: blend.rows(kept) for causes, blend in self.blends.items()},
            curves=None if self.curves is None else self.curves[kept],
        )  # fmt: skip

    def beside(self, more: Iterable[tuple[Subset, Tangents]]) -> InferenceProblem:
        """The problem with further simulations, by the causes that act in them."""
        runs, new = dict(self.runs), set[Subset]()
        for causes, run in more:
            runs[causes] = Tangents.stacked([runs[causes], run]) if causes in runs else run
            new.add(causes)
        blends: dict[Subset, TangentBlend] = {}
        problem = replace(self, runs=runs, blends=blends)
        for causes in sorted(runs, key=len):
            if not any({*acting} <= {*causes} for acting in new):
                blends[causes] = self.blends[causes]
                continue
            simulated, numbers = runs[causes], problem._simulated(causes)
            remaining = simulated.told.copy()
            for part in [blend for acting, blend in blends.items() if {*acting} < {*causes}]:
                some = [numbers.index(number) for number in part.numbers]
                value, slopes = part.at_coordinates(simulated.u[:, some])
                remaining[..., 0] -= value @ part.columns.T
                remaining[..., 1:][..., some] -= part.columns @ slopes
            length = 1.0 if len(causes) > 1 else np.inf
            alone = Tangents(simulated.u, remaining)
            missed = self.policy.matters
            blends[causes] = TangentBlend.of(numbers, alone, self.noise, length, missed)
        self._hand_on(problem)
        return problem

    def _hand_on(self, other: InferenceProblem) -> None:
        """Give another problem of the same readings what is whitened already."""
        if "levels" in vars(self):
            levels = {k: CovarianceModel(other, k, model) for k, model in self.levels.items()}
            vars(other)["levels"] = levels

    def without(self, causes: Subset) -> InferenceProblem:
        """The problem in which a set of causes is impossible at its numbers."""
        problem = replace(self, impossible=self.impossible | {causes})
        self._hand_on(problem)
        return problem

    def _simulated(self, causes: Subset) -> list[Unknown]:
        """Numbers that simulations of some causes are functions of."""
        numbers = [number for name in causes for number in self.numbers[name]]
        return [*self.always[: self.simulated_count], *numbers]

    @property
    def implausible(self) -> dict[str, int]:
        """Which of ζ each of the model's own numbers is that may be far off, by name."""
        return {number.names[0]: i for i, number in enumerate(self.always) if number.names}

    @property
    def rig(self) -> set[str]:
        """Names of numbers that may be far off, but for the factor of all moduli."""
        return {*self.implausible} - {*self.factor.names}

    def widths(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the priors of the model's own numbers, by those told, (own,)."""
        widths = np.ones(self.nuisance_count)
        for name, place in self.implausible.items():
            if name in subset:
                widths[place] = self.always[place].prior.wide
        return widths

    def tail(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the wide parts of the priors of a hypothesis' causes, (d,)."""
        return np.array([n.tail for name in self.causes(subset) for n in self.numbers[name]])

    def causes(self, subset: Subset) -> Subset:
        """Return the causes: all names but those of the model's own numbers."""
        return tuple(name for name in subset if name in self.numbers)

    def places(self, subset: Subset) -> dict[str, np.ndarray]:
        """Which of ζ are the numbers of each cause."""
        places, at = {}, self.nuisance_count
        for name in self.causes(subset):
            places[name] = np.arange(at, at + len(self.numbers[name]))
            at += len(self.numbers[name])
        return places

    def parts(self, subset: Subset) -> list[tuple[Subset, TangentBlend, np.ndarray]]:
        """Blends of a hypothesis: causes, function, and which of ζ it depends on."""
        places, first = self.places(subset), np.arange(self.simulated_count)
        return [
            (causes, blend, np.r_[first, *(places[name] for name in causes)])
            for causes, blend in self.blends.items()
            if places.keys() >= {*causes}
        ]

    def box(self, subset: Subset) -> np.ndarray:
        """Ranges of ζ of a hypothesis, (d, 2); those of the model's own numbers first."""
        every = [*self.always, *(n for name in self.causes(subset) for n in self.numbers[name])]
        return np.array([[number.low, number.high] for number in every])

    def predicted(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Readings at ζ, shape (n,)."""
        readings = self.linear @ zeta[self.simulated_count : self.nuisance_count]
        for _, blend, which in self.parts(subset):
            readings = readings + blend.columns @ blend.at(zeta[None, which])[0]
        return readings

    def left(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Return the residual at some numbers beside the errors of rig and specimens, (n,)."""
        off = self.value - self.predicted(subset, zeta)
        return self.noise**2 * self.levels[0.0].weighed(off)

    def share(self, change: np.ndarray) -> float:
        """Root mean square of a change of the readings, by the largest of them."""
        return float(np.sqrt(np.mean(change**2)) / np.abs(self.value).max())

    def slopes(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Their derivatives by ζ, shape (n, d)."""
        slopes = np.zeros((len(self.value), len(zeta)))
        slopes[:, self.simulated_count : self.nuisance_count] = self.linear
        for _, blend, which in self.parts(subset):
            slopes[:, which] += blend.columns @ blend.with_slopes(zeta[None, which])[1][0]
        return slopes

    def extrapolated(self, fit: MapFit) -> float:
        """ln of evidence that a fit's readings may miss, as they are not simulated.

        The readings change by some length, in standard deviations, from those simulated of the
        same causes that are nearest; a part of the length may be wrong.
        """
        causes = self.causes(fit.subset)
        here = self.predicted(fit.subset, fit.zeta)
        if causes in self.runs:
            zeta = fit.zeta[self.simulated_count : self.nuisance_count]
            off = here - self.linear @ zeta - self.runs[causes].told[..., 0]
            off = off[np.argmin(np.square(off / self.noise).sum(axis=1))]
        else:  # two causes that were not simulated together, by the weaker one
            without = {name: tuple(n for n in fit.subset if n != name) for name in causes}
            every = [
                here - self.predicted(fewer, self._part(fit, fewer)) for fewer in without.values()
            ]
            off = min(every, key=lambda change: float(np.square(change / self.noise).sum()))
        length = float(np.linalg.norm(self.levels[fit.level].whitened(off)))
        policy = self.policy
        return 0.5 * min(policy.first_error * length, 2 * policy.unlikely) ** 2

    def _part(self, fit: MapFit, subset: Subset) -> np.ndarray:
        """ζ of a fit without those of causes that a subset does not have."""
        places, first = self.places(fit.subset), np.arange(self.nuisance_count)
        return fit.zeta[np.r_[first, *(places[name] for name in self.causes(subset))]]


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
        least: strength below which nothing can be seen.
        draws: samples of ζ, shape (draws, d), and their weights; empty where not sampled.
    """

    subset: Subset
    level: float
    log_evidence: float
    zeta: np.ndarray
    hessian: np.ndarray
    misfit: float
    strengths: tuple[float, ...]
    least: float = Policy().visible
    draws: tuple[np.ndarray, np.ndarray] | None = None

    @cached_property
    def visible(self) -> Subset:
        """Names of the subset whose change could be seen."""
        pairs = zip(self.subset, self.strengths, strict=True)
        return tuple(name for name, strength in pairs if strength >= self.least)

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
        before: that of the same readings with other simulations; None where there is none.
        log_det: ln|C| + n ln 2π.
    """

    problem: InferenceProblem
    level: float
    before: CovarianceModel | None = None

    def __post_init__(self) -> None:
        problem, known = self.problem, self.before
        if known is None:
            total = problem.covariance + self.level**2 * problem.kernel
            self._lower = scipy.linalg.cholesky(total, lower=True)
            first = np.column_stack([problem.value, problem.linear])
            self._white: dict[Subset | str, np.ndarray] = {"": self.whitened(first)}
        else:
            self._lower, self._white = known._lower, dict(known._white)
        for causes, each in problem.blends.items():
            if known is None or known.problem.blends.get(causes) is not each:
                self._white[causes] = self.whitened(each.columns)
        self.before = None
        log_2_pi = len(problem.value) * float(np.log(2 * np.pi))
        self.log_det = 2 * float(np.log(np.diag(self._lower)).sum()) + log_2_pi
        self._grams: dict[tuple[Subset | str, Subset | str], np.ndarray] = {}

    def whitened(self, columns: np.ndarray) -> np.ndarray:
        """L⁻¹ columns for C = L Lᵀ, shape (n,) or (n, k)."""
        return np.asarray(scipy.linalg.solve_triangular(self._lower, columns, lower=True))

    def weighed(self, residual: np.ndarray) -> np.ndarray:
        """C⁻¹ r of a residual r, shape (n,)."""
        return np.asarray(scipy.linalg.cho_solve((self._lower, True), residual))

    def coloured(self, white: np.ndarray) -> np.ndarray:
        """L white: readings' errors of covariance C from independent ones, shape (n,)."""
        return np.asarray(self._lower @ white)

    def read(self, value: np.ndarray) -> CovarianceModel:
        """Return the model of other readings y, shape (n,), by the same columns."""
        found = copy(self)
        found.problem = replace(self.problem, value=value)
        found._white = dict(self._white)
        found._white[""] = np.column_stack([self.whitened(value), self._white[""][:, 1:]])
        found._grams = {key: each for key, each in self._grams.items() if "" not in key}
        return found

    def gram(self, subset: Subset) -> np.ndarray:
        """G of a hypothesis: of readings, linear numbers, and the blends of its parts."""
        keys: list[Subset | str] = ["", *(causes for causes, _, _ in self.problem.parts(subset))]
        return np.block([[self._product(one, other) for other in keys] for one in keys])

    def _product(self, one: Subset | str, other: Subset | str) -> np.ndarray:
        if (one, other) not in self._grams:
            found = self._white[one].T @ self._white[other]
            self._grams[one, other], self._grams[other, one] = found, found.T
        return self._grams[one, other]

    def largest(self, subset: Subset) -> float:
        """ln of the largest likelihood of any change within the columns of causes."""
        gram = self.gram(subset)
        inner = gram[1:, 1:] + np.diag(1e-9 * np.diag(gram)[1:] + 1e-12)
        found = gram[1:, 0] @ np.linalg.solve(inner, gram[1:, 0])
        return -0.5 * float(gram[0, 0] - found + self.log_det)

    def of(self, subset: Subset) -> Hypothesis:
        """A hypothesis under this covariance alone."""
        return Hypothesis.under([self], subset)


SETTLED: Final = 1e-4
"""ln of probability that the last step of a fit gains at most."""

STEPS: Final = 100
"""Newton's steps of a descent, at most."""


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
        return _Places(**{name: array[rows] for name, array in vars(self).items()})

    def move(self, rows: np.ndarray, there: _Places) -> None:
        """Take others in the place of some."""
        for name, array in vars(self).items():
            array[rows] = getattr(there, name)


@dataclass(frozen=True, eq=False)
class Products:
    """Products of a hypothesis' columns under one covariance, or under several.

    Attributes:
        gram: G, shape (k, k), or (levels, k, k).
        log_det: ln|C| + n ln 2π of each.
    """

    gram: np.ndarray
    log_det: float | np.ndarray

    @classmethod
    def stacked(cls, every: Sequence[Products]) -> Products:
        """Return products of several covariances, each array with one more axis, the first.

        Args:
            every: of one hypothesis.
        """
        return cls(np.array([own.gram for own in every]), np.array([o.log_det for o in every]))

    def of(self, which: np.ndarray) -> Products:
        """Return some of those that are stacked.

        Args:
            which: their places, shape (places,).
        """
        return Products(self.gram[which], np.asarray(self.log_det)[which])


@dataclass(eq=False)
class Hypothesis:
    """Causes under covariances, at numbers of the model that are as told or implausible.

    Attributes:
        problem: the readings.
        subset: the causes.
        levels: of a discrepancy, with all columns under each.
    """

    problem: InferenceProblem
    subset: Subset
    levels: Mapping[float, CovarianceModel]

    @classmethod
    def under(cls, every: Sequence[CovarianceModel], subset: Subset) -> Hypothesis:
        """Causes under the covariances of some levels of a problem, of one or more.

        Args:
            every: the covariances.
            subset: the causes.
        """
        return cls(every[0].problem, subset, {each.level: each for each in every})

    def __post_init__(self) -> None:
        problem = self.problem
        self._box, self._parts = problem.box(self.subset), problem.parts(self.subset)
        widths = [1 + problem.linear.shape[1], *(e.columns.shape[1] for _, e, _ in self._parts)]
        self._rows = [slice(a, b) for a, b in pairwise(np.cumsum([0, *widths]).tolist())]
        tails = problem.tail(self.subset)
        self._tail = np.r_[np.ones(problem.nuisance_count), tails]
        self._policy = problem.policy
        grams = {level: each.gram(self.subset) for level, each in self.levels.items()}
        self._products = {k: Products(grams[k], each.log_det) for k, each in self.levels.items()}

    def _width(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the priors of ζ where some numbers are implausible, (d,)."""
        own = self.problem.widths(subset)
        return np.r_[own, np.ones(len(self._tail) - len(own))]

    def _prior(self, zeta: np.ndarray, width: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """−ln of the prior's density, but for ½ ln 2π a number, and each one's precision there."""
        value, precision = mixture(zeta / width, self._tail, self._policy.rare)
        return (value + np.log(width)).sum(axis=-1), precision / width**2

    def _factors(self, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """b, shape (places, k), and J = db/dζ, shape (places, k, d)."""
        value = np.ones((len(zeta), self._rows[-1].stop))
        slopes = np.zeros((*value.shape, zeta.shape[1]))
        linear = np.arange(self.problem.simulated_count, self.problem.nuisance_count)
        value[:, 1 : self._rows[0].stop] = -zeta[:, linear]
        slopes[:, np.arange(1, self._rows[0].stop), linear] = -1.0
        for (_, blend, own), rows in zip(self._parts, self._rows[1:], strict=True):
            g, dg = blend.with_slopes(zeta[:, own])
            value[:, rows], slopes[:, rows, own] = -g, -dg
        return value, slopes

    def misfit(self, zeta: np.ndarray, level: float) -> tuple[np.ndarray, float]:
        """bᵀGb at many places, shape (places,), and ln|C| + n ln 2π.

        Args:
            zeta: shape (places, d).
            level: of the discrepancy.
        """
        b, own = self._factors(zeta)[0], self._products[level]
        return np.einsum("pi,ij,pj->p", b, own.gram, b, optimize=True), float(own.log_det)

    def fit(self, starts: Sequence[np.ndarray], settled: float = SETTLED) -> MapFit:
        """The most probable ζ from several starts, whose separate modes add, at the first level.

        Args:
            starts: values of ζ.
            settled: ln of probability that the last step gains at most.
        """
        return self.fits({(self.subset, next(iter(self.levels))): starts}, settled)[0]

    def fits(
        self, starts: Mapping[Key, Sequence[np.ndarray]], settled: float = SETTLED
    ) -> list[MapFit]:
        """Fits at several levels, and with several numbers of the model implausible, all at once.

        Args:
            starts: values of ζ by the level and by the causes with what is implausible beside them.
            settled: ln of probability that the last step gains at most.
        """
        counts = [len(each) for each in starts.values()]
        widths = np.array([self._width(subset) for subset, _ in starts])
        products = Products.stacked([self._products[level] for _, level in starts])
        first = np.vstack([each for own in starts.values() for each in own])
        which = np.repeat(np.arange(len(counts)), counts)
        every = self._descended(first, which, products, widths, settled)
        best, logs, far = [], [], self._policy.unlikely
        for end, count in zip(np.cumsum(counts), counts, strict=True):
            modes: list[int] = []
            for place in end - count + np.argsort(every.value[end - count : end], kind="stable"):
                off = every.zeta[place] - every.zeta[modes]
                apart = (np.einsum("mi,mij,mj->m", off, every.hessian[modes], off) > far**2).all()
                if not modes or (
                    apart and every.value[place] < every.value[modes[0]] + self._policy.hopeless
                ):
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
            MapFit(subset, level, log, zeta, hessian, misfit, strengths, self._policy.visible)
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
        gram, log_det = products.gram, products.log_det
        pull, (prior, precision) = (gram @ b[..., None])[..., 0], self._prior(zeta, width)
        misfit, along = (b * pull).sum(axis=1), slopes.transpose(0, 2, 1)
        hessian = along @ (gram @ slopes) + precision[..., None] * np.eye(zeta.shape[1])
        gradient = (along @ pull[..., None])[..., 0] + precision * zeta
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
        (low, high), longest = self._box.T, self._policy.start
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
            step = np.clip(-np.linalg.solve(matrix, gradient[..., None])[..., 0], -longest, longest)
            best = np.full(len(width), np.inf)
            np.minimum.at(best, which, here.value)
            least = np.maximum(settled, (here.value - best[which] - self._policy.hopeless) / STEPS)
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
            turned = 2 * part - 1
            easier = np.maximum(0.5, 1 - turned * turned**2)
            damping[at] *= np.where(better, easier, harder[at])
            harder[at] = np.where(better, 2.0, 2 * harder[at])
            going = np.where(better, gain >= least[at], harder[at] < 100)
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
        gram = products.gram
        own = slice(0, self.problem.nuisance_count)
        free = slopes[..., own]
        along = free.transpose(0, 2, 1)
        inner = along @ gram @ free + width[:, own, None] ** -2 * np.eye(own.stop)
        found = {n: np.abs(zeta[:, place]) for n, place in self.problem.implausible.items()}
        for (causes, *_), rows in zip(self._parts, self._rows[1:], strict=True):
            if len(causes) == 1:
                (name,) = causes
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

        found = drawn(log_density, fit.zeta, np.linalg.inv(fit.hessian), rng, self._policy)
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
        residual = white - self.columns.whitened(self.own) @ taken(
            white, self.columns.whitened(self.own)
        )
        return float(np.sqrt(max(white @ residual, 0.0)))


def taken(change: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """How much of a change other numbers take over, in standard deviations of each, shape (k,).

    Args:
        change: of the readings, by their noise, shape (n,).
        columns: changes by one standard deviation of each number, shape (n, k). Their priors let
            them follow as far as that.
    """
    inner = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(inner, columns.T @ change))
