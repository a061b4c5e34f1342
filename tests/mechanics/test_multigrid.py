"""Multigrid of the quadratic and the linear element: its parts, and whole runs against factors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
import scipy.sparse as sp
from mpi4py import MPI
from petsc4py import PETSc
from support import bodies, small

from dolfingrip import config
from dolfingrip.config import ConfigError, Solver
from dolfingrip.experiments import run
from dolfingrip.mechanics.newton.ending import Counts
from dolfingrip.mechanics.newton.factors import Factors
from dolfingrip.mechanics.newton.inverse import Factorisation
from dolfingrip.mechanics.newton.multigrid import LinearLevel, Multigrid
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.newton.policy import FactorPolicy
from dolfingrip.mechanics.newton.tangent import Tangent

SEED = 3
EXACT = ("solver.rtol=1e-11", "solver.atol_N=1e-11")


def whole(matrix: PETSc.Mat) -> np.ndarray:
    """A symmetric matrix of which the upper triangle is stored."""
    matrix.setOption(PETSc.Mat.Option.GETROW_UPPERTRIANGULAR, True)
    pointer, columns, values = matrix.getValuesCSR()
    upper = np.triu(sp.csr_matrix((values, columns, pointer), matrix.getSize()).toarray())
    return np.asarray(upper + np.triu(upper, 1).T)


def scalars(matrix: PETSc.Mat) -> np.ndarray:
    pointer, columns, values = matrix.getValuesCSR()
    return sp.csr_matrix((values, columns, pointer), matrix.getSize()).toarray()


@pytest.fixture
def cube() -> bodies.Body:
    """The hollow cube of quadratic tetrahedra on its clamp, and one component held elsewhere."""
    made = bodies.body(bodies.hollow_cube(), 2)
    made.hold(bodies.plane(2, 0.0))
    made.hold(bodies.plane(1, 0.0), 1)
    return made


def test_interpolation_is_that_of_linear_functions(cube: bodies.Body) -> None:
    """u = A x, where no support holds a node or an end of its edge."""
    rng = np.random.default_rng(SEED)
    print("seed", SEED)
    slope = rng.uniform(-1, 1, (3, 3))
    level = LinearLevel(cube.model)
    corners = np.empty((level.interpolation.getSize()[1] // 3, 3))
    parents = level.parents
    same = parents[:, 0] == parents[:, 1]
    corners[parents[same, 0]] = cube.nodes[same] @ slope.T
    values = scalars(level.interpolation) @ corners.ravel()
    free = cube.nodes[:, 2] > 1.0 + 1e-9  # by a cell above the clamp
    free &= cube.nodes[:, 1] > 1.0 + 1e-9
    np.testing.assert_allclose(
        values.reshape(-1, 3)[free], (cube.nodes @ slope.T)[free], atol=1e-13
    )


def test_its_tangent_is_the_projection_of_the_tangent(cube: bodies.Body) -> None:
    """PᵀKP by dense products, at a state with pressure; 1 on the diagonal of supports."""
    rng = np.random.default_rng(SEED)
    cube.displace(0.02 * rng.uniform(-1, 1, cube.nodes.shape))
    cube.pressure.value = 0.01
    tangent = cube.tangent()
    level = LinearLevel(cube.model)
    coarse, diagonal = level.assemble(tangent)
    fine, p = whole(tangent), scalars(level.interpolation)
    held = np.diag((~p.any(axis=0)).astype(float))
    np.testing.assert_allclose(whole(coarse), p.T @ fine @ p + held, atol=1e-12)
    blocks = fine.reshape(len(fine) // 3, 3, -1, 3)
    expected = blocks[np.arange(len(blocks)), :, np.arange(len(blocks))]
    np.testing.assert_allclose(diagonal, expected, atol=1e-15)


class _Wrong:
    """An inverse that is none: GMRES with it does not converge."""

    exact = False
    negative = 0
    failed = 0

    def __init__(self) -> None:
        self.pc = PETSc.PC().create(MPI.COMM_SELF)
        self.pc.setType(PETSc.PC.Type.NONE)

    def set_up(self, matrix: PETSc.Mat) -> None:
        self.pc.setOperators(matrix)


def test_factors_take_the_place_of_what_does_not_converge(cube: bodies.Body) -> None:
    matrix = cube.tangent()
    factors = Factors(
        "test_",
        _Wrong(),
        FactorPolicy(fresh=3),
        Counts(),
        spare=lambda: Factorisation("test_spare_", MPI.COMM_SELF),
    )
    solver = PETSc.KSP().create(MPI.COMM_SELF)
    solver.setType(PETSc.KSP.Type.PREONLY)
    solver.getPC().setType(PETSc.PC.Type.PYTHON)
    solver.getPC().setPythonContext(factors)
    solver.setOperators(matrix)
    right, solution = matrix.createVecs()
    right.array[:] = np.random.default_rng(SEED).uniform(-1, 1, right.local_size)
    solver.solve(right, solution)
    np.testing.assert_allclose(whole(matrix) @ solution.array, right.array, atol=1e-10)


def test_it_sees_a_tangent_that_is_indefinite() -> None:
    """A column of 1 × 1 × 8 mm, shortened by 3 %, ten times what it buckles at."""
    solid = bodies.domain(bodies.box((1, 1, 8), (1.0, 1.0, 8.0)), {"clamp": bodies.plane(2, 0.0)})
    column = bodies.body(solid, 2)
    column.hold(bodies.plane(2, 0.0))
    column.displace(column.nodes * [0.0, 0.0, -0.03])
    matrix = column.tangent()
    direct = Factorisation("test_direct_", MPI.COMM_SELF, counts_pivots=True)
    direct.set_up(matrix)
    grid = Multigrid("test_grid_", column.model)
    grid.set_up(matrix)
    print("negative eigenvalues", direct.negative, grid.negative)
    assert 0 < grid.negative <= direct.negative


CASES = {
    "tetrahedra": ("bending", ("solver.element=P2", "mesh.size_mm=6")),
    "hexahedra": ("bending", ()),
    "contact": (
        "blocked_force",
        ("finger.gap_mm=0.4", "experiment.max_pressure_kPa=150", "experiment.step_kPa=75"),
    ),
    "friction": ("blocked_force", ("extensions.plate_friction={}", "finger.gap_mm=0.4")),
    "springs": ("blocked_force", ("extensions.clamp_compliance={}",)),
    "volume": ("bending", ("experiment.control=volume", "experiment.max_volume_ratio=1.1")),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_run_is_the_direct_solver_s(case: str) -> None:
    """To 1e-8 of the largest reading of each column; Newton's iterations are no more."""
    experiment, overrides = CASES[case]

    def readings(linear: str) -> tuple[dict[str, np.ndarray], int]:
        settings = small.short(*EXACT, *overrides, f"solver.linear={linear}")
        result = run(experiment, settings, comm=MPI.COMM_SELF)
        assert result.failure is None
        assert result.facts.newton.linear_solver == linear
        names = ("angle_deg", "tip_x_mm", "tip_z_mm", "cavity_volume_mm3", "force_N")
        had = result.columns()
        return {name: result.column(name) for name in names if name in had}, int(
            result.column("iterations").sum()
        )

    (direct, most), (iterative, count) = readings("direct"), readings("iterative")
    print("iterations", most, count)
    for name, values in direct.items():
        if np.isfinite(values).any():
            np.testing.assert_allclose(
                iterative[name], values, rtol=0, atol=1e-8 * np.nanmax(np.abs(values)), err_msg=name
            )
    assert count <= most


def test_a_damped_solve_reaches_the_same_state(cube: bodies.Body) -> None:
    """Conjugate gradients on the damped tangent."""
    found = []
    for linear in ("direct", "iterative"):
        cube.displace(np.zeros_like(cube.nodes))
        cube.model.prescribe({"pressure_kPa": 40.0})
        solve = Newton(cube.model, Solver(rtol=1e-11, linear=linear)).solve(damped=True)
        assert solve.converged
        found.append(cube.displacement())
    np.testing.assert_allclose(found[1], found[0], atol=1e-9 * np.abs(found[0]).max())


@pytest.mark.parametrize(
    ("overrides", "said"),
    [
        (
            ("solver.element=P1", "solver.linear=iterative"),
            'solver.linear = "iterative": allowed: with elements P2 and S2',
        ),
        (("solver.memory_GB=0.01",), "mesh: 3,420 unknowns take about "),
    ],
)
def test_what_will_not_do_is_refused_in_one_line(overrides: Sequence[str], said: str) -> None:
    finger = small.model(small.short(*overrides), plate=False)
    with pytest.raises(ConfigError) as error:
        Newton(finger.model, finger.config.solver)
    assert str(error.value).startswith(said)
    assert "\n" not in str(error.value)
    print(error.value)


def test_the_choice_is_by_size() -> None:
    """A small model is factorised."""
    finger = small.model(small.short(), plate=False)
    newton = Newton(finger.model, config.Solver())
    assert not newton.linear_solver.iterative
    assert newton.linear_solver.forecast_MB > 0
    assert isinstance(newton.tangent, Tangent)
