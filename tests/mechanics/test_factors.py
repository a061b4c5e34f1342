"""Factors that serve more than one matrix: exact solves, iterative ones, failures."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc

from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.factors import Factors
from dolfingrip.mechanics.newton.inverse import Factorisation
from dolfingrip.mechanics.newton.policy import FactorPolicy
from dolfingrip.mechanics.newton.symmetric import symmetric

SEED = 5
SIZE = 400


class System:
    """K x = b with K = a band of ones and twos, changed at will, solved once by its factors."""

    def __init__(self) -> None:
        print("seed", SEED)
        self.rng = np.random.default_rng(SEED)
        self.matrix = self.band(np.full(SIZE, 3.0))
        self.counts = Counts()
        self.factors = Factors(
            "test_factors_",
            Factorisation("test_factors_", MPI.COMM_SELF),
            FactorPolicy(),
            self.counts,
        )
        self.ksp = PETSc.KSP().create(MPI.COMM_SELF)
        self.ksp.setType(PETSc.KSP.Type.PREONLY)
        self.ksp.getPC().setType(PETSc.PC.Type.PYTHON)
        self.ksp.getPC().setPythonContext(self.factors)
        self.right = PETSc.Vec().createWithArray(self.rng.uniform(-1, 1, SIZE), comm=MPI.COMM_SELF)

    @staticmethod
    def band(diagonal: np.ndarray) -> PETSc.Mat:
        upper = sp.diags_array([diagonal, np.ones(SIZE - 1)], offsets=[0, 1]).tocsr()
        return symmetric(sp.csr_matrix(upper), MPI.COMM_SELF)

    def stiffen(self, values: np.ndarray) -> None:
        """Add to the diagonal."""
        self.matrix.setDiagonal(PETSc.Vec().createWithArray(3.0 + values, comm=MPI.COMM_SELF))

    def error(self) -> float:
        """Solve, and compare with SciPy; the largest difference by the largest value."""
        solution = self.right.duplicate()
        self.ksp.setOperators(self.matrix)
        self.ksp.solve(self.right, solution)
        diagonal = self.matrix.getDiagonal().array_r
        ones = np.ones(SIZE - 1)
        whole = sp.diags_array([ones, diagonal, ones], offsets=[-1, 0, 1]).tocsc()
        exact = sp.linalg.spsolve(whole, self.right.array_r)
        return float(abs(solution.array_r - exact).max() / abs(exact).max())


@pytest.fixture
def system() -> System:
    return System()


def test_its_own_factors_solve_exactly(system: System) -> None:
    assert system.error() < 1e-12
    assert system.error() < 1e-12
    assert system.counts.factorisations == 1


def test_factors_serve_a_matrix_near_by(system: System) -> None:
    """Solved to the tolerance without factorising."""
    system.error()
    system.stiffen(system.rng.uniform(0, 0.03, SIZE))
    assert 1e-12 < system.error() < 100 * FactorPolicy().rtol
    assert system.counts.factorisations == 1


def test_a_matrix_far_away_is_factorised(system: System) -> None:
    system.error()
    system.stiffen(system.rng.uniform(0, 300, SIZE))
    assert system.error() < 1e-12
    assert system.counts.factorisations == 2


def test_renewed_factors_are_the_matrix_own(system: System) -> None:
    system.error()
    system.stiffen(system.rng.uniform(0, 0.03, SIZE))
    system.factors.renew()
    assert system.error() < 1e-12
    assert system.counts.factorisations == 2


def test_factors_serve_a_matrix_of_another_pattern(system: System) -> None:
    """As where pairs touch that no element joins; one far away is factorised."""
    system.error()
    factorised = system.matrix
    system.matrix = System.band(np.full(SIZE, 3.03))
    assert 1e-12 < system.error() < 100 * FactorPolicy().rtol
    assert system.counts.factorisations == 1
    assert system.matrix != factorised
    system.matrix = System.band(system.rng.uniform(3, 300, SIZE))
    assert system.error() < 1e-12
    assert system.counts.factorisations == 2


def test_a_singular_matrix_is_reported(system: System) -> None:
    system.stiffen(np.full(SIZE, -3.0))
    system.matrix.scale(0.0)
    system.ksp.setOperators(system.matrix)
    system.ksp.solve(system.right, system.right.duplicate())
    assert system.ksp.getConvergedReason() == PETSc.KSP.ConvergedReason.DIVERGED_PCSETUP_FAILED


class HalfBlind:
    """An approximate inverse that hardly sees half of the residual."""

    exact = False
    negative = failed = 0

    def __init__(self) -> None:
        self.pc = PETSc.PC().create(MPI.COMM_SELF)
        self.pc.setType(PETSc.PC.Type.PYTHON)
        self.pc.setPythonContext(self)

    def set_up(self, matrix: PETSc.Mat) -> None:
        self.pc.setOperators(matrix)

    def apply(self, pc: PETSc.PC, right: PETSc.Vec, solution: PETSc.Vec) -> None:
        solution.array[:] = right.array_r * np.where(np.arange(SIZE) < SIZE // 2, 0.3, 1e-12)


def test_solutions_that_leave_too_much_are_those_of_factors(system: System) -> None:
    """GMRES' own residual falls to its tolerance, that of the equations does not."""
    factors = Factors(
        "test_blind_",
        HalfBlind(),
        FactorPolicy(),
        system.counts,
        spare=lambda: Factorisation("test_spare_", MPI.COMM_SELF),
    )
    factors.take(system.matrix, near=False)
    right = system.rng.uniform(-1, 1, (SIZE, 2))
    found = factors.solve_many(right)
    ones = np.ones(SIZE - 1)
    whole = sp.diags_array([ones, np.full(SIZE, 3.0), ones], offsets=[-1, 0, 1])
    assert abs(whole @ found - right).max() < 1e-12
    assert system.counts.factorisations == 2  # the approximate inverse counts, too


def test_nothing_is_told_of_a_solver_that_was_not_used() -> None:
    """As in a run in which nothing moves: PETSc tells of options of no use at its end."""
    code = (
        "from mpi4py import MPI\n"
        "from dolfingrip.mechanics.newton.inverse import Factorisation\n"
        "Factorisation('unused_', MPI.COMM_SELF)\n"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120
    )
    assert (ended.stdout, ended.stderr) == ("", "")
