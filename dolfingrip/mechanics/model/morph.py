"""Velocity of the mesh morph on a distributed mesh, for shape sensitivities."""

from __future__ import annotations

import basix.ufl
from dolfinx import fem

from dolfingrip.mechanics.model.domain import Domain
from dolfingrip.meshes.morph import Morph


def velocity(domain: Domain, morph: Morph) -> tuple[fem.Function, fem.Function]:
    """Velocities of a morphed domain's points with ξ1 and ξ2.

    Args:
        domain: domain after the morph.
        morph: the morph that was applied to it.

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
