"""Sheets: surfaces with an energy of their own that is integrated over adjacent cells.

A membrane lies on faces of cells, inside the solid or on its boundary. It is integrated as part of
the cell on one side, with a rule whose points lie on that cell's face. So its stress can be carried
at these points as the solid's is, and no rank needs a cell of another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import basix
import numpy as np
import ufl
from dolfinx import mesh
from ufl.core.expr import Expr

from dolfingrip.mechanics.model.points import Rule


@dataclass(frozen=True)
class Sheet:
    """A surface with an energy.

    Attributes:
        name: name of the domain's sheet.
        energy: returns the energy per reference area (mJ/mm²) for the surface's Green–Lagrange
            strain (3, 3) and its unit normal (3,).
    """

    name: str
    energy: Callable[[Expr, Expr], Expr]


def facet_rule(domain: mesh.Mesh, facet: int, degree: int) -> Rule:
    """A rule of ``degree`` on a local facet, with points in the cell's coordinates."""
    cell = domain.basix_cell()
    kind = basix.cell.subentity_types(cell)[2][facet]
    points, weights = basix.make_quadrature(kind, degree)
    corners = basix.geometry(cell)[basix.topology(cell)[2][facet]]
    sides = corners[1:3] - corners[0]
    area = np.linalg.norm(np.cross(*sides))
    return Rule(corners[0] + points @ sides, weights * area)


def covector(domain: mesh.Mesh, facet: int) -> Expr:
    """J⁻ᵀ n̂ of a local facet, whose direction is the normal and whose size is area by volume."""
    outward = basix.cell.facet_outward_normals(domain.basix_cell())[facet]
    return ufl.JacobianInverse(domain).T * ufl.as_vector([float(each) for each in outward])


def local_facets(domain: mesh.Mesh, faces: np.ndarray, order: np.ndarray) -> np.ndarray:
    """Local facets of the cells by their corners.

    Args:
        domain: the mesh.
        faces: (f, corners) local corners of each face, in the numbering of the input.
        order: place in the input's numbering of each of the cell's corners.

    Returns:
        (f,) local facets.
    """
    topology = [set(corners) for corners in basix.topology(domain.basix_cell())[2]]
    place = np.argsort(order)
    return np.array([topology.index(set(place[corners].tolist())) for corners in faces])
