"""Displacement elements and sheets, and how they are integrated.

A sheet is a surface with an energy of its own: a membrane lies on faces of cells, inside the solid
or on its boundary. It is integrated as part of the cell on one side, with a rule whose points lie
on that cell's face. So its stress can be carried at these points as the solid's is, and no rank
needs a cell of another.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import basix
import basix.ufl
import dolfinx
import numpy as np
import ufl
from dolfinx import fem, mesh
from ufl.core.expr import Expr

from dolfingrip.mechanics.model.points import Rule

CELL: Final = {
    "P1": "tetrahedron",
    "P2": "tetrahedron",
    "P2-P1": "tetrahedron",
    "S2": "hexahedron",
}
"""Shape of the cells of each element, with basix' name."""

RULE: Final = {
    ("tetrahedron", 1): 1,
    # four points are rank-sufficient for a quadratic tetrahedron (24 strains for 24 modes of
    # deformation) and what C3D10 elements use
    ("tetrahedron", 2): 2,
    ("hexahedron", 1): 3,
    # eight points (2 × 2 × 2), as C3D20R: softer than the full rule where one cell spans a wall,
    # and its six modes without energy cannot spread beyond one cell (Bićanić & Hinton, Int. J.
    # Numer. Methods Eng. 14, 1979)
    ("hexahedron", 2): 3,
}
"""Degree of the volume's quadrature by cell and order of the displacement."""


FULL: Final = {("hexahedron", 2): 5}
"""Degree of the full rule of elements whose rule is reduced: 27 points (3 × 3 × 3), as C3D20."""

SHEET_RULE: Final = {
    ("tetrahedron", 1): 1,
    ("tetrahedron", 2): 2,  # three points
    ("hexahedron", 1): 3,
    ("hexahedron", 2): 3,  # four points, as many as the volume's rule has in a layer
}
"""Degree of the quadrature of surfaces with an energy of their own."""


def displacement_element(name: str, shape: tuple[int, ...] = (3,)) -> Any:
    """A displacement element for UFL.

    Args:
        name: P1 or P2, Lagrange on tetrahedra (P2-P1: with a pressure of its own); S2, the
            serendipity element of 20 nodes, on hexahedra.
        shape: shape of its values.
    """
    if name == "S2":
        return _serendipity(shape)
    return basix.ufl.element("Lagrange", CELL[name], int(name[1]), shape=shape)


def pressure_field(element: str, mesh: dolfinx.mesh.Mesh) -> fem.Function | None:
    """Pressure field of a mixed element.

    Args:
        element: name of the displacement element.
        mesh: mesh of the field.

    Returns:
        The field (MPa); None for an element that is not mixed.
    """
    if element != "P2-P1":
        return None
    return fem.Function(fem.functionspace(mesh, ("Lagrange", 1)), name="pressure_MPa")


def integration_degree(space: fem.FunctionSpace, *, full: bool = False) -> int:
    """Degree of the quadrature with which energies in a displacement space are integrated.

    Args:
        space: of the displacement.
        full: whether the full rule is used. A reduced rule is unstable under a pressure from about
            a third of the shear modulus on: modes without energy grow where the pressure acts.
    """
    kind = str(space.mesh.ufl_cell()), space.ufl_element().degree
    return FULL.get(kind, RULE[kind]) if full else RULE[kind]


def sheet_degree(space: fem.FunctionSpace) -> int:
    """Degree of the quadrature with which membranes in a displacement space are integrated."""
    element = space.ufl_element()
    return SHEET_RULE[str(space.mesh.ufl_cell()), element.degree]


def _serendipity(shape: tuple[int, ...]) -> Any:
    """Serendipity element of second order with its nodes at the corners and amid the edges.

    Dofs of basix' own element are moments on the edges; contact, supports and output need values at
    points. Its polynomials are those of superlinear degree up to 2 (Arnold & Awanou, Found.
    Comput. Math. 11, 2011).
    """
    cell = basix.CellType.hexahedron
    points, weights = basix.make_quadrature(cell, 8)
    basis = basix.tabulate_polynomials(basix.PolynomialType.legendre, cell, 2, points)
    exponents = [e for e in np.ndindex(3, 3, 3) if sum(degree for degree in e if degree > 1) <= 2]
    monomials = np.array([np.prod(points ** np.array(e), axis=1) for e in exponents])
    span = np.ascontiguousarray((monomials * weights) @ basis.T)
    corners, entities = basix.geometry(cell), basix.topology(cell)
    at = [[corners[entity].mean(axis=0, keepdims=True) for entity in entities[d]] for d in (0, 1)]
    value = np.ones((1, 1, 1, 1))
    element = basix.ufl.custom_element(
        cell,
        (),
        span,
        [*at, [np.zeros((0, 3))] * 6, [np.zeros((0, 3))]],
        [[value] * 8, [value] * 12, [np.zeros((0, 1, 0, 1))] * 6, [np.zeros((0, 1, 0, 1))]],
        0,
        basix.MapType.identity,
        basix.SobolevSpace.H1,
        False,
        1,  # the largest complete polynomials in it, on hexahedra: trilinear
        2,  # and the smallest around it: triquadratic
        basix.PolysetType.standard,
    )
    return basix.ufl.blocked_element(element, shape=shape) if shape else element


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
    return ufl.JacobianInverse(domain).T * ufl.as_vector([float(part) for part in outward])


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
