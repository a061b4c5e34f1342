"""Factors of a tangent part by part: fingers that only a rigid body couples."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc
from scipy.sparse.csgraph import connected_components

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton import cholmod
from dolfingrip.mechanics.newton.callbacks import preconditioner
from dolfingrip.mechanics.newton.cholesky import BLOCK, Cholesky, stored_values
from dolfingrip.mechanics.newton.inverse import Exact, Factorisation


def factors(
    prefix: str,
    model: Model,
    order: Callable[[], int],
    dtype: type[np.floating[Any]] = np.float32,
) -> Exact:
    """Make the inverse of a model's tangents, or of their part on a coarser level.

    Solutions are no minima of Π where it is concave in a pressure, or in a multiplier. Their
    tangents are never definite. Global unknowns are the border of the others.

    Args:
        prefix: prefix of PETSc's options.
        model: the model.
        order: returns the elimination order for LDLᵀ; called where Cholesky's factors do not serve.
        dtype: precision of Cholesky factors, as long as that of float32 is enough.
    """

    def any_sign() -> Factorisation:
        return Factorisation(prefix, model.comm, order())

    if not has_cholesky(model):
        return any_sign()

    def definite() -> Cholesky:
        return Cholesky(model.comm, any_sign, dtype)

    border = model.unknowns.padded // BLOCK
    return Bordered(model.comm, border, definite) if border else definite()


def has_cholesky(model: Model) -> bool:
    """Find out whether tangents of a model are tried by CHOLMOD before MUMPS.

    Args:
        model: the model.

    Returns:
        False on several ranks, of a saddle point, or without CHOLMOD.
    """
    unknowns = model.unknowns
    saddle = len(unknowns.fields) > 1 or any(g.multiplier for g in unknowns.global_unknowns)
    return model.comm.size == 1 and not saddle and cholmod.available()


BORDER_RTOL: Final = 1e-6
"""Error of the columns that couple the border, relative to them, for steps."""


class Bordered:
    """The inverse of a symmetric matrix whose last rows couple parts that nothing else couples.

    With D of the parts, B of the border's columns and G of the border alone, the border's unknowns
    y follow from the Schur complement S = G − BᵀD⁻¹B, and those of the parts from D x = r − B y.
    A part is definite even where the border is not: a rigid body that nothing holds yet, or whose
    contact lets it tip. Parts that touch one another are one part.

    Args:
        comm: one rank.
        border: rows of blocks at the matrix' end that are no part's.
        create: returns what factorises a part.
    """

    exact = True

    def __init__(self, comm: MPI.Comm, border: int, create: Callable[[], Cholesky]) -> None:
        self._border, self._create = border, create
        self._matrix: PETSc.Mat | None = None
        self._parts: list[_Part] = []
        self.pc = preconditioner(comm, self.apply)

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Factorise ``matrix`` (type SBAIJ, blocks of 3)."""
        if matrix != self._matrix:
            self._split(matrix)
            self._matrix = matrix
        blocks = stored_values(matrix).reshape(-1, BLOCK, BLOCK)
        for part in self._parts:
            part.set_up(blocks)
        self._coupling = self._coupled(blocks)
        self._eliminate(BORDER_RTOL)
        self.pc.setOperators(matrix)

    def _eliminate(self, rtol: float | None = None) -> None:
        """Find D⁻¹B, to rounding unless a tolerance is given, and the Schur complement."""
        across, within = self._coupling
        self._moved = self._inner(across, rtol)
        schur = within - across.T @ self._moved
        self._eigenvalues, self._modes = np.linalg.eigh((schur + schur.T) / 2)

    def _split(self, matrix: PETSc.Mat) -> None:
        """Find the parts of a new pattern; those that are as before keep what they have."""
        starts, nodes = matrix.getRowIJ(symmetric=False, compressed=True)
        self._inside = inside = len(starts) - 1 - self._border
        rows = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
        within = np.flatnonzero(nodes < inside)
        graph = sp.csr_matrix(
            (np.ones(len(within)), (rows[within], nodes[within])), (inside, inside)
        )
        count, label = connected_components(graph, directed=False)
        before = self._parts
        self._parts = []
        for number in range(count):
            members = np.flatnonzero(label == number)
            which = within[label[rows[within]] == number]
            place = np.empty(inside, dtype=PETSc.IntType)
            place[members] = np.arange(len(members))
            pattern = np.array([place[rows[which]], place[nodes[which]]])
            alike = [part for part in before if part.is_like(members, pattern)]
            part = alike[0] if alike else _Part(self._create(), members, pattern)
            part.which = which
            self._parts.append(part)
        self._outside = np.flatnonzero(nodes >= inside)
        self._places = rows[self._outside], nodes[self._outside] - inside

    def _coupled(self, blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The border's columns (n, m) and the border alone (m, m)."""
        size = self._inside + self._border
        by_block = np.zeros((size, BLOCK, self._border, BLOCK))
        row, column = self._places
        # blocks are stored by columns
        by_block[row, :, column] = blocks[self._outside].transpose(0, 2, 1)
        columns = by_block.reshape(BLOCK * size, -1)
        upper = np.triu(columns[BLOCK * self._inside :])
        return columns[: BLOCK * self._inside], upper + np.triu(upper, 1).T

    def _inner(self, right: np.ndarray, rtol: float | None = None) -> np.ndarray:
        """D⁻¹ of the parts' rows of (n, k) right-hand sides."""
        solutions = np.empty((BLOCK * self._inside, right.shape[1]))
        for part in self._parts:
            solutions[part.rows] = part.inverse.solve_many(right[part.rows], rtol)
        return solutions

    def _joined(self, right: np.ndarray, inner: np.ndarray) -> np.ndarray:
        """All unknowns, by (n, k) right-hand sides and D⁻¹r of the parts.

        BᵀD⁻¹r is (D⁻¹B)ᵀr, which is more exact than a preconditioner's D⁻¹r.
        """
        end = len(inner)
        residual = self._modes.T @ (right[end:] - self._moved.T @ right[:end])
        outer = self._modes @ (residual.T / self._eigenvalues).T
        return np.concatenate([inner - self._moved @ outer, outer])

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Precondition, for PETSc's preconditioner of type ``python``."""
        values = right.array_r[:, None]
        inner = np.empty((BLOCK * self._inside, 1))
        for part in self._parts:
            inner[part.rows] = part.inverse.approximate(values[part.rows])
        solution.array[:] = self._joined(values, inner)[:, 0]

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec, rtol: float) -> None:
        """Solve for one right-hand side to an error of ``rtol`` times the solution."""
        solutions = self._joined(right.array_r[:, None], self._inner(right.array_r[:, None], rtol))
        solution.array[:] = solutions[:, 0]

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, (n, k)."""
        self._eliminate()
        return self._joined(right, self._inner(right))

    @property
    def negative(self) -> int:
        """Negative eigenvalues, as those of D and S together (Haynsworth)."""
        parts = sum(part.inverse.negative for part in self._parts)
        return parts + int((self._eigenvalues < 0).sum())

    @property
    def failed(self) -> int:
        """PETSc's reason why a part could not be factorised; 0 if all were."""
        return max((part.inverse.failed for part in self._parts), default=0)


class _Part:
    """A part of the matrix, with its factors.

    Args:
        inverse: what factorises it.
        members: rows of blocks in the whole matrix, rising.
        pattern: (2, n) rows and columns of its blocks within the part.

    Attributes:
        inverse: the argument.
        rows: its unknowns.
        which: places of its blocks among those of the whole matrix.
    """

    def __init__(self, inverse: Cholesky, members: np.ndarray, pattern: np.ndarray) -> None:
        self.inverse = inverse
        self.which = np.empty(0, dtype=np.int64)
        self._members, self._pattern = members, pattern
        self.rows = (BLOCK * members[:, None] + np.arange(BLOCK)).ravel()
        starts = np.concatenate([[0], np.cumsum(np.bincount(pattern[0], minlength=len(members)))])
        size = BLOCK * len(members)
        csr = (
            starts.astype(PETSc.IntType),
            pattern[1].astype(PETSc.IntType),
            np.zeros((pattern.shape[1], BLOCK, BLOCK)),
        )
        self._matrix = PETSc.Mat().createSBAIJ((size, size), BLOCK, csr=csr, comm=MPI.COMM_SELF)
        self._matrix.assemble()

    def is_like(self, members: np.ndarray, pattern: np.ndarray) -> bool:
        """Return whether this part has these rows and blocks."""
        same = np.array_equal(self._members, members)
        return same and np.array_equal(self._pattern, pattern)

    def set_up(self, blocks: np.ndarray) -> None:
        """Factorise the part of a matrix with these ``blocks``."""
        values = stored_values(self._matrix).reshape(-1, BLOCK, BLOCK)
        np.take(blocks, self.which, axis=0, out=values, mode="clip")
        self._matrix.assemble()
        self._matrix.stateIncrease()
        self.inverse.set_up(self._matrix)
