"""Homogeneous displacement conditions on regions of the boundary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from dolfinx import fem
from petsc4py import PETSc

from dolfingrip.mechanics.model.domain import Domain


def at_rest(
    space: fem.FunctionSpace, domain: Domain, held: Mapping[int, Sequence[str]]
) -> list[fem.DirichletBC]:
    """The conditions that hold regions at rest.

    Args:
        space: of the displacement.
        domain: reference configuration.
        held: regions without displacement along each axis.
    """
    # by component: on a whole blocked space dolfinx 0.9 takes ghosts for owned dofs
    supports = []
    for axis, regions in held.items():
        if not regions:
            continue
        along = space.sub(axis)
        dofs = fem.locate_dofs_topological(along, 2, domain.facets(*regions))
        supports.append(fem.dirichletbc(PETSc.ScalarType(0.0), dofs, along))
    return supports
