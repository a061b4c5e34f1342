"""The laws of the base material that are fitted to coupons.

Each energy stands in a file of its own; here it is a function of numbers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from dolfingrip.forms.isotropic import Invariants
from dolfingrip.forms.jet import Jet
from dolfingrip.sections import tables
from dolfingrip.sections.laws.index import LAWS as MATERIALS
from dolfingrip.sections.laws.law import Fittable, MaterialLaw


@dataclass(frozen=True, slots=True)
class Law:
    """A strain energy with parameters.

    Attributes:
        fittable: its values with their starts and bounds.
        keys: keys of its parameters in the configuration; entries of lists are numbered from 0.
        material: law of the base material.
    """

    fittable: Fittable
    keys: tuple[str, ...]
    material: type[MaterialLaw]

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
        table = self.tables(values)["material"]
        c = {key: value for key, value in table.items() if key != "law"}
        return self.material.energy(c, invariants)

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


LAWS: Final[Mapping[str, Law]] = {
    law.name: law
    for law in (_of_material(law, each) for law in MATERIALS.values() for each in law.fits)
}
"""By name."""
