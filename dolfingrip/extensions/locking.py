"""Linear tetrahedra, which are too stiff in thin walls: they lock."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from dolfingrip.extensions.effect import Effect, Setup


class Locking(Effect):
    """Linear tetrahedra instead of quadratic elements.

    u_h ∈ P₁ (``solver.element = "P1"``): walls of one element across cannot bend, nearly
    incompressible ones hardly deform. As there are linear elements on tetrahedra only, the mesh
    changes, too: a finger that would be meshed in hexahedra gets tetrahedra of ``mesh.size_mm``,
    2.8 mm by default, not graded. On quadratic tetrahedra (``solver.element = "P2"``) the mesh
    stays.

    Prior: none; a choice of the model and no property of the finger.
    Fingerprint: angle lower by 62 % at 25 kPa and by 53 % at 250 kPa, force by 16 and 25 %. Loading
    and unloading agree.
    Confused with: the modulus, wall thickness.
    """

    kind: ClassVar = "numerical"
    place: ClassVar = 2
    neutral: ClassVar = {"linear": False}

    linear: bool = Field(True, description="linear tetrahedra")

    def adapt[S: Setup](self, config: S) -> S:
        if not self.linear:
            return config
        # how hexahedra are graded says nothing about tetrahedra, which may be smaller altogether
        mesh = {"edge_size_mm": None} if config.hexahedra else {}
        return config.changed(solver={"element": "P1"}, mesh=mesh)
