"""Factorisations whose estimate of memory is too small."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.inverse import (
    FIRST_PERCENT,
    RELAXATION,
    TOO_SMALL,
    factorise_by_mumps,
)
from dolfingrip.mechanics.newton.symmetric import symmetric

SEED = 4


def saddle_point(rng: np.random.Generator) -> sp.csr_matrix:
    """[[A, B], [Bᵀ, 0]], whose pivots are delayed by the zeros of its diagonal."""
    free, held = 400, 300
    a = sp.diags_array([np.full(free, 1e-6), np.full(free - 1, 1.0)], offsets=[0, 1])
    b = sp.random_array((free, held), density=0.02, rng=rng) + sp.eye_array(free, held)
    return sp.csr_matrix(sp.block_array([[a, b], [None, sp.csr_array((held, held))]]))


@pytest.fixture
def starved() -> PETSc.PC:
    """A factorisation with half the memory of MUMPS' estimate, and its matrix."""
    print("seed", SEED)
    pc = PETSc.PC().create(MPI.COMM_SELF)
    pc.setOptionsPrefix("test_workspace_")
    pc.setType(PETSc.PC.Type.CHOLESKY)
    pc.setFactorSolverType(PETSc.Mat.SolverType.MUMPS)
    PETSc.Options("test_workspace_")[RELAXATION] = -50
    matrix = symmetric(saddle_point(np.random.default_rng(SEED)), MPI.COMM_SELF)
    pc.setOperators(matrix)
    return pc


def test_without_more_it_fails_for_good(starved: PETSc.PC) -> None:
    """Or the next test would show nothing; PETSc takes no later matrix, either."""
    for _ in range(2):
        starved.setUp()
        assert starved.getFactorMatrix().getMumpsInfog(1) in TOO_SMALL
        assert starved.getFailedReason() == PETSc.PC.FailedReason.FACTOR_OUTMEMORY
        starved.getOperators()[0].scale(2.0)


def test_it_gets_more_memory(starved: PETSc.PC) -> None:
    factorise_by_mumps(starved)
    assert starved.getFailedReason() == PETSc.PC.FailedReason.NOERROR
    matrix = starved.getOperators()[0]
    exact, found = matrix.createVecs()
    exact.set(1.0)
    starved.apply(matrix * exact, found)
    np.testing.assert_allclose(found.array_r, 1.0, rtol=0, atol=1e-8)


def test_the_next_matrix_has_it_at_once(starved: PETSc.PC) -> None:
    factorise_by_mumps(starved)
    room = starved.getFactorMatrix().getMumpsIcntl(14)
    starved.getOperators()[0].scale(2.0)
    factorise_by_mumps(starved)
    assert starved.getFactorMatrix().getMumpsIcntl(14) == room == FIRST_PERCENT


def test_a_singular_matrix_is_still_reported(starved: PETSc.PC) -> None:
    """All its pivots are delayed, so it asks for more memory first."""
    starved.getOperators()[0].zeroEntries()
    factorise_by_mumps(starved)
    assert starved.getFactorMatrix().getMumpsInfog(1) not in TOO_SMALL
    assert starved.getFailedReason() != PETSc.PC.FailedReason.NOERROR
