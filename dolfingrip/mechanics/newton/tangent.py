"""The tangent matrix: symmetric blocks in a pattern that grows with contact."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import add

import numpy as np
import scipy.sparse as sp
from dolfinx import cpp, fem
from dolfinx.fem import petsc as fem_petsc
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.model.compatibility import global_columns
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.term import Coupling


class Tangent:
    """The Hessian of Π (N/mm) as a PETSc matrix whose pattern changes only if contact requires it.

    It has blocks of 3 × 3 in the upper triangle alone: inserting scalars into a full matrix takes
    as long as computing them. Contact couples nodes that no element joins. Their entries are added
    when they are first needed, and they stay, so that the symbolic factorisation soon stays valid.
    Entries for pairs that only come near cost more in each factorisation than they save.

    Attributes:
        graph: (owned nodes, nodes) nodes that the elements couple.
        matrix: the PETSc matrix (type SBAIJ), replaced when the pattern grows.
        patterns: number of patterns so far.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        index_map = model.u.function_space.dofmap.index_map
        self._nodes = model.unknowns.nodes
        self._global_blocks = model.unknowns.padded // 3
        own_blocks = self._global_blocks if model.unknowns.owns_globals else 0
        self._rows = index_map.size_local + own_blocks
        self._first = index_map.local_range[0]
        self._free = model.unknowns.create_vector()
        self._free.array[:] = model.free
        self._held = self._free.duplicate()
        self._held.array[:] = 1.0 - model.free
        self.patterns = 0
        graphs = [block_graph(forms[0][0]) for forms in self._forms]
        self._elements = self._with_globals(reduce(add, graphs))
        self._known: np.ndarray = np.empty(0, dtype=np.int64)
        if self._global_blocks:  # what they couple is known before the first step
            self._note(self._couplings(convex=False))
        self.graph = self._whole_graph()
        self.matrix = self._create(self.graph)

    @property
    def _forms(self) -> list[Sequence[Sequence[fem.Form]]]:
        """The forms that elements integrate, of all terms that have such forms."""
        return [forms for term in self._model.all_terms if (forms := term.tangent_forms())]

    def assemble(self, *, convex: bool = False) -> None:
        """Assemble at the model's present state; ``convex``: Hessians of pairs are made convex."""
        couplings = self._couplings(convex=convex)
        self._make_room(couplings)
        self.matrix.zeroEntries()
        for coupling in couplings:
            self._add(coupling)
        for forms in self._forms:
            self._assemble_forms(forms)
        self.matrix.assemble()
        constraint = self._model.constraint_hessian(self._product)
        self.matrix.diagonalScale(self._free, self._free)
        self.matrix.setDiagonal(self._held, addv=True)  # 1 for what supports hold, and fillers
        if constraint is not None:
            self._add_rows(constraint)
            self.matrix.assemble()

    def _assemble_forms(self, forms: Sequence[Sequence[fem.Form]]) -> None:
        """Add the elements' integrals without regard to supports."""
        fem_petsc.assemble_matrix(self.matrix, forms[0][0])

    def _couplings(self, *, convex: bool) -> list[Coupling]:
        """The couplings of all terms at the model's present state."""
        dofs = self._model.u.x.array
        return [
            coupling
            for term in self._model.all_terms
            for coupling in term.couplings(dofs, convex=convex)
        ]

    def _product(self, values: np.ndarray) -> np.ndarray:
        """Product of the matrix and an owned array in a vector's order."""
        x, y = self._model.unknowns.create_vector(), self._model.unknowns.create_vector()
        x.array[:] = values
        self.matrix.mult(x, y)
        return np.array(y.array_r)

    def _add_rows(self, rows: sp.csr_matrix) -> None:
        """Add (owned, all) scalar ``rows``."""
        self.matrix.setValuesCSR(
            rows.indptr.astype(PETSc.IntType),
            rows.indices.astype(PETSc.IntType),
            rows.data,
            addv=True,
        )

    # -- pattern -------------------------------------------------------------------------------

    def _with_globals(self, graph: sp.csr_matrix) -> sp.csr_matrix:
        """``graph`` with rows and columns for global unknowns, coupled with one another."""
        if not self._global_blocks:
            return graph
        graph = sp.csr_matrix(
            (graph.data, graph.indices, graph.indptr),
            (graph.shape[0], self._nodes + self._global_blocks),
        )
        if not self._model.unknowns.owns_globals:
            return graph
        border = np.zeros((self._global_blocks, self._nodes + self._global_blocks))
        border[:, self._nodes :] = 1.0
        return sp.csr_matrix(sp.vstack([graph, sp.csr_matrix(border)]))

    def _whole_graph(self) -> sp.csr_matrix:
        """Entries of elements, of known couplings, and of dependent displacements' unknowns."""
        graph = self._elements
        if self._known.size:
            graph = (graph + self._pattern(self._known)).tocsr()
        return with_places_of_leaders(
            graph,
            self._gathered(self._first + self._model.dependent_dofs // 3),
            self._model.unknowns.global_nodes(),
        )

    def _gathered(self, local: np.ndarray) -> np.ndarray:
        """The couplings of all ranks."""
        return np.unique(np.concatenate(self._model.comm.allgather(local)))

    def _create(self, graph: sp.csr_matrix) -> PETSc.Mat:
        """An assembled zero matrix with the entries of ``graph`` (owned block rows)."""
        local, size = 3 * self._rows, 3 * graph.shape[1]
        row, column = graph.nonzero()
        here = (column >= self._first) & (column < self._first + self._rows)
        upper = column >= row + self._first
        count = [
            np.bincount(row[part & upper], minlength=self._rows).astype(PETSc.IntType)
            for part in (here, ~here)
        ]
        matrix = PETSc.Mat().create(self._model.comm)
        matrix.setSizes(((local, size), (local, size)), bsize=3)
        matrix.setType(PETSc.Mat.Type.SBAIJ)
        matrix.setPreallocationNNZ(tuple(count))
        matrix.setLGMap(self._numbering(), self._numbering())
        matrix.setOption(PETSc.Mat.Option.IGNORE_LOWER_TRIANGULAR, True)
        # an assembly drops entries that were not set
        self._insert(matrix, graph, np.zeros((len(row), 3, 3)))
        matrix.assemble()
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_LOCATION_ERR, True)
        self.patterns += 1
        return matrix

    def _numbering(self) -> PETSc.LGMap:
        """Local to global block numbers of the displacement nodes."""
        index_map = self._model.u.function_space.dofmap.index_map
        count = index_map.size_local + index_map.num_ghosts
        nodes = index_map.local_to_global(np.arange(count, dtype=np.int32))
        return PETSc.LGMap().create(nodes.astype(PETSc.IntType), bsize=3, comm=self._model.comm)

    def _note(self, couplings: Sequence[Coupling]) -> bool:
        """Note the pairs of nodes in ``couplings``; return whether any rank has new ones."""
        keys = [self._known]
        for nodes, hessian in couplings:
            count = max(len(nodes), 1)
            pairs = np.unique((hessian.row // 3).astype(np.int64) * count + hessian.col // 3)
            row, column = np.divmod(pairs, count)
            row, column = nodes[row], nodes[column]
            # every node is coupled with itself by its elements
            owned = (row >= self._first) & (row < self._first + self._rows) & (row != column)
            keys.append(self._keys(row[owned], column[owned]))
        all_keys = np.unique(np.concatenate(keys))
        new = all_keys.size > self._known.size
        self._known = all_keys
        return bool(self._model.comm.allreduce(new, MPI.LOR))

    def _keys(self, row: np.ndarray, column: np.ndarray) -> np.ndarray:
        return np.asarray(row.astype(np.int64) * (self._nodes + self._global_blocks) + column)

    def _pattern(self, keys: np.ndarray) -> sp.csr_matrix:
        """Owned pairs of nodes as a graph."""
        row, column = np.divmod(keys, self._nodes + self._global_blocks)
        shape = (self._rows, self._nodes + self._global_blocks)
        return sp.csr_matrix((np.ones(len(row)), (row - self._first, column)), shape=shape)

    def _make_room(self, couplings: Sequence[Coupling]) -> None:
        """Widen the pattern if ``couplings`` have pairs of nodes that it lacks."""
        if self._note(couplings):
            self.matrix = self._create(self._whole_graph())

    # -- couplings -----------------------------------------------------------------------------

    def _add(self, coupling: Coupling) -> None:
        """Add the block rows that this rank owns."""
        nodes, hessian = coupling
        blocks = sp.coo_matrix(hessian).tobsr((3, 3))
        which = np.repeat(np.arange(len(nodes)), np.diff(blocks.indptr))
        row, column = nodes[which], nodes[blocks.indices]
        owned = (row >= self._first) & (row < self._first + self._rows)
        graph = sp.csr_matrix(
            (np.flatnonzero(owned) + 1, (row[owned] - self._first, column[owned])),
            shape=self.graph.shape,
        )
        self._insert(self.matrix, graph, blocks.data[graph.data - 1], add=True)

    def _insert(
        self, matrix: PETSc.Mat, graph: sp.csr_matrix, blocks: np.ndarray, *, add: bool = False
    ) -> None:
        """Set or add (3, 3) ``blocks`` at the entries of ``graph``."""
        matrix.setValuesBlockedCSR(
            graph.indptr.astype(PETSc.IntType),
            graph.indices.astype(PETSc.IntType),
            np.ascontiguousarray(blocks),
            addv=add,
        )


def with_places_of_leaders(
    graph: sp.csr_matrix, followers: np.ndarray, leaders: np.ndarray
) -> sp.csr_matrix:
    """``graph`` with entries in the columns of ``leaders`` in each row with a follower's entry."""
    if not len(followers):
        return graph
    row, column = graph.nonzero()
    touched = np.unique(row[np.isin(column, followers)])
    more = (np.repeat(touched, len(leaders)), np.tile(leaders, len(touched)))
    return (graph + sp.csr_matrix((np.ones(len(more[0])), more), graph.shape)).tocsr()


def block_graph(form: fem.Form) -> sp.csr_matrix:
    """Owned block rows, with global block columns, of the pairs that a form's elements couple."""
    pattern = cpp.fem.create_sparsity_pattern(form._cpp_object)
    pattern.finalize()
    edges, offsets = pattern.graph
    rows, across = (space.dofmap.index_map for space in form.function_spaces)
    edges, offsets = np.asarray(edges), np.asarray(offsets[: rows.size_local + 1])
    edges = global_columns(pattern, edges[: offsets[-1]].astype(np.int32))
    shape = (rows.size_local, across.size_global)
    return sp.csr_matrix((np.ones(len(edges)), edges, offsets), shape=shape)
