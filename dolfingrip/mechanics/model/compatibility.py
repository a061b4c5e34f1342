"""What differs between DOLFINx 0.9, 0.10 and 0.11, and between their FFCx and PETSc.

Nothing else of the package asks for a version. The tests pass with 0.9 and 0.11; what stands here
of 0.10 follows its documentation and is untested.
"""

from __future__ import annotations

from collections.abc import Sequence

import ffcx
import numpy as np
from dolfinx import cpp, fem, mesh
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

PATCHED = (0, 9), (0, 11)
"""Versions of FFCx that the patches in ``jit`` were tested with."""

_version = tuple(int(part) for part in ffcx.__version__.split(".")[:2])

patches_ffcx = _version in PATCHED
"""Whether FFCx' analysis and loops are replaced by quicker ones."""

_reasons = PETSc.SNES.ConvergedReason
NOT_A_NUMBER: int = (
    _reasons.DIVERGED_FUNCTION_NANORINF  # PETSc 3.23 and later
    if hasattr(_reasons, "DIVERGED_FUNCTION_NANORINF")
    else _reasons.DIVERGED_FNORM_NAN
)
"""PETSc's reason of a solve that met a residual that is no number."""


def cells_and_local_facets(domain: mesh.Mesh, facets: np.ndarray) -> np.ndarray:
    """Pairs of boundary facets, as integrals over these take them, (cell, local facet).

    Args:
        domain: mesh of solids.
        facets: (n,) local numbers of facets.

    Returns:
        Their int32 numbers, in the shape that this version wants.
    """
    dimension = (2,) if _version < (0, 10) else ()
    pairs = fem.compute_integration_domains(
        fem.IntegralType.exterior_facet, domain.topology, facets, *dimension
    )
    return np.asarray(pairs, dtype=np.int32)


def points_of_cells(geometry: mesh.Geometry) -> np.ndarray:
    """Return the numbers of the mesh's points, by cells.

    Args:
        geometry: of the mesh.

    Returns:
        (cells, points of a cell) numbers.
    """
    return np.asarray(geometry.dofmap if _version < (0, 11) else geometry.dofmaps[0])


def global_columns(pattern: cpp.la.SparsityPattern, local: np.ndarray) -> np.ndarray:
    """Global block columns of local ones, ghosts included, of a finished sparsity pattern."""
    older = hasattr(pattern, "column_index_map")
    columns = pattern.column_index_map() if older else pattern.index_map(1)
    return np.asarray(columns.local_to_global(local))


def assemble_blocks(matrix: PETSc.Mat, forms: Sequence[Sequence[fem.Form]]) -> None:
    """Add rows of forms, one a pair of fields, to a matrix that has local numbers of all dofs."""
    name = "assemble_matrix_block" if _version < (0, 10) else "assemble_matrix"
    getattr(fem_petsc, name)(matrix, [list(row) for row in forms])
