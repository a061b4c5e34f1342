"""The inference problem: readings of a measurement, and what could explain them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from dolfingrip.diagnosis.core.emulator import Emulator, Local
from dolfingrip.diagnosis.core.unknown import Factor, Unknown
from dolfingrip.diagnosis.policy import POLICY, InferencePolicy

Subset = tuple[str, ...]
"""Names of causes, in the order of the problem; then of the nuisances that are implausible."""


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
        corrections: what simulations give beyond the sum of the emulators, by the causes that act;
            functions of the nuisances and of the numbers of all these causes.
        local: ranges of ζ, (d, 2), of effects in which that holds, and what each emulator misses,
            too. It holds for these alone.
        rig: which of the causes are numbers of the rig; they come last in every subset.
        remembering: causes with memory, of which the readings tell a curve's shape alone.
        curves: of any smooth elastic curve, shape (n, k); causes with memory have to do better.
        policy: numbers that hypotheses are searched, weighed and decided by.
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
    rig: frozenset[str] = frozenset()
    remembering: frozenset[str] = frozenset()
    curves: np.ndarray | None = None
    policy: InferencePolicy = POLICY

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
                found[place] = self.policy.implausible_width
        return found

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
            own = Local.of(places, every, np.array(emulated), self.policy.correction_length)
            found = replace(found, corrections={**found.corrections, each: own})
        return found
