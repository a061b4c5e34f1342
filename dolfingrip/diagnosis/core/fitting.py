"""The most probable numbers of hypotheses, and the evidence of each.

For a covariance C of noise, nuisances and discrepancy

    G = Zᵀ C⁻¹ Z

is computed once; each hypothesis then costs the same for any number of readings. With the prior's
density p(ζ), its precisions W at the most probable ζ, J = db/dζ and H = JᵀGJ + W there (Laplace's
method; MacKay, Information Theory, 2003, chapter 27)

    ln p(y) = −½ bᵀGb + ln p(ζ) + d/2 ln 2π − ½ ln|H| − ½ ln|C| − n/2 ln 2π
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import batched, chain
from typing import Final, NamedTuple

import numpy as np

from dolfingrip.diagnosis.core.blend import TangentBlend
from dolfingrip.diagnosis.core.problem import InferenceProblem, Key, Subset
from dolfingrip.diagnosis.core.sampling import drawn
from dolfingrip.diagnosis.core.unknown import coordinates, mixture
from dolfingrip.diagnosis.policy import Policy

SETTLED: Final = 1e-4
"""ln of probability that the last step of a fit gains at most."""

STEPS: Final = 100
"""Newton's steps of a descent, at most."""

TOGETHER: Final = 100
"""Fits that are made at once: their arrays stay within a processor's cache."""


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
    """

    problem: InferenceProblem
    subsets: Sequence[Subset]

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
        return self.problem.levels[level].gram[which[:, :, None], which[:, None]]

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
        return np.asarray(-0.5 * (gram[:, 0, 0] - followed + self.problem.levels[level].log_det))

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
                self.problem.levels[level].log_det,
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
        log_det = self.problem.levels[fit.level].log_det

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
