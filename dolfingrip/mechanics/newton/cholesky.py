"""Cholesky factors of definite tangents on one rank; other tangents are left to LDLᵀ.

CHOLMOD factorises a finger's tangent in half of MUMPS' time. It has no pivots, so it cannot
factorise a tangent that is not definite, as beyond a limit point.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache, cached_property
from typing import Any, Final

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.callbacks import preconditioner
from dolfingrip.mechanics.newton.cholmod import CholmodFactors, elimination
from dolfingrip.mechanics.newton.inverse import Factorisation

MOST_SKIPPED: Final = 31
"""Largest number of matrices that are left to LDLᵀ before the next try: none after one that was not
definite, then 1, 3, 7 and so on after each further one in a row."""

ITERATIONS: Final = 30
"""Largest number of conjugate gradients' iterations with factors in single precision."""

ROUNDING: Final = 1e-12
"""Error that is taken for rounding, relative to the solution; see
:func:`~.cholesky.conjugate_gradients`."""

BLOCK = 3
"""Rows of a block of the tangent."""


class Cholesky:
    """The inverse of a symmetric matrix by Cholesky factors, or by LDLᵀ if it is not definite.

    Factors in single precision are applied once as a preconditioner; solutions take two or three of
    conjugate gradients' iterations. Where rounding makes a definite matrix
    indefinite, as fine meshes of slender bodies do, they are in double precision from there on.

    Args:
        comm: one rank.
        indefinite: returns what factorises matrices that are not definite.
        dtype: precision of the first factors, float32 or float64.
    """

    exact = True

    def __init__(
        self,
        comm: MPI.Comm,
        indefinite: Callable[[], Factorisation],
        dtype: type[np.floating[Any]] = np.float32,
    ) -> None:
        self._create_indefinite = indefinite
        self._scalars: _Scalars | None = None
        self._definite = False
        self._dtype = dtype
        self._refused = self._skips = 0
        self.pc = preconditioner(comm, self.apply)

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Factorise ``matrix`` (type SBAIJ, blocks of 3)."""
        self._matrix = matrix
        self._definite = self._skips == 0 and self._factorised(matrix)
        if self._definite:
            self._refused = 0
        else:
            self._leave()
            self._indefinite.set_up(matrix)
        self.pc.setOperators(matrix)

    def _leave(self) -> None:
        """Leave matrices to LDLᵀ after some in a row that were not definite, as in a grasp."""
        if self._skips > 0:
            self._skips -= 1
            return
        self._skips = min(2**self._refused - 1, MOST_SKIPPED)
        self._refused += 1

    @cached_property
    def _indefinite(self) -> Factorisation:
        return self._create_indefinite()

    def _factorised(self, matrix: PETSc.Mat) -> bool:
        """Factorise by CHOLMOD; return whether the matrix is definite."""
        if self._scalars is None or self._scalars.blocks != matrix:
            self._scalars = _Scalars(matrix, self._dtype)
        return self._scalars.factorise() or self._factorised_in_double(self._scalars)

    def _factorised_in_double(self, scalars: _Scalars) -> bool:
        """Factorise in double precision, and keep it if the matrix is definite; return if it is."""
        if self._dtype == np.float64:
            return False
        scalars.analyse(np.float64)
        if scalars.factorise():
            self._dtype = np.float64
            return True
        scalars.analyse(self._dtype)
        return False

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Precondition, for PETSc's preconditioner of type ``python``."""
        solution.array[:] = self.approximate(right.array_r[:, None])[:, 0]

    def approximate(self, right: np.ndarray) -> np.ndarray:
        """Solutions, to single precision at least, for (n, k) right-hand sides, (n, k).

        The next ones may overwrite them.
        """
        if not self._definite:
            return self._indefinite.solve_many(right)
        assert self._scalars is not None
        return self._scalars.factors.solve(right)

    @property
    def negative(self) -> int:
        """Negative pivots."""
        return 0 if self._definite else self._indefinite.negative

    @property
    def failed(self) -> int:
        """PETSc's reason why the matrix could not be factorised; 0 if it was."""
        return 0 if self._definite else self._indefinite.failed

    def solve(self, right: PETSc.Vec, solution: PETSc.Vec, rtol: float) -> None:
        """Solve for one right-hand side to an error of ``rtol`` times the solution."""
        solution.array[:] = self.solve_many(right.array_r[:, None], rtol)[:, 0]

    def solve_many(self, right: np.ndarray, rtol: float | None = None) -> np.ndarray:
        """Solutions for (n, k) right-hand sides, (n, k).

        Args:
            right: the right-hand sides.
            rtol: largest error in the norm of the energy, relative to the solution; default:
                rounding.
        """
        if self._definite and self._dtype == np.float32:
            limits = rtol or ROUNDING, ITERATIONS
            solutions = conjugate_gradients(self._matrix, self.approximate, right, *limits)
            if solutions is not None:
                return solutions
            assert self._scalars is not None
            self._definite = self._factorised_in_double(self._scalars)
            if not self._definite:
                self._indefinite.set_up(self._matrix)
        return self.approximate(right)


class _Scalars:
    """A copy in scalars of a matrix in blocks of 3, since CHOLMOD knows no blocks.

    The upper triangle by rows is CHOLMOD's lower triangle by columns. Blocks are ordered, not
    scalars, which is as good and takes a ninth of the time.

    Args:
        blocks: the matrix (type SBAIJ), whose pattern stays.
        dtype: float32 or float64.

    Attributes:
        blocks: the argument.
        factors: of the copy.
    """

    def __init__(self, blocks: PETSc.Mat, dtype: type[np.floating[Any]]) -> None:
        self.blocks = blocks
        starts, nodes = blocks.getRowIJ(symmetric=False, compressed=True)
        starts, nodes = starts.astype(np.int32), nodes.astype(np.int32)
        counts = np.diff(starts)
        # the lower triangle of a row's first block, which is on the diagonal, is left out
        lengths = BLOCK * counts[:, None] - np.arange(BLOCK, dtype=np.int32)
        ends = np.concatenate([[0], np.cumsum(lengths.ravel())]).astype(np.int32)
        self._from = np.empty(ends[-1], dtype=np.int32)
        columns = np.empty(ends[-1], dtype=np.int32)
        numbers = np.arange(len(nodes), dtype=np.int32)
        within = numbers - np.repeat(starts[:-1], counts)
        across = np.arange(BLOCK, dtype=np.int32)
        # the last row first: places of what is left out are those of the rows before, set later
        for r in reversed(range(BLOCK)):
            first = np.repeat(ends[r:-1:BLOCK], counts) - r + BLOCK * within
            place = first[:, None] + across
            columns[place] = BLOCK * nodes[:, None] + across
            # blocks are stored by columns
            self._from[place] = BLOCK * BLOCK * numbers[:, None] + BLOCK * across + r
        order = BLOCK * elimination(starts, nodes).order[:, None] + across
        self._pattern = ends, columns, order.ravel()
        self.factors = CholmodFactors(*self._pattern, dtype)

    def analyse(self, dtype: type[np.floating[Any]]) -> None:
        """Have factors of another type, whatever there is."""
        self.factors.free()
        self.factors = CholmodFactors(*self._pattern, dtype)

    def factorise(self) -> bool:
        """Factorise the present values; return whether they are definite."""
        values = stored_values(self.blocks).astype(self.factors.values.dtype, copy=False)
        np.take(values, self._from, out=self.factors.values, mode="clip")
        return self.factors.factorise()


@cache
def _petsc() -> ctypes.CDLL:
    """Functions of PETSc that petsc4py, whose module is linked with them, has no names for."""
    return ctypes.CDLL(PETSc.__file__)


def stored_values(matrix: PETSc.Mat) -> np.ndarray:
    """The values of a matrix of type SBAIJ on one rank as PETSc stores them, not a copy."""
    place = ctypes.POINTER(ctypes.c_double)()
    code = _petsc().MatSeqSBAIJGetArray(ctypes.c_void_p(matrix.handle), ctypes.byref(place))
    if code:
        raise PETSc.Error(code)
    return np.ctypeslib.as_array(place, (int(matrix.getInfo()["nz_used"]),))


def conjugate_gradients(
    matrix: PETSc.Mat,
    inverse: Callable[[np.ndarray], np.ndarray],
    right: np.ndarray,
    rtol: float,
    iterations: int,
) -> np.ndarray | None:
    """Solutions with a definite matrix, by preconditioned conjugate gradients.

    The preconditioner may be rounded: a step is conjugate to the one before for any (Golub & Ye,
    SIAM J. Sci. Comput. 21, 1999).

    Args:
        matrix: the matrix, on one rank.
        inverse: returns nearly the solutions for (n, k) right-hand sides.
        right: (n, k) right-hand sides.
        rtol: largest error in the norm of the energy, relative to the solution.
        iterations: largest number of iterations.

    Returns:
        (n, k) solutions; None if they are not found, as with a matrix that is not definite.
    """
    solutions, residual = np.zeros_like(right), right.copy()
    step = np.array(inverse(residual), dtype=float)
    energy = first = _products(residual, step)
    for _ in range(iterations):
        rising = _times(matrix, step)
        curvature = _products(step, rising)
        if (curvature < 0).any():
            return None
        length = np.divide(energy, curvature, out=np.zeros_like(energy), where=curvature > 0)
        solutions += length * step
        residual -= length * rising
        next_step = inverse(residual)
        before, energy = energy, _products(residual, next_step)
        if (energy <= rtol**2 * first).all():
            return solutions
        turned = -length * _products(rising, next_step)
        step *= np.divide(turned, before, out=np.zeros_like(turned), where=before > 0)
        step += next_step
    return None


def _products(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.asarray(np.einsum("nk,nk->k", a, b))


def _times(matrix: PETSc.Mat, columns: np.ndarray) -> np.ndarray:
    """The matrix times (n, k) columns."""
    x, y = matrix.createVecs()
    products = np.empty_like(columns)
    for column in range(columns.shape[1]):
        x.array[:] = columns[:, column]
        matrix.mult(x, y)
        products[:, column] = y.array_r
    return products
