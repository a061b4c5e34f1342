"""The energies of a solid in motion."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.channels import ENERGIES
from dolfingrip.mechanics.model.inertia import Inertia
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.readings.reading import Reading


class Energy(Reading):
    """Kinetic energy of the whole solid (mJ), with the potential Π of all forces where asked for.

    It is read where a load step was accepted, from when on no time has passed.

    Args:
        model: model that is read.
        column: name in the table.
        inertia: of the solid.
        potential: whether Π is added. The sum stays the same while loads do, and nothing is lost.
    """

    differentiable: ClassVar = False

    def __init__(self, model: Model, column: str, inertia: Inertia, *, potential: bool) -> None:
        super().__init__(model, column)
        self._inertia, self._potential = inertia, potential

    def value(self) -> float:
        potential_mJ = self.model.energy() if self._potential else 0.0
        return self.model.domain.copies * (self._inertia.kinetic_mJ() + potential_mJ)


def energies(model: Model, inertia: Inertia) -> list[Energy]:
    """Return the readings of a solid's energies, one for each of the channels of energy.

    Args:
        model: model that is read.
        inertia: of its solid.
    """
    pairs = zip(ENERGIES, (False, True), strict=True)
    return [Energy(model, one.name, inertia, potential=total) for one, total in pairs]
