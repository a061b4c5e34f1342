"""The elimination order that costs a factorisation least."""

from __future__ import annotations

from typing import Final

from petsc4py import PETSc

CANDIDATES: Final = (2, 4, 6)
"""MUMPS' ICNTL(7): approximate minimum fill, PORD, minimum degree with quasi-dense rows. On one
structured mesh the first takes half the operations of the last, on the next three times as many."""

AUTOMATIC: Final = 7
"""MUMPS chooses."""

SMALL: Final = 1000
"""Unknowns below which no order is worth looking for; PORD ends the process on tiny graphs."""


def cheapest(matrix: PETSc.Mat) -> int:
    """The ICNTL(7) among :data:`CANDIDATES` with the fewest operations; the same on all ranks.

    Args:
        matrix: assembled and symmetric. It is factorised once for each candidate.
    """
    if matrix.getSize()[0] < SMALL:
        return AUTOMATIC
    return min(CANDIDATES, key=lambda ordering: _operations(matrix, ordering))


def _operations(matrix: PETSc.Mat, ordering: int) -> float:
    """MUMPS' estimate of floating-point operations."""
    pc = PETSc.PC().create(matrix.comm)
    pc.setOperators(matrix)
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    pc.setFactorSetUpSolverType()
    factor = pc.getFactorMatrix()
    factor.setMumpsIcntl(7, ordering)
    pc.setUp()
    found = float(factor.getMumpsRinfog(1))
    pc.destroy()
    return found
