"""Cholesky factors of definite matrices in blocks of 3, and LDLᵀ of others."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton import cholmod
from dolfingrip.mechanics.newton.cholesky import MOST_SKIPPED, Cholesky
from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.factors import Factors
from dolfingrip.mechanics.newton.inverse import Exact, Factorisation
from dolfingrip.mechanics.newton.policy import FactorPolicy

pytestmark = pytest.mark.skipif(not cholmod.available(), reason="needs CHOLMOD")

SEED = 3
NODES = 40


def chain(reach: int) -> np.ndarray:
    """A random symmetric matrix, definite, whose nodes are coupled with ``reach`` neighbours."""
    rng = np.random.default_rng(SEED)
    dense = rng.uniform(-1, 1, (3 * NODES, 3 * NODES))
    node = np.arange(3 * NODES) // 3
    dense[abs(node[:, None] - node) > reach] = 0.0
    return dense + dense.T + 12 * (reach + 1) * np.eye(3 * NODES)


def tangent(dense: np.ndarray) -> PETSc.Mat:
    """The blocks on and above the diagonal, as a tangent stores them."""
    blocks = sp.bsr_matrix(dense, blocksize=(3, 3))
    blocks.sort_indices()
    matrix = PETSc.Mat().create(MPI.COMM_SELF)
    matrix.setSizes((dense.shape, dense.shape), bsize=3)
    matrix.setType(PETSc.Mat.Type.SBAIJ)
    matrix.setOption(PETSc.Mat.Option.IGNORE_LOWER_TRIANGULAR, True)
    matrix.setPreallocationNNZ(NODES)
    matrix.setOption(PETSc.Mat.Option.IGNORE_LOWER_TRIANGULAR, True)
    matrix.setValuesBlockedCSR(
        blocks.indptr.astype(PETSc.IntType), blocks.indices.astype(PETSc.IntType), blocks.data
    )
    matrix.assemble()
    return matrix


def assert_solves(
    inverse: Exact, matrix: PETSc.Mat, dense: np.ndarray, negative: int, rng: np.random.Generator
) -> None:
    """Two random right-hand sides at once to rounding, one as far as needed; eigenvalues.

    The preconditioner is in single precision, whose rounding is 6e-8.
    """
    right = rng.uniform(-1, 1, (len(dense), 2))
    exact = np.linalg.solve(dense, right)
    one, found = matrix.createVecs()
    one.array[:] = right[:, 0]
    inverse.solve(one, found, 1e-6)
    assert np.allclose(found.array_r, exact[:, 0], rtol=0, atol=1e-5 * abs(exact).max())
    inverse.pc.apply(one, found)
    assert np.allclose(found.array_r, exact[:, 0], rtol=0, atol=1e-4 * abs(exact).max())
    many = inverse.solve_many(right)
    assert np.allclose(many, exact, rtol=0, atol=1e-10 * abs(exact).max())
    assert (inverse.negative, inverse.failed) == (negative, 0)


def test_any_matrix_is_solved_for_and_only_definite_ones_have_no_negative_pivots() -> None:
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    inverse = Cholesky(MPI.COMM_SELF, lambda: Factorisation("test_any_sign_", MPI.COMM_SELF))
    near, far = chain(2), chain(5)
    eigenvalues = np.linalg.eigvalsh(near)
    lowered = near - (eigenvalues[6] + eigenvalues[7]) / 2 * np.eye(len(near))
    matrix, wider = tangent(near), tangent(far)
    # one matrix whose values change and come back, then another pattern
    for which, dense, negative in (
        (matrix, near, 0), (matrix, lowered, 7), (matrix, near, 0), (wider, far, 0),
    ):  # fmt: skip
        difference = np.diag(dense) - which.getDiagonal().array_r
        which.setDiagonal(PETSc.Vec().createWithArray(difference, comm=MPI.COMM_SELF), addv=True)
        which.assemble()
        inverse.set_up(which)
        assert_solves(inverse, which, dense, negative, rng)


def test_indefinite_matrices_in_a_row_are_left_to_ldlt(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a grasp: ever fewer tries of Cholesky, yet a definite matrix is found again."""
    tries = 0
    factorise = cholmod.CholmodFactors.factorise

    def counted(factors: cholmod.CholmodFactors) -> bool:
        nonlocal tries
        tries += 1
        return factorise(factors)

    monkeypatch.setattr(cholmod.CholmodFactors, "factorise", counted)
    inverse = Cholesky(
        MPI.COMM_SELF, lambda: Factorisation("test_left_", MPI.COMM_SELF), np.float64
    )
    definite = chain(2)
    matrix, dense = tangent(definite), definite - 2 * np.eye(len(definite)) * definite.max()
    matrix.setDiagonal(PETSc.Vec().createWithArray(np.diag(dense), comm=MPI.COMM_SELF))
    matrix.assemble()
    tried = []
    for _ in range(8):
        before = tries
        inverse.set_up(matrix)
        assert inverse.negative > 0
        tried.append(tries > before)
    # a first one says nothing; then as many are left out as were refused in a row
    assert tried == [True, True, False, True, False, False, False, True]
    matrix.setDiagonal(PETSc.Vec().createWithArray(np.diag(definite), comm=MPI.COMM_SELF))
    matrix.assemble()
    for _ in range(MOST_SKIPPED + 1):
        inverse.set_up(matrix)
    assert inverse.negative == 0
    rng = np.random.default_rng(SEED)
    assert_solves(inverse, matrix, definite, 0, rng)


def test_factors_of_an_earlier_matrix_serve_derivatives() -> None:
    """By conjugate gradients, without factorising; a matrix far away by its own factors."""
    print("seed", SEED)
    rng = np.random.default_rng(SEED)
    counts = Counts()
    inverse = Cholesky(MPI.COMM_SELF, lambda: Factorisation("test_near_", MPI.COMM_SELF))
    factors = Factors("test_near_factors_", inverse, FactorPolicy(), counts)
    first = chain(2)
    matrix, right = tangent(first), rng.uniform(-1, 1, (len(first), 4))
    for more, near, factorised, allowed in (
        (0.0, True, 1, 1e-10), (0.3, True, 1, 1e-6), (0.3, False, 2, 1e-10), (1e4, True, 3, 1e-10),
    ):  # fmt: skip
        dense = first + np.diag(more * rng.uniform(0, 1, len(first)))
        matrix.setDiagonal(PETSc.Vec().createWithArray(np.diag(dense), comm=MPI.COMM_SELF))
        factors.take(matrix, near=near)
        error = abs(factors.solve_many(right) - np.linalg.solve(dense, right)).max()
        assert error < allowed * abs(np.linalg.solve(dense, right)).max()
        assert counts.factorisations == factorised
