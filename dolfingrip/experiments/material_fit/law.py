"""The laws that are fitted to coupons: those of the base material, and neo-Hooke's with an effect.

Each energy stands in a file of its own; here it is a function of numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from dolfingrip.extensions.effect import Effect
from dolfingrip.extensions.index import EFFECTS
from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections import tables
from dolfingrip.sections.laws.index import LAWS as MATERIALS
from dolfingrip.sections.laws.law import Fittable, MaterialLaw
from dolfingrip.sections.laws.neo_hooke import NeoHooke


@dataclass(frozen=True, slots=True)
class Law:
    """A strain energy with parameters.

    Attributes:
        fittable: its values with their starts and bounds.
        keys: keys of its parameters in the configuration; entries of lists are numbered from 0.
        material: law of the base material.
        effect: effect that is added to that law, if there is one.
    """

    fittable: Fittable
    keys: tuple[str, ...]
    material: type[MaterialLaw]
    effect: type[Effect] | None = None

    @property
    def name(self) -> str:
        """Name by which ``--law`` chooses it."""
        return self.fittable.name

    @property
    def title(self) -> str:
        """Name in tables."""
        return self.fittable.title

    def energy(self, values: Sequence[float] | np.ndarray, invariants: Invariants) -> Jet:
        """Energy per reference volume at constant volume (mJ/mm³), with its derivatives."""
        found = self.tables(values)
        c = {key: value for key, value in found["material"].items() if key != "law"}
        energy = self.material.energy(c, invariants)
        if self.effect is None:
            return energy
        own = found["extensions"][self.effect.name()]
        return energy + self.effect.in_numbers(own, c["mu_MPa"], invariants)

    def tables(self, values: Sequence[float] | np.ndarray) -> dict[str, Any]:
        """Tables of the configuration with these values, by name."""
        change: dict[str, Any] = {"material.law": self.material.law_name()}
        for key, value in zip(self.keys, values, strict=True):
            path, _, place = key.partition("[")
            if place:
                change.setdefault(path, []).append(float(value))
            else:
                change[path] = float(value)
        found: dict[str, Any] = {}
        tables.put(found, change)
        return found


def _of_material(law: type[MaterialLaw], fittable: Fittable) -> Law:
    return Law(fittable, tuple(f"material.{key}" for key in fittable.keys), law)


def _of_effect(effect: type[Effect], fittable: Fittable) -> Law:
    """Neo-Hooke's modulus, followed by an effect's parameters."""
    (base,) = NeoHooke.fits
    own = tuple(f"extensions.{effect.name()}.{key}" for key in fittable.keys)
    keys = (*(f"material.{key}" for key in base.keys), *own)

    def starts(shear_MPa: float) -> Sequence[Sequence[float]]:
        (first,) = base.starts(shear_MPa)
        return [[*first, *each] for each in fittable.starts(shear_MPa)]

    both = replace(
        fittable,
        keys=keys,
        starts=starts,
        low=(*base.low, *fittable.low),
        high=(np.inf, *fittable.high),
    )
    return Law(both, keys, NeoHooke, effect)


LAWS: Final[Mapping[str, Law]] = {
    law.name: law
    for law in (
        *(_of_material(law, each) for law in MATERIALS.values() for each in law.fits),
        *(_of_effect(effect, each) for effect in EFFECTS for each in effect.fits),
    )
}
"""By name."""
