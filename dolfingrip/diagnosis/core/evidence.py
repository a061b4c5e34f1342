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
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import batched, chain, pairwise
from typing import Final, NamedTuple

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.core.blend import TangentBlend, Tangents
from dolfingrip.diagnosis.core.sampling import drawn
from dolfingrip.diagnosis.core.unknown import (
    NumberReading,
    Unknown,
    coordinates,
    expected,
    linear_in,
)
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
        covariance: of noise, mesh and specimens, shape (n, n).
        kernel: of the discrepancy at a level of 1, shape (n, n).
        runs: simulations by the causes that acted in them, as functions of the model's own numbers
            that are not linear and of the causes' numbers, in this order.
        blends: of them: of the model alone, of what each cause changes, and of what several change
            beyond their sum.
        impossible: sets of causes that cannot be simulated at their numbers.
        displaying: causes that act on what instruments show alone.
        elastic: causes that are elastic laws.
        remembering: causes with memory, of which the readings tell a curve's shape alone.
        curves: of what has the shape of memory, (n, k); causes with memory have to do better.
        largest: the largest reading of each one's channel, shape (n,); of all where None.
        told: m readings of numbers by themselves, which are independent of the others. They stand
            below these, each less what would be read of the model as configured.
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
    displaying: frozenset[str] = frozenset()
    elastic: frozenset[str] = frozenset()
    remembering: frozenset[str] = frozenset()
    curves: np.ndarray | None = None
    largest: np.ndarray | None = None
    told: tuple[NumberReading, ...] = ()
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

    @property
    def every_value(self) -> np.ndarray:
        """Readings, and those of numbers below them, shape (n + m,)."""
        return np.append(self.value, [reading.change for reading in self.told])

    @cached_property
    def every_linear(self) -> np.ndarray:
        """Changes of them by one standard deviation of numbers they are linear in, (n + m, l)."""
        _, by = expected(self.told, self.always, np.zeros(self.nuisance_count))
        return np.vstack([self.linear, by[:, self.simulated_count :]])

    @property
    def told_std(self) -> np.ndarray:
        """Standard deviations of readings of numbers, shape (m,)."""
        return np.array([reading.std for reading in self.told])

    @cached_property
    def levels(self) -> Mapping[float, CovarianceModel]:
        """All columns under the covariance of each level of the discrepancy."""
        return {level: CovarianceModel(self, level) for level in self.policy.levels}

    @cached_property
    def columns(self) -> dict[Subset, np.ndarray]:
        """Which columns of Z each blend has; those of readings and linear numbers come first."""
        counts = [blend.columns.shape[1] for blend in self.blends.values()]
        ends = np.cumsum([1 + self.linear.shape[1], *counts]).tolist()
        return {
            causes: np.arange(first, end)
            for causes, (first, end) in zip(self.blends, pairwise(ends), strict=True)
        }

    def rows(self, kept: np.ndarray) -> InferenceProblem:
        """Restrict the problem to some of the readings."""
        both, every = np.ix_(kept, kept), np.append(kept, np.ones(len(self.told), bool))
        return replace(
            self, value=self.value[kept], base=self.base[kept], noise=self.noise[kept],
            linear=self.linear[kept], covariance=self.covariance[both], kernel=self.kernel[both],
            runs={causes: run.rows(kept) for causes, run in self.runs.items()},
            blends={causes: blend.rows(every) for causes, blend in self.blends.items()},
            curves=None if self.curves is None else self.curves[kept],
            largest=None if self.largest is None else self.largest[kept],
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
            numbers = problem._simulated(causes)
            simulated = runs[causes].beside(*linear_in(self.told, numbers))
            remaining = simulated.told.copy()
            for part in [blend for acting, blend in blends.items() if {*acting} < {*causes}]:
                some = [numbers.index(number) for number in part.numbers]
                value, slopes = part.at_coordinates(simulated.u[:, some])
                remaining[..., 0] -= value @ part.columns.T
                remaining[..., 1:][..., some] -= part.columns @ slopes
            fades = len(causes) > 1 and self.displaying.isdisjoint(causes)
            length = 1.0 if fades else np.inf
            alone = Tangents(simulated.u, remaining)
            missed = self.policy.matters
            noise = np.append(self.noise, self.told_std)
            blends[causes] = TangentBlend.of(numbers, alone, noise, length, missed)
        return problem

    def without(self, causes: Subset) -> InferenceProblem:
        """The problem in which a set of causes is impossible at its numbers."""
        return replace(self, impossible=self.impossible | {causes})

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

    def unknowns(self, subset: Subset) -> list[Unknown]:
        """Numbers of a hypothesis, by ζ: those of the model's own first."""
        return [*self.always, *(n for name in self.causes(subset) for n in self.numbers[name])]

    def box(self, subset: Subset) -> np.ndarray:
        """Ranges of ζ of a hypothesis, (d, 2)."""
        return np.array([[number.low, number.high] for number in self.unknowns(subset)])

    def every_reading(self, subset: Subset, zeta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Readings at ζ, and those of numbers, (n + m,), and their derivatives by ζ, (n + m, d)."""
        linear = self.every_linear
        readings = linear @ zeta[self.simulated_count : self.nuisance_count]
        slopes = np.zeros((len(linear), len(zeta)))
        slopes[:, self.simulated_count : self.nuisance_count] = linear
        for _, blend, which in self.parts(subset):
            value, by = blend.with_slopes(zeta[None, which])
            readings = readings + blend.columns @ value[0]
            slopes[:, which] += blend.columns @ by[0]
        return readings, slopes

    def predicted(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Readings at ζ, shape (n,)."""
        return self.every_reading(subset, zeta)[0][: len(self.value)]

    def slopes(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Derivatives of the readings by ζ, shape (n, d)."""
        return self.every_reading(subset, zeta)[1][: len(self.value)]

    def change(self, name: str, rig: np.ndarray, zeta: np.ndarray) -> np.ndarray:
        """Return the change of the readings by a cause at ζ, the model's numbers at ``rig``."""
        with_it = self.predicted((name,), np.r_[rig, zeta])
        return np.asarray(with_it - self.predicted(NONE, rig))

    def strength(self, name: str, rig: np.ndarray, zeta: np.ndarray) -> float:
        """Length of a cause's change, the model's own numbers left free, standard deviations."""
        with_it, _ = self.every_reading((name,), np.r_[rig, zeta])
        without, slopes = self.every_reading(NONE, rig)
        white, free = map(self.levels[0.0].whitened, (with_it - without, slopes))
        return float(np.sqrt(max(white @ (white - free @ taken(white, free)), 0.0)))

    def left(self, subset: Subset, zeta: np.ndarray) -> np.ndarray:
        """Return the residual at some numbers beside the errors of rig and specimens, (n,)."""
        off = self.value - self.predicted(subset, zeta)
        return self.noise**2 * self.levels[0.0].weighed(off)

    def share(self, change: np.ndarray) -> float:
        """Root mean square of a change of the readings, by the largest of each one's channel."""
        largest = np.abs(self.value).max() if self.largest is None else self.largest
        return float(np.sqrt(np.mean((change / largest) ** 2)))

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
    """

    problem: InferenceProblem
    level: float

    def __post_init__(self) -> None:
        problem = self.problem
        total = problem.covariance + self.level**2 * problem.kernel
        total = scipy.linalg.block_diag(total, np.diag(problem.told_std**2))
        self._lower = scipy.linalg.cholesky(total, lower=True)

    @property
    def log_det(self) -> float:
        """ln|C| + n ln 2π."""
        log_2_pi = len(self._lower) * float(np.log(2 * np.pi))
        return 2 * float(np.log(np.diag(self._lower)).sum()) + log_2_pi

    @cached_property
    def _whitened(self) -> np.ndarray:
        """Z whitened, with one more column of zeros."""
        problem = self.problem
        blended = [blend.columns for blend in problem.blends.values()]
        z = np.column_stack([problem.every_value, problem.every_linear, *blended])
        return np.pad(self.whitened(z), ((0, 0), (0, 1)))

    @cached_property
    def gram(self) -> np.ndarray:
        """G of all columns, with one more row and column of zeros."""
        return np.asarray(self._whitened.T @ self._whitened)

    def whitened(self, columns: np.ndarray) -> np.ndarray:
        """L⁻¹ columns for C = L Lᵀ, shape (n,) or (n, k), with or without readings of numbers."""
        lower = self._of_first(len(columns))
        return np.asarray(scipy.linalg.solve_triangular(lower, columns, lower=True))

    def weighed(self, residual: np.ndarray) -> np.ndarray:
        """C⁻¹ r of a residual r, shape (n,)."""
        return np.asarray(scipy.linalg.cho_solve((self._of_first(len(residual)), True), residual))

    def _of_first(self, count: int) -> np.ndarray:
        """L of so many readings, the first ones."""
        return self._lower[:count, :count]

    def of(self, subset: Subset) -> Hypotheses:
        """A hypothesis under this covariance alone."""
        return Hypotheses.under([self], [subset])


SETTLED: Final = 1e-4
"""ln of probability that the last step of a fit gains at most."""

STEPS: Final = 100
"""Newton's steps of a descent, at most."""

TOGETHER: Final = 100
"""Fits that are made at once: their arrays stay within a processor's cache."""


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


class _Part(NamedTuple):
    """A blend, and where each hypothesis that has it has its functions and numbers.

    Attributes:
        causes: that act together.
        blend: of them.
        rows: which of b are its functions, shape (hypotheses, k).
        numbers: which of ζ it depends on, shape (hypotheses, d).
    """

    causes: Subset
    blend: TangentBlend
    rows: np.ndarray
    numbers: np.ndarray


@dataclass(eq=False)
class Hypotheses:
    """Sets of causes under covariances, at numbers of the model that are as told or implausible.

    Arrays have room for the most numbers and columns of any set. Columns of zeros, and numbers
    that are held at 0, fill it.

    Attributes:
        problem: the readings.
        subsets: the causes of each, with what is implausible beside them; sets of the same causes
            are one hypothesis.
        levels: of a discrepancy, with all columns under each.
    """

    problem: InferenceProblem
    subsets: Sequence[Subset]
    levels: Mapping[float, CovarianceModel]

    @classmethod
    def under(cls, models: Iterable[CovarianceModel], subsets: Iterable[Subset]) -> Hypotheses:
        """Sets of causes under the covariances of some levels of a problem, of one or more.

        Args:
            models: the covariances.
            subsets: the causes, with what is implausible beside them.
        """
        levels = {model.level: model for model in models}
        return cls(next(iter(levels.values())).problem, [*subsets], levels)

    def __post_init__(self) -> None:
        problem = self.problem
        causes_of_each = dict.fromkeys(map(problem.causes, self.subsets))
        self._place = {causes: place for place, causes in enumerate(causes_of_each)}
        count = len(self._place)
        parts = [problem.parts(causes) for causes in self._place]
        boxes = [problem.box(causes) for causes in self._place]
        self._policy, first = problem.policy, 1 + problem.linear.shape[1]
        self._sizes = np.array([len(box) for box in boxes])
        self._ends = np.array([
            first + sum(blend.columns.shape[1] for _, blend, _ in blends) for blends in parts
        ])  # fmt: skip
        self._box = np.zeros((count, self._sizes.max(), 2))
        self._bent = np.zeros_like(self._box)
        self._tail = np.ones(self._box.shape[:2])
        self._columns = np.full((count, self._ends.max()), -1)
        self._columns[:, :first] = np.arange(first)
        sizes = {causes: len(columns) for causes, columns in problem.columns.items()}
        self._parts = [
            _Part(
                causes, blend, np.zeros((count, sizes[causes]), int),
                np.zeros((count, len(blend.numbers)), int),
            )
            for causes, blend in problem.blends.items()
        ]  # fmt: skip
        at = {part.causes: place for place, part in enumerate(self._parts)}
        self._present = np.zeros((count, len(self._parts)), bool)
        for place, (subset, box, blends) in enumerate(zip(self._place, boxes, parts, strict=True)):
            self._box[place, : len(box)] = box
            bends = [number.bend for number in problem.unknowns(subset)]
            self._bent[place, : len(box)] = bends
            self._tail[place, problem.nuisance_count : len(box)] = problem.tail(subset)
            first = 1 + problem.linear.shape[1]
            for causes, _, numbers in blends:
                part, rows = self._parts[at[causes]], np.arange(first, first + sizes[causes])
                self._present[place, at[causes]] = True
                part.rows[place], part.numbers[place] = rows, numbers
                self._columns[place, rows] = problem.columns[causes]
                first += sizes[causes]

    def _prior(
        self, zeta: np.ndarray, tail: np.ndarray, width: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """−ln of the prior's density, but for ½ ln 2π a number, and each one's precision there."""
        value, precision = mixture(zeta / width, tail, self._policy.rare)
        return (value + np.log(width)).sum(axis=-1), precision / width**2

    def _width(self, subset: Subset, size: int) -> np.ndarray:
        """Standard deviations of the priors of ζ where some numbers are implausible, (size,)."""
        widths = np.ones(size)
        widths[: self.problem.nuisance_count] = self.problem.widths(subset)
        return widths

    def _factors(
        self, zeta: np.ndarray, of: np.ndarray, columns: int
    ) -> tuple[np.ndarray, np.ndarray]:
        """b, shape (places, k), and J = db/dζ, shape (places, k, d).

        Args:
            zeta: shape (places, d).
            of: hypothesis of each, shape (places,).
            columns: k.
        """
        linear = np.arange(self.problem.simulated_count, self.problem.nuisance_count)
        value = np.zeros((len(zeta), columns))
        slopes = np.zeros((*value.shape, zeta.shape[1]))
        value[:, 0], value[:, 1 : 1 + len(linear)] = 1.0, -zeta[:, linear]
        slopes[:, 1 + np.arange(len(linear)), linear] = -1.0
        present, bent = self._present[of], self._bent[of, : zeta.shape[1]]
        u, rate = coordinates(zeta, bent[..., 0], bent[..., 1])
        for which in np.flatnonzero(present.any(axis=0)):
            part, at = self._parts[which], np.flatnonzero(present[:, which])
            rows, numbers, at = part.rows[of[at]], part.numbers[of[at]], at[:, None]
            g, dg = part.blend.at_coordinates(u[at, numbers])
            value[at, rows] = -g
            slopes[at[..., None], rows[..., None], numbers[:, None]] = (
                -dg * rate[at, numbers][:, None]
            )
        return value, slopes

    def _products(self, level: float, of: np.ndarray, columns: int) -> np.ndarray:
        """G of some hypotheses' columns under the covariance of a level, shape (m, k, k).

        Args:
            level: of the discrepancy.
            of: the hypotheses, shape (m,).
            columns: k.
        """
        which = self._columns[of, :columns]
        return self.levels[level].gram[which[:, :, None], which[:, None]]

    def largest(self, level: float) -> np.ndarray:
        """ln of the largest likelihood of any change within the columns of causes, (hypotheses,).

        Args:
            level: of the discrepancy.
        """
        hypotheses = np.arange(len(self._place))
        gram = self._products(level, hypotheses, self._columns.shape[1])
        pull, inner = gram[:, 1:, :1], gram[:, 1:, 1:].copy()
        at = np.arange(inner.shape[1])
        inner[:, at, at] += 1e-9 * inner[:, at, at] + 1e-12
        followed = (pull * np.linalg.solve(inner, pull)).sum(axis=(1, 2))
        return np.asarray(-0.5 * (gram[:, 0, 0] - followed + self.levels[level].log_det))

    def misfit(self, zeta: np.ndarray, level: float) -> np.ndarray:
        """bᵀGb of the first hypothesis at many places, shape (places,).

        Args:
            zeta: shape (places, d).
            level: of the discrepancy.
        """
        columns = self._columns.shape[1]
        b, _ = self._factors(zeta, np.zeros(len(zeta), int), columns)
        (gram,) = self._products(level, np.zeros(1, int), columns)
        return np.asarray(np.einsum("pi,ij,pj->p", b, gram, b, optimize=True))

    def fit(self, starts: Sequence[np.ndarray], settled: float = SETTLED) -> MapFit:
        """The most probable ζ of the first subset from several starts, at the first level.

        Separate modes add.

        Args:
            starts: values of ζ.
            settled: ln of probability that the last step gains at most.
        """
        return self.fits({(self.subsets[0], next(iter(self.levels))): starts}, settled)[0]

    def fits(
        self, starts: Mapping[Key, Sequence[np.ndarray]], settled: float = SETTLED
    ) -> list[MapFit]:
        """Fits at several levels, and with several numbers of the model implausible, side by side.

        Args:
            starts: values of ζ by the level and by the causes with what is implausible beside them.
            settled: ln of probability that the last step gains at most.

        Returns:
            The fits in the order of the starts.
        """
        fits: dict[Key, MapFit] = {}
        by_size = sorted(starts, key=lambda key: self._ends[self._of(key[0])])
        for keys in batched(by_size, TOGETHER, strict=False):
            together = self._fitted({key: starts[key] for key in keys}, settled)
            fits |= zip(keys, together, strict=True)
        return [fits[key] for key in starts]

    def _of(self, subset: Subset) -> int:
        """Place of the hypothesis of a subset's causes."""
        return self._place[self.problem.causes(subset)]

    def _fitted(self, starts: Mapping[Key, Sequence[np.ndarray]], settled: float) -> list[MapFit]:
        """Fits all at once."""
        of = np.array([self._of(subset) for subset, _ in starts])
        levels = np.array([level for _, level in starts])
        size, columns = int(self._sizes[of].max()), int(self._ends[of].max())
        widths = np.array([self._width(subset, size) for subset, _ in starts])
        gram, volume = np.empty((len(of), columns, columns)), np.empty(len(of))
        for level in {*levels.tolist()}:
            at = np.flatnonzero(levels == level)
            gram[at], volume[at] = (
                self._products(level, of[at], columns),
                self.levels[level].log_det,
            )
        counts = [len(places) for places in starts.values()]
        which = np.repeat(np.arange(len(counts)), counts)
        first = np.zeros((len(which), size))
        for place, zeta in enumerate(chain.from_iterable(starts.values())):
            first[place, : len(zeta)] = zeta
        minima = self._descended(first, which, of, gram, widths, settled)
        volume = volume[which] + np.linalg.slogdet(minima.hessian)[1]
        best, logs, far = [], [], self._policy.unlikely
        for end, count in zip(np.cumsum(counts), counts, strict=True):
            lowest, *others = (
                end - count + np.argsort(minima.value[end - count : end], kind="stable")
            )
            modes = [lowest]
            for place in others:
                off = minima.zeta[place] - minima.zeta[modes]
                apart = (np.einsum("mi,mij,mj->m", off, minima.hessian[modes], off) > far**2).all()
                if apart and minima.value[place] < minima.value[lowest] + self._policy.hopeless:
                    modes.append(place)
            log = -minima.value[modes] - 0.5 * volume[modes]
            best.append(modes[int(np.argmax(log))])
            logs.append(float(np.logaddexp.reduce(log)))
        strengths = self._strengths(
            [subset for subset, _ in starts], minima.zeta[best], of, gram, widths
        )
        return [
            MapFit(
                subset, level, log, minima.zeta[at, :d], minima.hessian[at, :d, :d],
                float(minima.misfit[at]), strength, self._policy.visible,
            )
            for (subset, level), log, at, d, strength in zip(
                starts, logs, best, self._sizes[of], strengths, strict=True
            )
        ]  # fmt: skip

    def _at(self, zeta: np.ndarray, of: np.ndarray, gram: np.ndarray, width: np.ndarray) -> _Places:
        """−ln of the density of readings and ζ, but for ½ ln|C|.

        Args:
            zeta: shape (places, d).
            of: hypothesis of each, shape (places,).
            gram: G of each.
            width: of the priors there, shape (places, d).
        """
        b, slopes = self._factors(zeta, of, gram.shape[1])
        prior, precision = self._prior(zeta, self._tail[of, : zeta.shape[1]], width)
        pull = (gram @ b[..., None])[..., 0]
        misfit, along = (b * pull).sum(axis=1), slopes.transpose(0, 2, 1)
        hessian = along @ (gram @ slopes) + precision[..., None] * np.eye(zeta.shape[1])
        gradient = (along @ pull[..., None])[..., 0] + precision * zeta
        return _Places(zeta, 0.5 * misfit + prior, gradient, hessian, misfit)

    def _descended(
        self,
        starts: np.ndarray,
        which: np.ndarray,
        of: np.ndarray,
        gram: np.ndarray,
        width: np.ndarray,
        settled: float,
    ) -> _Places:
        """Minima by damped Newton's steps within the box (Levenberg–Marquardt).

        Damping follows how much of what a step should gain it gains (Madsen, Nielsen & Tingleff,
        Methods for Non-Linear Least Squares Problems, 2004, section 3.2). A descent that is far
        above another of the same fit, and comes no nearer, ends early.

        Args:
            starts: shape (places, d).
            which: fit of each, shape (places,).
            of: hypothesis of each fit.
            gram: G of each fit.
            width: of their priors, shape (d,) each.
            settled: ln of probability that the last step gains at most.
        """
        box, longest = self._box[of[which], : starts.shape[1]], self._policy.start
        low, high = box[..., 0], box[..., 1]
        here = self._at(np.clip(starts, low, high), of[which], gram[which], width[which])
        damping, harder = np.full(len(starts), 1e-3), np.full(len(starts), 2.0)
        at, diagonal = np.arange(len(starts)), np.arange(starts.shape[1])
        for _ in range(STEPS):
            zeta, gradient, matrix = here.zeta[at], here.gradient[at], here.hessian[at]
            held = (zeta <= low[at]) & (gradient > 0)
            held |= (zeta >= high[at]) & (gradient < 0)
            matrix[:, diagonal, diagonal] *= 1 + damping[at, None]
            matrix = np.where(held[:, None] | held[:, :, None], 0.0, matrix)
            matrix[:, diagonal, diagonal] += held
            gradient = np.where(held, 0.0, gradient)
            step = np.clip(-np.linalg.solve(matrix, gradient[..., None])[..., 0], -longest, longest)
            best = np.full(len(width), np.inf)
            np.minimum.at(best, which, here.value)
            least = np.maximum(settled, (here.value - best[which] - self._policy.hopeless) / STEPS)
            worth = -(gradient * step).sum(axis=1) >= least[at]  # less than it can gain
            at, there = at[worth], (zeta + step)[worth]
            if not len(at):
                break
            there, fits = np.clip(there, low[at], high[at]), which[at]
            tried = self._at(there, of[fits], gram[fits], width[fits])
            gain = here.value[at] - tried.value
            better, moved = gain > 0, there - here.zeta[at]
            promised = -(here.gradient[at] * moved).sum(axis=1)
            promised -= 0.5 * np.einsum("pi,pij,pj->p", moved, here.hessian[at], moved)
            part = np.clip(gain / np.maximum(promised, 1e-12), 0.0, 1.0)
            turned = 2 * part - 1
            easier = np.maximum(0.5, 1 - turned * turned**2)
            damping[at] *= np.where(better, easier, harder[at])
            harder[at] = np.where(better, 2.0, 2 * harder[at])
            going = np.where(better, gain >= least[at], harder[at] < 100)
            here.move(at[better], tried.of(better))
            at = at[going]
        return here

    def _strengths(
        self,
        subsets: Sequence[Subset],
        zeta: np.ndarray,
        of: np.ndarray,
        gram: np.ndarray,
        width: np.ndarray,
    ) -> list[tuple[float, ...]]:
        """Strengths of the names of each subset at its ζ, standard deviations.

        The model's own numbers follow a cause's change as far as their priors let them.
        """
        b, slopes = self._factors(zeta, of, gram.shape[1])
        rig = slice(0, self.problem.nuisance_count)
        free = slopes[..., rig]
        along = free.transpose(0, 2, 1)
        inner = along @ gram @ free + width[:, rig, None] ** -2 * np.eye(rig.stop)
        strengths = {n: np.abs(zeta[:, place]) for n, place in self.problem.implausible.items()}
        for part, present in zip(self._parts, self._present[of].T, strict=True):
            if len(part.causes) == 1:
                at = np.flatnonzero(present)
                change = np.zeros((len(at), b.shape[1], 1))
                rows = part.rows[of[at]]
                np.put_along_axis(change[..., 0], rows, b[at[:, None], rows], axis=1)
                pull = gram[at] @ change
                cross = along[at] @ pull
                left = (pull * change).sum(axis=(1, 2))
                left -= (cross * np.linalg.solve(inner[at], cross)).sum(axis=(1, 2))
                strengths[part.causes[0]] = np.zeros(len(zeta))
                strengths[part.causes[0]][at] = np.sqrt(np.maximum(left, 0.0))
        return [
            tuple(float(strengths[name][row]) for name in subset)
            for row, subset in enumerate(subsets)
        ]

    def sampled(self, fit: MapFit, rng: np.random.Generator) -> MapFit:
        """The evidence of the first hypothesis by importance sampling, with draws.

        The fit itself where too few of the draws count.
        """
        (low, high), width = self._box[0].T, self._width(fit.subset, len(fit.zeta))
        log_det = self.levels[fit.level].log_det

        def log_density(zeta: np.ndarray) -> np.ndarray:
            inside = ((zeta >= low) & (zeta <= high)).all(axis=1)
            misfit = self.misfit(np.clip(zeta, low, high), fit.level)
            value = 0.5 * (misfit + log_det) + self._prior(zeta, self._tail[0], width)[0]
            norm = 0.5 * zeta.shape[1] * np.log(2 * np.pi)
            return np.where(inside, -value - norm, -np.inf)

        draws = drawn(log_density, fit.zeta, np.linalg.inv(fit.hessian), rng, self._policy)
        if draws is None:
            return fit
        places, weights, integral = draws
        return replace(fit, log_evidence=integral, draws=(places, weights))


def taken(change: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """How much of a change other numbers take over, in standard deviations of each, shape (k,).

    Args:
        change: of the readings, by their noise, shape (n,).
        columns: changes by one standard deviation of each number, shape (n, k). Their priors let
            them follow as far as that.
    """
    inner = columns.T @ columns + np.eye(columns.shape[1])
    return np.asarray(np.linalg.solve(inner, columns.T @ change))
