"""The readings of a measurement, and what could explain them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from dolfingrip.diagnosis.core.emulator import Emulator, Local
from dolfingrip.diagnosis.core.scaled import Factor
from dolfingrip.diagnosis.policy import POLICY

Subset = tuple[str, ...]
"""Names of causes, in the order of the case; then of the model's own numbers that are far off."""


def mended_name(subset: Subset) -> str:
    """Name of what simulations told beyond the emulators, where these causes act."""
    return "mended: " + " with ".join(subset)


GROUND = "ground"
"""Name of the columns that the model's own numbers change."""


@dataclass(frozen=True, eq=False)
class Case:
    """Readings, and what could explain them.

    Attributes:
        value: y, shape (n,).
        base: y₀ as configured, shape (n,).
        factor: of all moduli, the first of the model's own numbers.
        emulators: of the causes, by name.
        covariance: of noise and nuisances, shape (n, n).
        kernel: of the discrepancy at a level of 1, shape (n, n).
        boxes: ranges of ζ of each cause, (d, 2).
        mended: what simulations told beyond the sum of the emulators, by the causes that acted; of
            the model's own numbers and those of all.
        local: ranges of ζ, (d, 2), of effects in which that holds, and what each emulator misses,
            too. It holds for these alone.
        rig: which of the causes are numbers of the rig; they come last in every subset.
        ground: what the model's own numbers change: all moduli, and others that are fitted in every
            hypothesis.
        others: ranges of ζ of the model's own numbers beside the moduli, (m, 2).
        ground_names: what each of them is named where it is far from what was told, in a subset by
            the first of the names; empty where it cannot be.
    """

    value: np.ndarray
    base: np.ndarray
    factor: Factor
    emulators: Mapping[str, Emulator]
    covariance: np.ndarray
    kernel: np.ndarray
    boxes: Mapping[str, np.ndarray]
    ground: Emulator
    mended: Mapping[Subset, Emulator] = field(default_factory=dict)
    local: Mapping[Subset, np.ndarray] = field(default_factory=dict)
    rig: frozenset[str] = frozenset()
    others: np.ndarray = field(default_factory=lambda: np.zeros((0, 2)))
    ground_names: tuple[tuple[str, ...], ...] = (("modulus",),)

    @property
    def ground_box(self) -> np.ndarray:
        """Ranges of ζ of the model's own numbers, (own, 2); that of the moduli first."""
        return np.vstack([[self.factor.low, self.factor.high], self.others])

    @property
    def own(self) -> int:
        """Count of the model's own numbers, which come first in every ζ."""
        return 1 + len(self.others)

    def rows(self, kept: np.ndarray) -> Case:
        """The case of some of the readings."""
        return replace(
            self, value=self.value[kept], base=self.base[kept],
            emulators={name: each.rows(kept) for name, each in self.emulators.items()},
            covariance=self.covariance[np.ix_(kept, kept)], kernel=self.kernel[np.ix_(kept, kept)],
            mended={causes: each.rows(kept) for causes, each in self.mended.items()},
            ground=self.ground.rows(kept),
        )  # fmt: skip

    @property
    def far(self) -> dict[str, int]:
        """Which of ζ each of the model's own numbers is that may be far off, by name."""
        return {names[0]: place for place, names in enumerate(self.ground_names) if names}

    @property
    def simulated(self) -> dict[Subset, Local]:
        """Which of ``mended`` hold what simulations at fits told."""
        return {each: own for each, own in self.mended.items() if isinstance(own, Local)}

    def widths(self, subset: Subset) -> np.ndarray:
        """Standard deviations of the priors of the model's own numbers, by those told, (own,)."""
        found = np.ones(self.own)
        for name, place in self.far.items():
            if name in subset:
                found[place] = POLICY.far
        return found

    def causes(self, subset: Subset) -> Subset:
        """What has numbers of its own: all but the model's numbers."""
        return tuple(name for name in subset if name in self.emulators)

    def effects(self, subset: Subset) -> Subset:
        """Causes that are no numbers of the rig."""
        return tuple(name for name in self.causes(subset) if name not in self.rig)

    def places(self, subset: Subset) -> dict[str, np.ndarray]:
        """Which of ζ are the numbers of each cause."""
        found, at = {}, self.own
        for name in self.causes(subset):
            found[name] = np.arange(at, at + len(self.boxes[name]))
            at += len(self.boxes[name])
        return found

    def parts(self, subset: Subset) -> list[tuple[str, Emulator, np.ndarray]]:
        """Emulators of a hypothesis: name, function, and which of ζ it depends on."""
        found = [(GROUND, self.ground, np.arange(self.own))]
        places, effects = self.places(subset), self.effects(subset)
        for name, own in places.items():
            each = self.emulators[name]
            found.append((name, each, np.r_[np.array(each.takes, int), own]))
        for causes, each in self.mended.items():
            if places.keys() >= {*causes} and (causes not in self.local or causes == effects):
                every = [np.arange(self.own), *(places[name] for name in causes)]
                found.append((mended_name(causes), each, np.concatenate(every)))
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

    def corrected(self, subset: Subset, zeta: np.ndarray, exact: np.ndarray) -> Case:
        """The case with what a simulation tells beyond the emulators.

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
        found = replace(self, mended={})
        for each in sorted(known, key=len):  # fewer causes count where more act
            places, every = known[each]
            told = [
                np.column_stack([found.predicted(each, z), found.slopes(each, z)]) for z in places
            ]
            own = Local.of(places, every, np.array(told), POLICY.mended_length)
            found = replace(found, mended={**found.mended, each: own})
        return found
