"""Cholesky factors of definite tangents on one rank, by CHOLMOD; other tangents are left to LDLᵀ.

CHOLMOD (Chen, Davis, Hager & Rajamanickam, ACM Trans. Math. Softw. 35, 2008) factorises a finger's
tangent in two thirds of MUMPS' time. It has no pivots, so it cannot factorise a tangent that is not
definite, as beyond a limit point.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache, cached_property

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.inverse import Factorisation, solve_many
from dolfingrip.mechanics.newton.policy import CHOLESKY

BLOCK = 3
"""Rows of a block of the tangent."""

NOT_DEFINITE = 81
"""PETSc's error PETSC_ERR_MAT_CH_ZRPVT."""


class Cholesky:
    """The inverse of a symmetric matrix by Cholesky factors, or by LDLᵀ if it is not definite.

    Args:
        prefix: prefix of PETSc's options.
        comm: one rank.
        indefinite: returns what factorises matrices that are not definite.
    """

    exact = True

    def __init__(
        self, prefix: str, comm: MPI.Comm, indefinite: Callable[[], Factorisation]
    ) -> None:
        self._prefix, self._comm = prefix, comm
        self._create_indefinite = indefinite
        self._factors: PETSc.PC | None = None
        self._scalars: _Scalars | None = None
        self._used: PETSc.PC | None = None
        self._refused = self._left = 0
        self.pc = PETSc.PC().create(comm)
        self.pc.setType(PETSc.PC.Type.PYTHON)
        self.pc.setPythonContext(self)

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Factorise ``matrix`` (type SBAIJ, blocks of 3)."""
        definite = self._factorised(matrix) if self._left == 0 else None
        if definite is not None:
            self._refused = 0
        else:
            self._leave()
            self._indefinite.set_up(matrix)
        self._used = definite or self._indefinite.pc
        self.pc.setOperators(matrix)

    def _leave(self) -> None:
        """Leave matrices to LDLᵀ after some in a row that were not definite, as in a grasp."""
        if self._left > 0:
            self._left -= 1
            return
        self._left = min(2**self._refused - 1, CHOLESKY.most_left)
        self._refused += 1

    @cached_property
    def _indefinite(self) -> Factorisation:
        return self._create_indefinite()

    def _factorised(self, matrix: PETSc.Mat) -> PETSc.PC | None:
        """The factors by CHOLMOD; None if ``matrix`` is not definite."""
        if self._scalars is None or self._scalars.blocks != matrix:
            self._scalars = _Scalars(matrix)
            self._factors = None
        self._scalars.update()
        if self._factors is None:
            self._factors = self._created()
        self._factors.setOperators(self._scalars.matrix)
        try:
            self._factors.setUp()
        except PETSc.Error as error:
            if error.ierr != NOT_DEFINITE:
                raise
            self._factors = None  # PETSc takes no further matrix for them
        return self._factors

    def _created(self) -> PETSc.PC:
        pc = PETSc.PC().create(self._comm)
        pc.setOptionsPrefix(self._prefix)
        pc.setType(PETSc.PC.Type.CHOLESKY)
        pc.setFactorSolverType(PETSc.Mat.SolverType.CHOLMOD)
        options = PETSc.Options(self._prefix)
        options["mat_cholmod_print"] = 0
        # supernodal always: CHOLMOD's other method is LDLᵀ without pivots, which takes any matrix
        options["mat_cholmod_supernodal_switch"] = 0
        return pc

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        """Solve, for PETSc's preconditioner of type ``python``."""
        assert self._used is not None
        self._used.apply(right, solution)

    @property
    def negative(self) -> int:
        """Negative pivots."""
        return 0 if self._used == self._factors else self._indefinite.negative

    @property
    def failed(self) -> int:
        """PETSc's reason why the matrix could not be factorised; 0 if it was."""
        return 0 if self._used is None else int(self._used.getFailedReason())

    def solve_many(self, right: np.ndarray) -> np.ndarray:
        """(n, k) solutions for (n, k) right-hand sides."""
        return solve_many(self._used, right)


class _Scalars:
    """A copy in scalars of a matrix in blocks of 3, since CHOLMOD knows no blocks.

    Args:
        blocks: the matrix (type SBAIJ), whose pattern stays.

    Attributes:
        blocks: the argument.
        matrix: the copy (type SBAIJ, blocks of 1).
    """

    def __init__(self, blocks: PETSc.Mat) -> None:
        self.blocks = blocks
        starts, nodes = blocks.getRowIJ(symmetric=False, compressed=True)
        counts = np.diff(starts)
        # the lower triangle of a row's first block, which is on the diagonal, is left out
        lengths = BLOCK * counts[:, None] - np.arange(BLOCK, dtype=np.int32)
        ends = np.concatenate([[0], np.cumsum(lengths.ravel())]).astype(PETSc.IntType)
        self._from = np.empty(ends[-1], dtype=np.int32)
        columns = np.empty(ends[-1], dtype=PETSc.IntType)
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
        count = BLOCK * len(counts)
        csr = (ends, columns, np.zeros(ends[-1]))
        self.matrix = PETSc.Mat().createSBAIJ((count, count), 1, csr=csr, comm=blocks.comm)
        self.matrix.assemble()

    def update(self) -> None:
        """Copy the present values."""
        source, target = stored_values(self.blocks), stored_values(self.matrix)
        np.take(source, self._from, out=target, mode="clip")
        self.matrix.assemble()
        self.matrix.stateIncrease()


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
