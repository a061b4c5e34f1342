"""Dead weight of placed copies of a solid."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import ufl
from dolfinx import fem, la
from mpi4py import MPI

from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.placement import to_reference
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import NODE, Gradient


class DeadWeight(Term):
    """Π = −∫ ρ g · x dX over a solid whose copies are turned: g is fixed in the world.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        weights_N_mm3: the names of parts, none for the whole, and (3,) ρ g of them in the world.
    """

    name: ClassVar[str] = "weight"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        weights_N_mm3: Sequence[tuple[tuple[str, ...], np.ndarray]],
    ) -> None:
        space = u.function_space
        owned = space.dofmap.index_map.size_local
        loads = np.zeros((owned, NODE))
        for parts, weight in weights_N_mm3:
            loads += np.outer(_volumes(space, domain, parts), weight)
        if domain.placement is not None:
            points = space.tabulate_dof_coordinates()[:owned]
            loads = to_reference(domain.placement.frames(points), loads)
        self._loads_N = loads
        self._comm = space.mesh.comm
        self._owned = NODE * owned

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ), 0 where nothing is displaced."""
        local = -float(self._loads_N.ravel() @ dofs[: self._owned])
        return float(self._comm.allreduce(local, MPI.SUM))

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add minus the weight (N)."""
        gradient.at_nodes[:] -= self._loads_N


def _volumes(space: fem.FunctionSpace, domain: Domain, parts: Sequence[str]) -> np.ndarray:
    """Volume (mm³) that each owned node bears, ∫ N dX over the named parts."""
    degree = space.ufl_element().degree
    test = ufl.TestFunction(space)
    measure = domain.volume(*parts, quadrature_degree=degree)
    vector = fem.assemble_vector(fem.form(test[0] * measure, jit_options=jit.options()))
    vector.scatter_reverse(la.InsertMode.add)
    return np.asarray(vector.array[: NODE * space.dofmap.index_map.size_local : NODE])
