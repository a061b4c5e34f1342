"""Multigrid of two levels: the quadratic element, and the linear one with a factorisation.

The linear level has the interpolation to the quadratic one, and the tangent of its displacements.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import basix
import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.bordered import factors
from dolfingrip.mechanics.newton.inverse import Exact, cheapest

DEGREE: Final = 2
"""Degree of Chebyshev's polynomial, before and after the linear level's step."""

RATIO: Final = 4.0
"""Ratio of the highest and the lowest eigenvalue that it damps."""

BLOCK = 3
"""Unknowns of a node."""


class LinearLevel:
    """Displacements of the linear element on the same cells, as part of those of the quadratic one.

    A quadratic displacement that is linear in each cell has the mean of an edge's ends amid the
    edge. That holds for tetrahedra of 10 nodes and for hexahedra of 20. Global unknowns are kept as
    they are. Supports hold on both levels.

    The linear level's tangent PᵀKP sums blocks of K with weights that depend on the pattern alone.
    They are kept as a sparse matrix, so that this sum takes no longer than a product with K.

    Args:
        model: model with a displacement of second order, its only field.

    Attributes:
        parents: (nodes of all ranks, 2) nodes of the linear level that a node is the mean of; a
            corner's are one, twice.
        nodes: (nodes,) whether a block of unknowns, owned, is a node's and not of global unknowns.
    """

    def __init__(self, model: Model) -> None:
        self._comm = comm = model.comm
        space = model.u.function_space
        linear = fem.functionspace(space.mesh, ("Lagrange", 1, (3,)))
        fine, coarse = space.dofmap.index_map, linear.dofmap.index_map
        pads = model.unknowns.padded // BLOCK
        own_pads = pads if model.unknowns.owns_globals else 0
        self.nodes = np.arange(fine.size_local + own_pads) < fine.size_local
        self._rows = coarse.size_local + own_pads
        self._first = coarse.local_range[0]
        self._count = coarse.size_global + pads
        parents = _parents(space, linear)
        parts = [np.concatenate(comm.allgather(parents)), np.zeros((pads, 2), dtype=np.int64)]
        parts[1] += (coarse.size_global + np.arange(pads))[:, None]
        self.parents = np.concatenate(parts)
        free = np.concatenate(comm.allgather(model.free)).reshape(-1, BLOCK)
        single = np.flatnonzero(self.parents[:, 0] == self.parents[:, 1])
        coarse_free = np.zeros((self._count, BLOCK))
        coarse_free[self.parents[single, 0]] = free[single]
        self._free = coarse_free
        self._matrix: PETSc.Mat | None = None
        self._keys = np.empty(0, dtype=np.int64)
        self._sums: list[tuple[sp.csr_matrix, sp.csr_matrix]] = []
        start = fine.local_range[0]
        self.interpolation = self._interpolation(np.arange(start, start + len(self.nodes)), free)

    def _interpolation(self, rows: np.ndarray, free: np.ndarray) -> PETSc.Mat:
        """P as a matrix of scalars, without what supports hold."""
        parents = self.parents[rows]
        weights = np.where(parents[:, :1] == parents[:, 1:], [[1.0, 0.0]], [[0.5, 0.5]])
        data = weights[:, None, :] * free[rows][:, :, None]
        columns = BLOCK * parents[:, None, :] + np.arange(BLOCK)[:, None]
        data = data * self._free.ravel()[columns]
        row = np.broadcast_to(np.arange(BLOCK * len(rows)).reshape(-1, BLOCK, 1), columns.shape)
        kept = data.ravel() != 0
        entries = (data.ravel()[kept], (row.ravel()[kept], columns.ravel()[kept]))
        made = sp.csr_matrix(entries, shape=(BLOCK * len(rows), BLOCK * self._count))
        sizes = ((made.shape[0], None), (BLOCK * self._rows, None))
        csr = (made.indptr.astype(PETSc.IntType), made.indices.astype(PETSc.IntType), made.data)
        return PETSc.Mat().createAIJ(sizes, csr=csr, comm=self._comm)

    @property
    def graph(self) -> sp.csr_matrix:
        """Nodes of the linear level that its tangent couples, (owned nodes, nodes)."""
        row, column = np.divmod(self._keys, self._count)
        both = np.concatenate([row, column]), np.concatenate([column, row])
        couplings = sp.csr_matrix((np.ones(len(both[0])), both), (self._count, self._count))
        return couplings[self._first : self._first + self._rows]

    def assemble(self, matrix: PETSc.Mat) -> tuple[PETSc.Mat, np.ndarray]:
        """The linear level's tangent, and the blocks on the diagonal of ``matrix``.

        Args:
            matrix: the tangent, of type SBAIJ.

        Returns:
            The tangent PᵀKP of type SBAIJ, one and the same object as long as the pattern is; and
            (n, 3, 3) owned blocks on the diagonal of K.
        """
        if matrix != self._matrix:
            self._prepare(matrix)
            self._matrix = matrix
        values = np.zeros((len(self._keys), BLOCK * BLOCK))
        diagonal = np.empty((len(self.nodes), BLOCK, BLOCK))
        place = 0
        for (start, _, blocks), (straight, turned) in zip(
            _upper_blocks(matrix), self._sums, strict=True
        ):
            here = slice(place, place + len(start))
            diagonal[here] = blocks[start]
            place += len(start)
            flat = blocks.reshape(len(blocks), -1)
            values += straight @ flat
            other = (turned @ flat).reshape(-1, BLOCK, BLOCK)
            values += other.transpose(0, 2, 1).reshape(len(values), -1)
        if self._comm.size > 1:
            self._comm.Allreduce(MPI.IN_PLACE, values)
        self._fill(values.reshape(-1, BLOCK, BLOCK))
        return self._tangent, diagonal

    def _fill(self, values: np.ndarray) -> None:
        """Set the owned rows of the tangent."""
        row, column = np.divmod(self._keys, self._count)
        values = values * self._free[row][:, :, None] * self._free[column][:, None, :]
        held = np.flatnonzero(row == column)
        values[held[:, None], np.arange(BLOCK), np.arange(BLOCK)] += 1.0 - self._free[row[held]]
        owned = (row >= self._first) & (row < self._first + self._rows)
        counts = np.bincount(row[owned] - self._first, minlength=self._rows)
        self._tangent.setValuesBlockedCSR(
            np.concatenate([[0], np.cumsum(counts)]).astype(PETSc.IntType),
            column[owned].astype(PETSc.IntType),
            np.ascontiguousarray(values[owned]),
        )
        self._tangent.assemble()

    def _prepare(self, matrix: PETSc.Mat) -> None:
        """Take the pattern of ``matrix``: the linear level's pattern, and the sums of blocks."""
        contributions = []
        first = matrix.getOwnershipRange()[0] // BLOCK
        for start, columns, _ in _upper_blocks(matrix):
            counts = np.diff([*start, len(columns)])
            contributions.append(self._contributions(first, counts, columns))
            first += len(start)
        keys = [np.unique(key) for key, *_ in contributions]
        keys = self._comm.allgather(np.unique(np.concatenate(keys)))
        self._keys = np.unique(np.concatenate(keys))
        self._sums = []
        for key, which, weight, turned, count in contributions:
            place = np.searchsorted(self._keys, key)
            shape = (len(self._keys), count)
            self._sums.append(
                tuple(
                    sp.csr_matrix((weight[part], (place[part], which[part])), shape)
                    for part in (~turned, turned)
                )
            )
        row, column = np.divmod(self._keys, self._count)
        owned = (row >= self._first) & (row < self._first + self._rows)
        near = column[owned] < self._first + self._rows
        nnz = tuple(
            np.bincount(row[owned][part] - self._first, minlength=self._rows).astype(PETSc.IntType)
            for part in (near, ~near)
        )
        size = BLOCK * self._rows
        self._tangent = PETSc.Mat().create(self._comm)
        self._tangent.setSizes(((size, None), (size, None)), bsize=BLOCK)
        self._tangent.setType(PETSc.Mat.Type.SBAIJ)
        self._tangent.setPreallocationNNZ(nnz)

    def _contributions(
        self, first: int, counts: np.ndarray, column: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
        """Where the upper blocks of some rows go to on the linear level.

        Returns:
            Keys of the blocks there, the block that each takes, its weight, whether it is taken
            transposed, and the number of blocks.
        """
        row = first + np.repeat(np.arange(len(counts)), counts)
        keys, which, weights, turns = [], [], [], []
        for a in (0, 1):
            for b in (0, 1):
                up, along = self.parents[row, a], self.parents[column, b]
                double = [
                    self.parents[nodes, 0] != self.parents[nodes, 1] for nodes in (row, column)
                ]
                kept = (double[0] | (a == 0)) & (double[1] | (b == 0))
                weight = np.where(double[0], 0.5, 1.0) * np.where(double[1], 0.5, 1.0)
                inside = row == column
                for turned, part in (
                    (False, kept & (up <= along)),
                    (True, kept & ~inside & (up >= along)),
                ):
                    place = np.flatnonzero(part)
                    low, high = (along, up) if turned else (up, along)
                    keys.append(low[place] * self._count + high[place])
                    which.append(place)
                    weights.append(weight[place])
                    turns.append(np.full(len(place), turned))
        joined = [np.concatenate(part) for part in (keys, which, weights, turns)]
        return joined[0], joined[1], joined[2], joined[3], len(column)


def _parents(space: fem.FunctionSpace, linear: fem.FunctionSpace) -> np.ndarray:
    """Nodes (owned nodes, 2) of ``linear``, in all ranks' numbering, that a node is the mean of."""
    cell = space.mesh.basix_cell()
    edges = np.array(basix.topology(cell)[1])
    corners = len(basix.geometry(cell))
    ends = np.concatenate([np.repeat(np.arange(corners)[:, None], 2, axis=1), edges])
    nodes = space.dofmap.list
    vertices = linear.dofmap.index_map.local_to_global(linear.dofmap.list.ravel())
    places = vertices.reshape(-1, corners)[:, ends].astype(np.int64)
    parents = np.empty((nodes.max(initial=-1) + 1, 2), dtype=np.int64)
    parents[nodes.ravel()] = places.reshape(-1, 2)
    return parents[: space.dofmap.index_map.size_local]


def _upper_blocks(
    matrix: PETSc.Mat, rows_at_once: int = 50_000
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Blocks on and above the diagonal, by groups of owned block rows.

    Args:
        matrix: the matrix.
        rows_at_once: rows of blocks whose copies are in memory together.

    Yields:
        For each group: place of each row's first block, which is the diagonal's; (m,) columns of
        the blocks; (m, 3, 3) blocks.
    """
    matrix.setOption(PETSc.Mat.Option.GETROW_UPPERTRIANGULAR, True)
    pointer, columns, values = matrix.getValuesCSR()
    for first in range(0, len(pointer) - 1, BLOCK * rows_at_once):
        rows = pointer[first : first + BLOCK * rows_at_once + 1]
        counts = np.diff(rows[::BLOCK]) // (BLOCK * BLOCK)
        places = np.concatenate([[0], np.cumsum(counts)])
        # a row of blocks comes as three rows of scalars
        within = np.arange(places[-1]) - np.repeat(places[:-1], counts)
        base = np.repeat(rows[:-1:BLOCK], counts) + BLOCK * within
        stride = BLOCK * np.repeat(counts, counts)
        index = base[:, None] + stride[:, None] * np.arange(BLOCK)
        yield places[:-1], columns[base] // BLOCK, values[index[:, :, None] + np.arange(BLOCK)]


class Multigrid:
    """An approximate inverse of the tangent of a quadratic element: one V-cycle (p-multigrid).

    Chebyshev's iteration on the blocks of the diagonal smooths (Adams, Brezina, Hu & Tuminaro, J.
    Comput. Phys. 188, 2003). The linear level is factorised. It has an eighth of a tetrahedral
    mesh's unknowns and a fourth of a hexahedral one's. Global unknowns are left to the linear
    level.

    Args:
        prefix: prefix of PETSc's options of the factorisation.
        model: model with a displacement of second order, its only field.

    Attributes:
        pc: the preconditioner.
    """

    exact = False

    def __init__(self, prefix: str, model: Model) -> None:
        self._prefix, self._model, self._comm = prefix, model, model.comm
        self._level = LinearLevel(model)
        self._coarse: Exact | None = None
        self.pc = PETSc.PC().create(model.comm)

    def _create(self, blocks: int) -> Exact:
        """Make the cycle, with the inverse of what is factorised on the linear level."""
        graph, comm = self._level.graph, self._comm  # the model is freed where nothing holds self
        coarse = factors(
            self._prefix + "linear_", self._model, lambda: cheapest(graph, comm).number, np.float64
        )
        size = (BLOCK * blocks, None)
        self._inverse = PETSc.Mat().createBAIJ((size, size), BLOCK, nnz=(1, 0), comm=comm)
        self.pc.setType(PETSc.PC.Type.MG)
        self.pc.setMGLevels(2)
        self.pc.setMGInterpolation(1, self._level.interpolation)
        below = self.pc.getMGCoarseSolve()
        below.setType(PETSc.KSP.Type.PREONLY)
        below.setPC(coarse.pc)
        smoother = self.pc.getMGSmoother(1)
        smoother.setOptionsPrefix(self._prefix + "smoother_")
        smoother.setType(PETSc.KSP.Type.CHEBYSHEV)
        smoother.setTolerances(max_it=DEGREE)
        smoother.getPC().setType(PETSc.PC.Type.MAT)
        ends = f"0,{1 / RATIO},0,1"  # of the highest eigenvalue that PETSc estimates
        PETSc.Options()[self._prefix + "smoother_ksp_chebyshev_esteig"] = ends
        smoother.setFromOptions()
        return coarse

    def set_up(self, matrix: PETSc.Mat) -> None:
        """Take ``matrix`` as the one to invert."""
        coarse, diagonal = self._level.assemble(matrix)
        self._coarse = self._coarse or self._create(len(diagonal))
        self._coarse.set_up(coarse)
        self._invert(diagonal)
        self.pc.getMGCoarseSolve().setOperators(coarse)
        self.pc.getMGSmoother(1).setOperators(matrix, self._inverse)
        self.pc.setOperators(matrix)
        self.pc.setReusePreconditioner(False)
        self.pc.setUp()
        self.pc.setReusePreconditioner(True)  # for the next tangents

    @property
    def negative(self) -> int:
        """Negative eigenvalues on the linear level: the tangent has as many or more."""
        assert self._coarse is not None
        return self._coarse.negative

    @property
    def failed(self) -> PETSc.PC.FailedReason:
        """Why the linear level could not be factorised; 0 if it was."""
        assert self._coarse is not None
        return self._coarse.failed

    def _invert(self, diagonal: np.ndarray) -> None:
        """Keep the inverse blocks on the diagonal; 0 for global unknowns."""
        inverse = np.zeros_like(diagonal)
        inverse[self._level.nodes] = np.linalg.inv(diagonal[self._level.nodes])
        count, first = len(diagonal), self._inverse.getOwnershipRange()[0] // BLOCK
        self._inverse.setValuesBlockedCSR(
            np.arange(count + 1, dtype=PETSc.IntType),
            np.arange(first, first + count, dtype=PETSc.IntType),
            inverse,
        )
        self._inverse.assemble()
