"""An inference problem: readings, and what could explain them, as functions of unknowns.

The readings are linear in fixed columns, r = Z b(ζ) with Z = [y, Φ₀, Φ₁, …] and b = [1, −g₀, −g₁,
…]; g₀ is of the model's own numbers, each other g of what a cause changes, or several beyond their
sum. How strongly readings feel a cause is told with the model's own numbers left free.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import scipy.linalg

from dolfingrip.diagnosis.core.blend import TangentBlend, Tangents
from dolfingrip.diagnosis.core.covariance import CovarianceModel, taken
from dolfingrip.diagnosis.core.unknown import NumberReading, Unknown, expected, linear_in
from dolfingrip.diagnosis.policy import Policy

Subset = tuple[str, ...]
"""Names of causes, as the problem has them; then of the model's own numbers that are far off."""

Key = tuple[Subset, float]
"""Causes, and the level of a discrepancy beside them."""

NONE: Subset = ()


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
        """Z under the covariance of each level of the discrepancy."""
        columns = [blend.columns for blend in self.blends.values()]
        z = np.column_stack([self.every_value, self.every_linear, *columns])
        of_numbers = np.diag(np.square(self.told_std))
        return {
            level: CovarianceModel(
                scipy.linalg.block_diag(self.covariance + level**2 * self.kernel, of_numbers), z
            )
            for level in self.policy.levels
        }

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
            numbers = problem.simulated(causes)
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

    def simulated(self, causes: Iterable[str]) -> list[Unknown]:
        """Numbers that simulations of some causes are functions of, the model's own first.

        Args:
            causes: their names.
        """
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
