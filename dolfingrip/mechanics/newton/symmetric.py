"""Symmetric PETSc matrices of scalars that store the upper triangle alone."""

from __future__ import annotations

import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc


def symmetric(rows: sp.csr_matrix, comm: MPI.Comm) -> PETSc.Mat:
    """A matrix (type SBAIJ) with the entries of ``rows``, also zeros, on and above its diagonal.

    Args:
        rows: (owned, all) the rank's rows, one rank's after the other's.
        comm: communicator of the ranks.
    """
    owned, size = rows.shape
    first = sum(comm.allgather(owned)[: comm.rank])
    entries = rows.tocoo()
    upper = entries.col >= entries.row + first
    kept = sp.csr_matrix(
        (entries.data[upper], (entries.row[upper], entries.col[upper])), rows.shape
    )
    kept.sort_indices()
    matrix = PETSc.Mat().create(comm)
    matrix.setSizes(((owned, size), (owned, size)), bsize=1)
    matrix.setType(PETSc.Mat.Type.SBAIJ)
    matrix.setPreallocationCSR(
        (kept.indptr.astype(PETSc.IntType), kept.indices.astype(PETSc.IntType), kept.data)
    )
    return matrix
