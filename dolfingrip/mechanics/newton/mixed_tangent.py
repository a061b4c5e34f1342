"""The tangent of a mixed model: one symmetric matrix, and the pressure that a displacement has."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc

from dolfingrip.mechanics.model.compatibility import assemble_blocks
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.newton.symmetric import symmetric
from dolfingrip.mechanics.newton.tangent import Tangent, block_graph, with_places_of_leaders


class MixedTangent(Tangent):
    """The Hessian of Π(u, p), which is indefinite because Π is concave in p.

    It has scalar entries instead of 3 × 3 blocks, in the upper triangle alone. On each rank the
    rows of the displacement come first, then those of the pressure. Contact adds to the
    displacement's rows.
    """

    def __init__(self, model: Model) -> None:
        self._model = model
        self._fields = [_Place(field.function_space) for field in model.unknowns.fields]
        sizes = np.array(model.comm.allgather([field.size for field in self._fields]))
        starts = np.cumsum(sizes.ravel()).reshape(sizes.shape) - sizes  # global unknowns come last
        for field, start, size in zip(self._fields, starts.T, sizes.T, strict=True):
            field.settle(start, size, model.unknowns.size, model.unknowns.padded)
        displacement, pressure = self._fields
        self._beside = sp.csr_matrix((displacement.size, model.unknowns.size))
        self._below = sp.csr_matrix((pressure.size, model.unknowns.size))
        for forms in self._forms:
            if len(forms) > 1:
                (_, across), (back, within) = (map(_scalar_graph, row) for row in forms)
                self._beside = self._beside + pressure.columns(across)
                self._below = self._below + displacement.columns(back) + pressure.columns(within)
        first = int(starts[model.comm.rank, 0])
        self._below = with_places_of_leaders(
            self._below,
            self._gathered(first + model.dependent_dofs),
            np.arange(model.unknowns.size - model.unknowns.padded, model.unknowns.size),
        )
        super().__init__(model)

    def _create(self, graph: sp.csr_matrix) -> PETSc.Mat:
        """An assembled zero matrix with the entries of ``graph`` (owned displacement nodes)."""
        ones = np.ones((graph.nnz, 3, 3))
        above, below = self._scalars(graph, ones)
        pattern = sp.vstack([above + self._beside, self._below, below])
        matrix = symmetric(0.0 * pattern, self._model.comm)
        local = np.concatenate([field.rows() for field in self._fields])
        numbering = PETSc.LGMap().create(local.astype(PETSc.IntType), comm=self._model.comm)
        matrix.setLGMap(numbering, numbering)
        matrix.setOption(PETSc.Mat.Option.IGNORE_LOWER_TRIANGULAR, True)
        matrix.setOption(PETSc.Mat.Option.NEW_NONZERO_LOCATION_ERR, True)
        self.patterns += 1
        return matrix

    def _scalars(
        self, graph: sp.csr_matrix, blocks: np.ndarray
    ) -> tuple[sp.csr_matrix, sp.csr_matrix]:
        """Blocks at the entries of ``graph`` as scalar rows, of nodes and of others, (3, 3)."""
        shape = (3 * graph.shape[0], 3 * graph.shape[1])
        scalars = sp.bsr_matrix((blocks, graph.indices, graph.indptr), shape).tocsr()
        rows = self._fields[0].columns(scalars)
        return rows[: self._fields[0].size], rows[self._fields[0].size :]

    def _insert(
        self, matrix: PETSc.Mat, graph: sp.csr_matrix, blocks: np.ndarray, *, add: bool = False
    ) -> None:
        """Add (3, 3) ``blocks`` at the entries of ``graph``."""
        above, below = self._scalars(graph, blocks)
        nothing = sp.csr_matrix(self._below.shape)  # in the pressure's rows
        self._add_rows(sp.vstack([above, nothing, below], "csr"))

    def _assemble_forms(self, forms: Sequence[Sequence[fem.Form]]) -> None:
        assemble_blocks(self.matrix, forms)


class _Place:
    """Rows and columns of one field's dofs in the matrix."""

    def __init__(self, space: fem.FunctionSpace) -> None:
        self._map = space.dofmap.index_map
        self._block = space.dofmap.index_map_bs
        self.size = self._map.size_local * self._block

    def settle(self, starts: np.ndarray, sizes: np.ndarray, count: int, last: int) -> None:
        """Take ``sizes`` rows from ``starts``, by rank, of ``count``, ``last`` of them global."""
        self._count = count
        self._ends = np.cumsum(sizes)
        self._shift = starts - (self._ends - sizes)
        self._last = self._ends[-1] + last

    def to_matrix(self, dofs: np.ndarray) -> np.ndarray:
        """Rows of the matrix of global dofs."""
        owner = np.searchsorted(self._ends, dofs, side="right")
        shift = np.append(self._shift, self._count - self._last)  # beyond are the global unknowns
        return np.asarray(dofs + shift[owner])

    def columns(self, graph: sp.csr_matrix) -> sp.csr_matrix:
        """``graph`` with its columns, dofs of this field, as columns of the matrix."""
        places = self.to_matrix(graph.indices.astype(np.int64))
        return sp.csr_matrix((graph.data, places, graph.indptr), (graph.shape[0], self._count))

    def rows(self) -> np.ndarray:
        """Rows of the local dofs, also of ghosts."""
        count = self._map.size_local + self._map.num_ghosts
        nodes = self._map.local_to_global(np.arange(count, dtype=np.int32)).astype(np.int64)
        dofs = self._block * nodes[:, None] + np.arange(self._block)
        return self.to_matrix(dofs.ravel())


def _scalar_graph(form: fem.Form) -> sp.csr_matrix:
    """The pairs of dofs that a form's elements couple."""
    blocks = tuple(space.dofmap.index_map_bs for space in form.function_spaces)
    return sp.kron(block_graph(form), np.ones(blocks), "csr")


def condensing_step(model: Model) -> np.ndarray:
    """The step from a mixed model's p to the p(u) that solves ∂Π/∂p = 0 at the present u.

    A step of displacement and pressure together may raise Π, which is concave in p. Π(u, p(u)), of
    the displacement alone, falls along each step of its tangent.

    Args:
        model: a mixed model, quadratic in p like a perturbed Lagrangian.

    Returns:
        A local array of the unknowns.
    """
    forms = [term.tangent_forms() for term in model.all_terms]
    first, *others = [blocks[-1][-1] for blocks in forms if len(blocks) > 1]
    tangent = fem_petsc.assemble_matrix(first)
    for form in others:
        fem_petsc.assemble_matrix(tangent, form)
    tangent.assemble()
    tangent.scale(-1.0)
    change = tangent.createVecLeft()
    right = change.duplicate()
    right.array[:] = model.unknowns.owned_parts(model.gradient())[1]
    ksp = PETSc.KSP().create(model.comm)
    ksp.setType(PETSc.KSP.Type.CG)
    ksp.getPC().setType(PETSc.PC.Type.JACOBI)  # this makes a mass matrix well conditioned
    ksp.setTolerances(rtol=1e-12)
    ksp.setOperators(tangent)
    ksp.solve(right, change)
    step = np.zeros(model.unknowns.owned_size)
    model.unknowns.owned_parts(step)[1][:] = change.array_r
    for made in (ksp, tangent, change, right):
        made.destroy()
    return model.unknowns.to_local(step)
