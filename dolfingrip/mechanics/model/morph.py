"""The mesh morph on a distributed mesh, in place, and its velocity for shape sensitivities."""

from __future__ import annotations

import basix.ufl
import numpy as np
from dolfinx import fem
from dolfinx import io as dolfinx_io
from mpi4py import MPI

from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.meshes.measures import jacobians
from dolfingrip.meshes.morph import Morph, inverted, second_order_edges
from dolfingrip.meshes.solid import SolidMesh


def move(domain: Domain, morph: Morph) -> None:
    """Move the points of a domain's mesh; whatever was made on it before has to be made anew.

    Raises:
        MeshError: on every rank, naming ξ, where elements are turned inside out; the mesh is
            then as it was before.
    """
    geometry = domain.mesh.geometry
    cells = _gmsh_order(domain)
    moved = morph.points(geometry.x, second_order_edges(cells))
    least = jacobians(SolidMesh(moved, cells, {})).min(axis=1)
    comm = domain.mesh.comm
    number = comm.allreduce(int((least <= 0).sum()))
    if number:
        worst = comm.allreduce(float(least.min(initial=np.inf)), MPI.MIN)
        raise inverted(morph, number, comm.allreduce(len(least)), worst)
    geometry.x[:] = moved


def velocity(domain: Domain, morph: Morph) -> tuple[fem.Function, fem.Function]:
    """How the points of a morphed domain move with ξ1 and with ξ2.

    Args:
        domain: after the morph.
        morph: that led to it.

    Returns:
        dx/dξ1 and dx/dξ2 (mm), piecewise linear vectors: directions for the derivative of a form
        with respect to ``ufl.SpatialCoordinate``.
    """
    element = basix.ufl.element("Lagrange", domain.mesh.topology.cell_name(), 1, shape=(3,))
    space = fem.functionspace(domain.mesh, element)
    now = space.tabulate_dof_coordinates()
    fields = morph.velocity(morph.inverse().points(now))
    found = []
    for i, values in enumerate(fields, 1):
        field = fem.Function(space, name=f"velocity_xi{i}_mm")
        field.x.array[:] = values.ravel()
        found.append(field)
    return found[0], found[1]


def _gmsh_order(domain: Domain) -> np.ndarray:
    """Points of the local cells in the order of :class:`SolidMesh`, (m, nodes)."""
    own = np.asarray(domain.mesh.geometry.dofmap, dtype=np.int64)
    order = dolfinx_io.gmshio.cell_perm_array(domain.mesh.topology.cell_type, own.shape[1])
    return own[:, np.argsort(order)]
