"""The tangent matrix: symmetric blocks in a fixed pattern with room for contact."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from dolfinx import cpp, fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from dolfingrip.mechanics.model.model import Model


class Tangent:
    """Hessian of Π (N/mm) as a PETSc matrix whose pattern changes only when contact needs it.

    Blocks of 3 × 3, the upper triangle alone: inserting scalars into a full matrix takes as
    long as computing them. Contact couples nodes that no element joins; their places are added
    when they are first needed, and stay, so that the symbolic factorisation soon stays valid.
    Places for pairs that only come near cost more in each factorisation than they save.

    Attributes:
        graph: (owned nodes, nodes) which nodes the elements couple.
        matrix: the PETSc matrix (type SBAIJ), replaced when the pattern grows.
        patterns: how many patterns there were.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._form = model.potential.tangent
        self.graph = block_graph(self._form)
        self._rows = self.graph.shape[0]
        self._first = model.u.function_space.dofmap.index_map.local_range[0]
        self._known = np.empty(0, dtype=np.int64)
        self._free = self._free_components()
        self.patterns = 0
        self.matrix = self._create(self.graph)

    def assemble(self, *, convex: bool = False) -> None:
        """Assemble at the model's present state, contact ``convex`` or as it is."""
        model = self._model
        extra = None
        if model.contact is not None:
            extra = model.contact.hessian(model.u.x.array, convex=convex)
        if extra is not None:
            self._make_room(extra)
        self.matrix.zeroEntries()
        if extra is not None:  # before the form, which ends by setting the supports' diagonal
            self._add(self._scaled(extra))
        self._assemble_forms()
        self.matrix.assemble()

    def _assemble_forms(self) -> None:
        """Add the UFL energies' part; 1 on the supports' diagonal."""
        fem_petsc.assemble_matrix(self.matrix, self._form, bcs=self._model.supports)

    # -- pattern -------------------------------------------------------------------------------

    def _create(self, graph: sp.csr_matrix) -> PETSc.Mat:
        """An assembled zero matrix with the places of ``graph`` (owned block rows)."""
        space = self._model.u.function_space
        local, size = 3 * self._rows, 3 * space.dofmap.index_map.size_global
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
        # an assembly drops places that were not set
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

    def _make_room(self, extra: sp.coo_matrix) -> None:
        """Widen the pattern where ``extra`` has vertex pairs that it lacks."""
        count = np.int64(extra.shape[0] // 3)
        pairs = np.unique((extra.row // 3) * count + extra.col // 3)
        if np.isin(pairs, self._known, assume_unique=True).all():
            return
        assert self._model.contact is not None
        self._known = np.union1d(self._known, pairs)
        nodes = self._model.contact.surface.nodes
        row, column = (nodes[i] for i in np.divmod(self._known, count))
        owned = (row >= self._first) & (row < self._first + self._rows)
        contact = sp.csr_matrix(
            (np.ones(owned.sum()), (row[owned] - self._first, column[owned])),
            shape=self.graph.shape,
        )
        self.matrix = self._create((self.graph + contact).tocsr())

    # -- contact -------------------------------------------------------------------------------

    def _free_components(self) -> np.ndarray:
        """(3n,) 1 for free components of the contact surface's nodes, 0 for supported ones."""
        contact = self._model.contact
        if contact is None:
            return np.empty(0)
        free = np.ones_like(self._model.u.x.array)
        for bc in self._model.supports:
            free[bc.dof_indices()[0]] = 0.0
        return contact.surface.at_nodes(free).ravel()

    def _scaled(self, extra: sp.coo_matrix) -> sp.bsr_matrix:
        """The contact Hessian by blocks, zero in supported rows and columns."""
        data = extra.data * self._free[extra.row] * self._free[extra.col]
        return sp.coo_matrix((data, (extra.row, extra.col)), shape=extra.shape).tobsr((3, 3))

    def _add(self, blocks: sp.bsr_matrix) -> None:
        """Add the block rows that this rank owns."""
        assert self._model.contact is not None
        nodes = self._model.contact.surface.nodes
        vertex = np.repeat(np.arange(len(nodes)), np.diff(blocks.indptr))
        row, column = nodes[vertex], nodes[blocks.indices]
        owned = (row >= self._first) & (row < self._first + self._rows)
        graph = sp.csr_matrix(
            (np.flatnonzero(owned) + 1, (row[owned] - self._first, column[owned])),
            shape=self.graph.shape,
        )
        self._insert(self.matrix, graph, blocks.data[graph.data - 1], add=True)

    def _insert(
        self, matrix: PETSc.Mat, graph: sp.csr_matrix, blocks: np.ndarray, *, add: bool = False
    ) -> None:
        """Set or add (3, 3) ``blocks`` at the places of ``graph``."""
        matrix.setValuesBlockedCSR(
            graph.indptr.astype(PETSc.IntType),
            graph.indices.astype(PETSc.IntType),
            np.ascontiguousarray(blocks),
            addv=add,
        )


def block_graph(form: fem.Form) -> sp.csr_matrix:
    """Owned block rows with global block columns of what a form's elements couple."""
    pattern = cpp.fem.create_sparsity_pattern(form._cpp_object)
    pattern.finalize()
    edges, offsets = pattern.graph
    rows, across = (space.dofmap.index_map for space in form.function_spaces)
    columns = pattern.column_index_map()
    edges, offsets = np.asarray(edges), np.asarray(offsets[: rows.size_local + 1])
    edges = columns.local_to_global(edges[: offsets[-1]].astype(np.int32))
    shape = (rows.size_local, across.size_global)
    return sp.csr_matrix((np.ones(len(edges)), edges, offsets), shape=shape)
