"""Dead weight of a solid, or of placed copies of one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.mechanics.model.assembly import owned_vector
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.placement import to_reference
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.term import NoShapeGradient, Term
from dolfingrip.mechanics.model.unknowns import NODE, Gradient


class DeadWeight(Term):
    """Π = −∫ ρ g · u dX, where g is fixed in the world for any rotation of the solid's copies.

    It is linear in u: the weight that each node bears is assembled once.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        weights_N_mm3: by the names of parts, none for the whole, the constants (3,) ρ g of them in
            the world.
    """

    name: ClassVar[str] = "weight"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        weights_N_mm3: Mapping[tuple[str, ...], fem.Constant],
    ) -> None:
        self._space = space = u.function_space
        self._weights = list(weights_N_mm3.values())
        parts = [
            domain.volume(*names, quadrature_degree=space.ufl_element().degree)
            for names in weights_N_mm3
        ]
        pairs = zip(self._weights, parts, strict=True)
        self._energies = [-ufl.inner(weight, u) * part for weight, part in pairs]
        test = ufl.TestFunction(space)
        self._volume = [test[0] * part for part in parts]
        placement, owned = domain.placement, space.dofmap.index_map.size_local
        points = space.tabulate_dof_coordinates()[:owned]
        self._frames = None if placement is None else placement.frames(points)
        self._volumes_mm3 = self._measured_mm3()

    def _measured_mm3(self) -> list[np.ndarray]:
        """Volume at each owned node, for each part."""
        return [owned_vector(form)[::NODE] for form in self._volume]

    def _loads_N(self, volumes_mm3: list[np.ndarray]) -> np.ndarray:
        """Weight (n, 3) that each owned node bears, for volumes ∫ N dX that it has of each part."""
        pairs = zip(volumes_mm3, self._weights, strict=True)
        loads = sum(np.outer(volumes, weight.value) for volumes, weight in pairs)
        return to_reference(self._frames, np.asarray(loads))

    # -- as a term -------------------------------------------------------------------------------

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ) of the meshed part; it is 0 without displacement."""
        loads = self._loads_N(self._volumes_mm3).ravel()
        local = -float(loads @ dofs[: len(loads)])
        return float(self._space.mesh.comm.allreduce(local, MPI.SUM))

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add minus the weight (N)."""
        gradient.at_nodes[:] -= self._loads_N(self._volumes_mm3)

    def add_shape_gradient(self, dofs: np.ndarray, gradient: ShapeGradient) -> None:
        """Add the derivatives by the reference coordinates, of one solid that is not placed."""
        if self._frames is not None:
            raise NoShapeGradient(f"{self.name} of placed copies: no derivative by coordinates")
        for form in self._energies:
            gradient.add_form(form)

    def move_reference(self, change: np.ndarray | None) -> None:
        """Compute the volumes of the mesh at its present place."""
        self._volumes_mm3 = self._measured_mm3()
