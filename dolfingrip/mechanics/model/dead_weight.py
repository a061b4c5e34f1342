"""Dead weight of placed copies of a solid."""

from __future__ import annotations

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
        weight_N_mm3: (3,) ρ g in the world.
    """

    name: ClassVar[str] = "weight"

    def __init__(self, u: fem.Function, domain: Domain, weight_N_mm3: np.ndarray) -> None:
        space = u.function_space
        degree = space.ufl_element().degree
        test = ufl.TestFunction(space)
        share = fem.form(
            test[0] * domain.volume(quadrature_degree=degree), jit_options=jit.options()
        )
        vector = fem.assemble_vector(share)
        vector.scatter_reverse(la.InsertMode.add)
        owned = space.dofmap.index_map.size_local
        volumes = np.asarray(vector.array[: NODE * owned : NODE])
        loads = np.tile(np.asarray(weight_N_mm3, dtype=float), (owned, 1))
        if domain.placement is not None:
            points = space.tabulate_dof_coordinates()[:owned]
            loads = to_reference(domain.placement.frames(points), loads)
        self._loads_N = volumes[:, None] * loads
        self._comm = space.mesh.comm
        self._owned = NODE * owned

    def value(self, dofs: np.ndarray) -> float:
        """Potential (mJ), 0 where nothing is displaced."""
        local = -float(self._loads_N.ravel() @ dofs[: self._owned])
        return float(self._comm.allreduce(local, MPI.SUM))

    def add_gradient(self, dofs: np.ndarray, gradient: Gradient) -> None:
        """Add minus the weight (N)."""
        gradient.at_nodes[:] -= self._loads_N
