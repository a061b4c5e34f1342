"""Which way an adopted part bends at first: one linear step of pressure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI

from dolfingrip.experiments.rigs.undeformed import of_order
from dolfingrip.mechanics.model.assembly import to_assemble
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.mechanics.newton.inverse import Factorisation
from dolfingrip.meshes.adoption import adopt as adoption
from dolfingrip.meshes.adoption.adopt import AdoptedPart
from dolfingrip.meshes.adoption.roles import Asked, direction_said, snapped
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.solid import Floats

POISSON: Final = 0.3
"""Ratio of the step's material: linear elements of a rubber would not bend."""


BENDS: Final = 0.05
"""Way of the tip across the part, by the largest displacement, from which it bends."""

TOWARDS_DEG: Final = 45.0
"""Angle between this way and the back, up to which the back fits."""


def adopt(path: Path, hints: Asked, wanted: MeshRequest, scale: float = 1.0) -> AdoptedPart:
    """Adopt a part, and let one step of pressure say which way it bends.

    Where that is not towards the back, the back is put there, unless the back was asked for.

    Args:
        path: CAD file, triangles or mesh.
        hints: corrections of what is taken for what.
        wanted: size and order of elements.
        scale: mm for each unit of length of the file.

    Returns:
        The part.

    Raises:
        MeshError: one line that says what is wrong with the part, and where.
    """
    part = adoption.adopt(path, hints, wanted, scale)
    if not part.roles.cavities:
        return part
    share, way = _bends(part)
    if share < BENDS:
        part.roles.said["bends"] = (
            f"not by itself: one step of pressure moves the tip across by {share:.2g} of the "
            "largest displacement; a film, a material or another [cavity] pressure bends it"
        )
        return part
    # the back faces −x, and a part bends towards its back
    fits = -way[0] >= np.cos(np.radians(TOWARDS_DEG))
    moves = f"one step of pressure moves the tip across by {share:.2g} of the largest displacement"
    towards = part.roles.rotation.T @ way
    if fits:
        part.roles.said["bends"] = f"towards the back: {moves}"
        return replace(part, bends_to_back=True)
    back = snapped(towards)
    if hints.back is not None:
        part.roles.said["bends"] = (
            f"towards {direction_said(back)}, away from the back that was asked for: {moves}; its "
            "angle is negative without a film on the back"
        )
        return part
    guessed = part.roles.said["back"]
    part = adoption.adopt(path, replace(hints, back=(back[0], back[1], back[2])), wanted, scale)
    part.roles.said["back"] = (
        f"faces {direction_said(back)}, corrected by the first step of pressure; the walls "
        f"had told otherwise: {guessed}"
    )
    part.roles.said["bends"] = f"towards the corrected back: {moves}"
    return replace(part, bends_to_back=True)


def _bends(part: AdoptedPart) -> tuple[float, Floats]:
    """The tip's way across by the largest displacement, and (3,) its direction in the frame."""
    tip, largest = _displaced(distribute(MPI.COMM_SELF, of_order(part.mesh, 1)))
    across = np.array([tip[0], 0.0 if part.roles.half else tip[1], 0.0])
    size = float(np.linalg.norm(across))
    return size / largest, across / max(size, 1e-300)


def _displaced(domain: Domain) -> tuple[Floats, float]:
    """Mean displacement of the tip, and the largest one, of any unit.

    They are those of a linear elastic solid of one modulus with pressure in its cavities.
    """
    space = fem.functionspace(domain.mesh, ("Lagrange", 1, (3,)))
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    strain = ufl.sym(ufl.grad(u))
    stress = 2 * strain + 2 * POISSON / (1 - 2 * POISSON) * ufl.tr(strain) * ufl.Identity(3)
    inside = domain.surface(*domain.cavities, quadrature_degree=1)
    load = -ufl.inner(ufl.FacetNormal(domain.mesh), v) * inside
    held = {0: ["clamp"], 1: ["clamp", *(["symmetry"] if domain.half else [])], 2: ["clamp"]}
    supports = at_rest(space, domain, held)
    stiffness = ufl.inner(stress, ufl.grad(v)) * domain.volume(quadrature_degree=2)
    matrix = fem_petsc.assemble_matrix(to_assemble(stiffness), bcs=supports)
    matrix.assemble()
    right = fem_petsc.assemble_vector(to_assemble(load))
    fem_petsc.set_bc(right, supports)
    inverse, solution = Factorisation("first_step_", domain.mesh.comm), right.duplicate()
    inverse.set_up(matrix)
    inverse.pc.apply(right, solution)
    moved = solution.array.reshape(-1, 3)
    tip = fem.locate_dofs_topological(space, 2, domain.facets("tip"))
    return moved[tip].mean(axis=0), float(np.linalg.norm(moved, axis=1).max())
