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

AWAY_mm = 1e4
"""How far from a finger a plate is that is not there."""


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
            is felt, from the pose against which the plate is put, at first the undeformed one.
        width_mm: barrier width ĝ.
        stiffness_MPa: barrier stiffness κ.

    Attributes:
        energy: the UFL form of its potential.
        reaction: that of the normal force on the meshed part, dΠ/d(offset).
        offset: the plane's position along n (mm), a constant of the form.
        unloaded: constant: the position at which a plate that gives way stands without force (mm).
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
        self._coordinates = space.tabulate_dof_coordinates()[self._nodes].copy()
        self._now = self._coordinates
        self._rest = self._now @ self.normal
        self.width_mm = width_mm
        self._gap_mm = gap_mm
        self._away = False
        place = PETSc.ScalarType(self.place_mm())
        self.offset, self.unloaded = fem.Constant(mesh, place), fem.Constant(mesh, place)

        self._facing = n = fem.Constant(mesh, self.normal)
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

    # -- where it is put -------------------------------------------------------------------------

    def put(self, place_mm: float | None = None) -> None:
        """Put the plate at its gap from the present pose, or at a place along its normal (mm)."""
        self.offset.value = self.unloaded.value = self.place_mm() if place_mm is None else place_mm
        self._away = False

    def retract(self) -> None:
        """Put the plate where nothing touches it."""
        self.put(self.place_mm() - AWAY_mm)
        self._away = True

    def place_mm(self) -> float:
        """Position along n at the gap from the present pose."""
        along = self._along().min(initial=np.inf)
        nearest = float(self._u.function_space.mesh.comm.allreduce(along, MPI.MIN))
        return nearest - self._gap_mm - self.width_mm

    def nearest_node(self) -> int | None:
        """This rank's node that is nearest to the plate; None where another rank has it."""
        along = self._along()
        own = float(along.min(initial=np.inf)), self._u.function_space.mesh.comm.rank
        first = min(self._u.function_space.mesh.comm.allgather(own))
        return int(self._nodes[along.argmin()]) if first == own else None

    def place_rate(self, velocity: fem.Function) -> float:
        """How fast :meth:`place_mm` follows as the reference points move (mm)."""
        moving = fem.Function(self._u.function_space)
        moving.interpolate(velocity)
        node = self.nearest_node()
        own = 0.0 if node is None else float(moving.x.array.reshape(-1, 3)[node] @ self.normal)
        return float(self._u.function_space.mesh.comm.allreduce(own, MPI.SUM))

    def _along(self) -> np.ndarray:
        """Positions of the nodes that may touch, along n (mm)."""
        return self._rest + self._u.x.array.reshape(-1, 3)[self._nodes] @ self.normal

    def move_reference(self, change: np.ndarray | None) -> None:
        """Take the facing nodes to be moved by ``change`` (local array, mm); None: put back."""
        self._now = self._coordinates
        if change is not None:
            self._now = self._now + change.reshape(-1, 3)[self._nodes]
        self._rest = self._now @ self.normal

    def pose(self, normal: np.ndarray, gap_mm: float, dofs: np.ndarray) -> None:
        """Turn the plate and put it at a gap from the skin displaced by ``dofs``.

        A place that is solved for stays: its spring's end moves. A plate that is away stays so.
        """
        self.normal = np.asarray(normal, dtype=float) / np.linalg.norm(normal)
        self._facing.value[:] = self.normal
        self._rest = self._now @ self.normal
        self._gap_mm = gap_mm
        if self._away:
            return
        along = self._rest + dofs.reshape(-1, 3)[self._nodes] @ self.normal
        comm = self._u.function_space.mesh.comm
        nearest = comm.allreduce(along.min(initial=np.inf), MPI.MIN)
        self.unloaded.value = nearest - gap_mm - self.width_mm
        if self.number is None:
            self.offset.value = self.unloaded.value

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
