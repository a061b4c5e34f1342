"""The tangent matrix: a fixed pattern with room for contact."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from dolfingrip.mechanics.model import Model


class Tangent:
    """Hessian of Π (N/mm) as a PETSc matrix whose pattern changes only when contact needs it.

    Contact couples nodes that no element joins. Their places are added to the pattern with
    the pairs that come near, so that from one iteration to the next the symbolic factorisation
    stays valid.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._form = model.potential.tangent
        self._elastic = fem_petsc.create_matrix(self._form)
        # fill it once: an empty matrix would lose its pattern in the first assembly
        fem_petsc.assemble_matrix(self._elastic, self._form, bcs=model.supports)
        self._elastic.assemble()
        self.matrix = self._elastic
        self.patterns = 0
        self._known = np.empty(0, dtype=np.int64)
        space = model.u.function_space
        index_map = space.dofmap.index_map
        count = index_map.size_local + index_map.num_ghosts
        self._supported = self._supported_nodes(3 * count)

    def _supported_nodes(self, size: int) -> np.ndarray:
        """(n, 3) booleans over the contact surface's vertices: dofs held by a support."""
        marked = np.zeros(size, dtype=bool)
        for bc in self._model.supports:
            marked[bc.dof_indices()[0]] = True
        contact = self._model.contact
        if contact is None:
            return np.empty((0, 3), dtype=bool)
        return contact.surface.displacement(marked.astype(float)) > 0.5

    def assemble(self) -> None:
        """Assemble at the model's present state."""
        model = self._model
        extra = None
        if model.contact is not None:
            extra = model.contact.hessian(model.u.x.array)
        if extra is not None:
            self._make_room(extra)
        self.matrix.zeroEntries()
        fem_petsc.assemble_matrix(self.matrix, self._form, bcs=model.supports)
        self.matrix.assemble()
        if extra is not None:
            self._add(extra)
            self.matrix.assemble()

    def _global_dofs(self) -> np.ndarray:
        """(3n,) global dof of each surface vertex's components."""
        assert self._model.contact is not None
        nodes = self._model.contact.surface.nodes
        return (3 * nodes[:, None] + np.arange(3)).ravel()

    def _owned_rows(self, extra: sp.coo_matrix) -> sp.csr_matrix:
        """Rows of the contact Hessian that this rank owns, free dofs only, global columns."""
        free = ~self._supported.ravel()
        dofs = self._global_dofs()
        first, last = self._elastic.getOwnershipRange()
        rows, columns = dofs[extra.row], dofs[extra.col]
        keep = free[extra.row] & free[extra.col] & (rows >= first) & (rows < last)
        size = self._elastic.getSize()[1]
        return sp.csr_matrix(
            (extra.data[keep], (rows[keep] - first, columns[keep])), shape=(last - first, size)
        )

    def _add(self, extra: sp.coo_matrix) -> None:
        rows = self._owned_rows(extra)
        self.matrix.setValuesCSR(
            rows.indptr.astype(PETSc.IntType), rows.indices.astype(PETSc.IntType), rows.data,
            addv=True,
        )

    def _make_room(self, extra: sp.coo_matrix) -> None:
        """Widen the pattern where ``extra`` has vertex pairs that it lacks."""
        count = np.int64(extra.shape[0] // 3)
        pairs = np.unique((extra.row // 3) * count + extra.col // 3)
        if np.isin(pairs, self._known, assume_unique=True).all():
            return
        assert self._model.contact is not None
        near = self._model.contact.near_pairs(self._model.u.x.array)
        keys = np.concatenate([near[:, 0] * count + near[:, 1], near[:, 1] * count + near[:, 0]])
        self._known = np.unique(np.concatenate([pairs, keys]))
        row, column = np.divmod(self._known, count)
        block = sp.coo_matrix(
            (np.ones(9 * len(row)),
             ((3 * row[:, None] + np.repeat(np.arange(3), 3)).ravel(),
              (3 * column[:, None] + np.tile(np.arange(3), 3)).ravel())),
            shape=extra.shape,
        )
        indptr, indices, _ = self._elastic.getValuesCSR()
        first, last = self._elastic.getOwnershipRange()
        shape = (last - first, self._elastic.getSize()[1])
        elastic = sp.csr_matrix((np.ones(len(indices)), indices, indptr), shape=shape)
        union = (elastic + self._owned_rows(block)).tocsr()
        union.sort_indices()

        matrix = PETSc.Mat().create(self._model.comm)
        matrix.setSizes(self._elastic.getSizes(), bsize=3)
        matrix.setType(PETSc.Mat.Type.AIJ)
        matrix.setPreallocationCSR(
            (union.indptr.astype(PETSc.IntType), union.indices.astype(PETSc.IntType))
        )
        matrix.setLGMap(*self._elastic.getLGMap())
        matrix.assemble()
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_LOCATION_ERR, True)
        self.matrix = matrix
        self.patterns += 1
