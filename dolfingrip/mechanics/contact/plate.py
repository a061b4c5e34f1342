"""The force-sensor plate: a rigid plane that faces part of the skin."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import ClassVar

import numpy as np
import scipy.sparse as sp
import ufl
from dolfinx import fem, la
from mpi4py import MPI
from petsc4py import PETSc
from ufl.core.expr import Expr

from dolfingrip.forms import plate as form
from dolfingrip.mechanics.contact.node_set import NodeSet
from dolfingrip.mechanics.contact.tangential import Tangential
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.term import Term
from dolfingrip.mechanics.model.unknowns import Number


class RigidPlate(Term):
    """Plane n · x = offset on whose side n points the skin stays.

    The plane lies one barrier width behind the position that first feels the skin, so that a
    gap of 0 is a touch without force.

    Args:
        u: displacement (mm).
        domain: reference configuration.
        region: name of the part of ``domain``'s boundary that may touch.
        normal: (3,) towards the finger; any length.
        gap_mm: distance that the nearest point of ``region`` travels along −n before it
            is felt.
        width_mm: barrier width ĝ.
        stiffness_MPa: barrier stiffness κ.

    Attributes:
        energy: the UFL form of its potential.
        reaction: that of the normal force on the meshed part, dΠ/d(offset).
        offset: the plane's position along n (mm), a constant of the form.
        number: the plane's position as an unknown, where it is one.
    """

    name: ClassVar[str] = "plate"

    def __init__(
        self,
        u: fem.Function,
        domain: Domain,
        region: str,
        normal: np.ndarray,
        *,
        gap_mm: float,
        width_mm: float,
        stiffness_MPa: float,
    ) -> None:
        self.number: Number | None = None
        self._u = u
        self._copies = domain.copies
        space, mesh = u.function_space, domain.mesh
        facets = domain.facets(region)
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        nodes = fem.locate_dofs_topological(space, 2, facets)
        self._nodes = nodes[nodes < space.dofmap.index_map.size_local]
        self._rest = space.tabulate_dof_coordinates()[self._nodes] @ self.normal
        nearest = mesh.comm.allreduce(self._rest.min(initial=np.inf), MPI.MIN)
        self.width_mm = width_mm
        self.offset = fem.Constant(mesh, PETSc.ScalarType(nearest - gap_mm - width_mm))

        n = fem.Constant(mesh, self.normal)
        facet = mesh.ufl_cell().facet_types()[0].cellname()
        ds = domain.surface(region, **form.nodal_rule(facet, space.ufl_element().degree))
        width = fem.Constant(mesh, PETSc.ScalarType(width_mm))
        stiffness = fem.Constant(mesh, PETSc.ScalarType(stiffness_MPa))

        def density(offset: Expr) -> Expr:
            return form.energy(form.distance(u, mesh, n, offset), width, stiffness)

        position = ufl.variable(self.offset)
        self.energy = density(self.offset) * ds
        pressure = ufl.diff(density(position), position)
        self.reaction = pressure * ds
        self._reaction = fem.form(self.reaction, jit_options=jit.options())
        self._share: Callable[[Expr], ufl.Form] = lambda test: pressure * ufl.inner(n, test) * ds

    # -- for friction ----------------------------------------------------------------------------

    @cached_property
    def touching(self) -> NodeSet:
        """Nodes of the skin that may touch the plane."""
        space = self._u.function_space
        own = space.dofmap.index_map.local_to_global(self._nodes.astype(np.int32))
        return NodeSet(space, np.unique(np.concatenate(space.mesh.comm.allgather(own))))

    @cached_property
    def _shares(self) -> fem.Form:
        """The reaction's shares of the nodes, along the normal."""
        test = ufl.TestFunction(self._u.function_space)
        return fem.form(self._share(test), jit_options=jit.options())

    def tangential(self, dofs: np.ndarray) -> Tangential:
        """Nodes that touch the plane, with their shares of the reaction.

        The reaction is integrated at the nodes, so that a share is the pressure there by the
        node's area, and they sum to the reaction. The plane moves along its normal alone.
        """
        shares = fem.assemble_vector(self._shares)
        shares.scatter_reverse(la.InsertMode.add)
        normal_N = self.touching.at_nodes(shares.array) @ self.normal
        pressed = np.flatnonzero(normal_N > 0)
        return Tangential(
            sp.eye_array(len(normal_N), format="csr")[pressed],
            np.tile(self.normal, (len(pressed), 1)),
            normal_N[pressed],
            self.touching.nodes[pressed, None],
        )

    # -- as a sensor -----------------------------------------------------------------------------

    def force_N(self) -> float:
        """Normal force on the whole finger's plate."""
        local = fem.assemble_scalar(self._reaction)
        return float(self._copies * self._u.function_space.mesh.comm.allreduce(local))

    def gap_mm(self) -> float:
        """Smallest distance of the skin's nodes from the plane."""
        gaps = self._distance(self._u.x.array)
        smallest = gaps.min(initial=np.inf)
        return float(self._u.function_space.mesh.comm.allreduce(smallest, MPI.MIN))

    def offset_rate(self, velocity: fem.Function) -> float:
        """How fast the plane follows the nearest point as the reference points move (mm)."""
        moving = fem.Function(self._u.function_space)
        moving.interpolate(velocity)
        rates = moving.x.array.reshape(-1, 3)[self._nodes] @ self.normal
        first = int(self._rest.argmin()) if len(self._rest) else None
        own = (np.inf, 0.0) if first is None else (self._rest[first], rates[first])
        return float(min(self._u.function_space.mesh.comm.allgather(own))[1])

    def _distance(self, dofs: np.ndarray) -> np.ndarray:
        moved = dofs.reshape(-1, 3)[self._nodes] @ self.normal
        return self._rest + moved - float(self.offset.value)

    def max_step(self, dofs: np.ndarray, step: np.ndarray) -> float:
        """Largest fraction of ``step`` that leaves each node a tenth of its distance."""
        now = self._distance(dofs)
        moved = step[: len(dofs)].reshape(-1, 3)[self._nodes] @ self.normal
        approach = (0.0 if self.number is None else self.number.change(step)) - moved
        closing = approach > 0
        allowed = (0.9 * now[closing] / approach[closing]).min(initial=1.0)
        return float(self._u.function_space.mesh.comm.allreduce(allowed, MPI.MIN))
