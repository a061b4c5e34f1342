"""The displacement nodes of a deformable surface, with their shares of its area."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import numpy as np
import ufl
from dolfinx import cpp, fem, la

from dolfingrip.forms import plate as form
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.mechanics.model.placement import to_reference, to_world
from dolfingrip.mechanics.model.shape_gradient import ShapeGradient
from dolfingrip.mechanics.model.unknowns import NODE


class SkinPoints:
    """The nodes of named regions that this rank owns.

    The rule of :func:`dolfingrip.forms.plate.nodal_rule` integrates at the nodes, so that an
    integral over the reference surface is a sum over them, each with its area.

    Args:
        space: of the displacement.
        domain: reference configuration.
        regions: names of the parts of its boundary.

    Attributes:
        nodes: (n,) local numbers.
        areas: (n,) shares of the nodes in the reference area (mm²).
        rest: (n, 3) undeformed positions in the world (mm).
        frames: (n, 3, 3) from reference axes to the world's; None if they are equal.
        measure: measure of the regions, integrated at the nodes.
        first: global number of this rank's first node.
        owned: number of nodes that this rank owns.
    """

    def __init__(self, space: fem.FunctionSpace, domain: Domain, regions: Sequence[str]) -> None:
        self._space = space
        self.first = space.dofmap.index_map.local_range[0]
        self.owned = space.dofmap.index_map.size_local
        cell = domain.mesh.topology.cell_type
        facet = cpp.mesh.cell_entity_type(cell, 2, 0).name
        rule = form.nodal_rule(facet, space.ufl_element().degree)
        self.measure = domain.surface(*regions, **rule)
        test = ufl.TestFunction(space)
        shares = self._assembled(fem.form(test[0] * self.measure, jit_options=jit.options()))
        # a rank may own a node of a facet that only another rank has
        self.nodes = np.flatnonzero(shares > 0).astype(np.int32)
        self.areas = shares[self.nodes]
        self.rest = space.tabulate_dof_coordinates()[self.nodes]
        self.frames: np.ndarray | None = None
        if domain.placement is not None:
            self.frames = domain.placement.frames(self.rest)
            self.rest = domain.placement.positions(self.rest)
        self._rate: tuple[fem.Function, fem.Form] | None = None
        self._shares: tuple[fem.Function, fem.Form] | None = None

    def positions(self, dofs: np.ndarray) -> np.ndarray:
        """(n, 3) deformed positions (mm)."""
        return self.rest + self.displacement(dofs)

    def displacement(self, local: np.ndarray) -> np.ndarray:
        """(n, 3) vectors in the world, from a local array at the displacement's nodes (mm)."""
        return to_world(self.frames, local.reshape(-1, NODE)[self.nodes])

    def to_reference(self, vectors: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """Vectors (m, 3, …) of the world at some points, in reference axes."""
        return to_reference(None if self.frames is None else self.frames[rows], vectors)

    def area_rates(self, velocity: np.ndarray) -> np.ndarray:
        """(n,) change of the areas (mm²) as reference points move: A div_Γ v.

        Args:
            velocity: local array of the displacement's nodes.
        """
        if self._rate is None:
            field, test = fem.Function(self._space), ufl.TestFunction(self._space)
            normal = ufl.FacetNormal(self._space.mesh)
            stretch = ufl.div(field) - ufl.inner(normal, ufl.grad(field) * normal)
            rate = test[0] * stretch * self.measure
            self._rate = field, fem.form(rate, jit_options=jit.options())
        field, rate = self._rate
        field.x.array[:] = velocity
        return self._assembled(rate)[self.nodes]

    def moved(self, change: np.ndarray) -> SkinPoints:
        """The points after the reference nodes have moved a little by ``change`` (mm)."""
        other = copy(self)
        other.rest = self.rest + self.displacement(change)
        other.areas = self.areas + self.area_rates(change)
        return other

    def add_shape_gradient(
        self, found: ShapeGradient, rows: np.ndarray, densities: np.ndarray, forces: np.ndarray
    ) -> None:
        """Add the derivatives of Σ A b by the reference coordinates.

        Args:
            found: what is added to.
            rows: (m,) places of some points in :attr:`nodes`.
            densities: (m,) b of each, for a unit of area.
            forces: (m, 3) derivatives of Σ A b by the places of the points in the world.
        """
        if self._shares is None:
            density = fem.Function(self._space)
            form = density[0] * self.measure
            self._shares = density, found.coordinates.compiled(form)
        density, by_coordinates = self._shares
        density.x.array[:] = 0.0
        density.x.array[NODE * self.nodes[rows]] = densities
        density.x.scatter_forward()
        found.add_form(by_coordinates)
        found.at_nodes[self.nodes[rows]] += self.to_reference(forces, rows)

    def _assembled(self, integral: fem.Form) -> np.ndarray:
        """The first component of each owned node."""
        vector = fem.assemble_vector(integral)
        vector.scatter_reverse(la.InsertMode.add)
        return np.asarray(vector.array[: NODE * self.owned : NODE])
