"""Linear tetrahedra, which lock."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect

if TYPE_CHECKING:
    from dolfingrip.config import Config


class Locking(Effect):
    """Linear instead of quadratic tetrahedra.

    u_h ∈ P₁ instead of P₂ (``solver.element = "P1"``) on the same mesh: walls of one element
    across cannot bend, nearly incompressible ones hardly deform.

    Prior: none; a choice of the model and no property of the finger.
    Fingerprint: angle lower by a third and more, force less so; nearly one factor at all
    pressures. Loading and unloading agree.
    Confused with: the modulus, wall thickness.
    """

    kind: ClassVar = "numerical"
    neutral: ClassVar = {"linear": False}

    linear: bool = Field(True, description="linear tetrahedra")

    def adapt(self, config: Config) -> Config:
        return config.changed(solver={"element": "P1"}) if self.linear else config
