"""The finger's model as a whole: half and whole agree, and its tangent is symmetric."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from petsc4py import PETSc
from scipy.spatial import cKDTree
from support import bodies, fingers
from support.paths import by_pressure

from dolfingrip.config import KPA
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.forms.kinematics import current_area_vector
from dolfingrip.mechanics.model import jit
from dolfingrip.mechanics.newton.newton import Newton

PRESSURE_KPA = 100.0


def pressurised(*, half: bool, gap_mm: float) -> FingerModel:
    """A finger at 100 kPa."""
    mesh = fingers.half_mesh()
    solid = fingers.on_domain(mesh if half else fingers.mirrored(mesh))
    finger = fingers.build(solid, gap_mm)
    path = by_pressure(Newton(finger.model, finger.config.solver))
    assert path.advance({"pressure_kPa": PRESSURE_KPA}).failure is None
    return finger


def nodes_and_displacement(finger: FingerModel) -> tuple[np.ndarray, np.ndarray]:
    """Positions and displacements of the nodes (mm), (n, 3) each."""
    u = finger.model.u
    return u.function_space.tabulate_dof_coordinates(), u.x.array.reshape(-1, 3)


@pytest.mark.parametrize("gap_mm", [bodies.FAR, 0.0], ids=["free", "blocked"])
def test_half_is_whole(gap_mm: float) -> None:
    """On mirrored meshes the half's displacement is the whole's, and so is the plate's force.

    Both discrete problems have the same solution, so they differ by Newton's tolerance alone.
    """
    half, whole = (pressurised(half=half, gap_mm=gap_mm) for half in (True, False))
    nodes, u = nodes_and_displacement(half)
    all_nodes, all_u = nodes_and_displacement(whole)
    for sign in (1, -1):
        distance, twin = cKDTree(all_nodes).query(nodes * [1, sign, 1])
        assert distance.max() < 1e-9
        np.testing.assert_allclose(all_u[twin] * [1, sign, 1], u, atol=1e-8)
    assert np.abs(u).max() > 1.0
    assert half.plate is not None
    assert whole.plate is not None
    forces = half.plate.force_N(), whole.plate.force_N()
    print("largest displacement", np.abs(u).max(), "forces", forces)
    assert forces[0] == pytest.approx(forces[1], rel=1e-8)
    assert (forces[0] > 1.0) == (gap_mm == 0.0)


@pytest.fixture(scope="module")
def blocked() -> FingerModel:
    """The half finger against the plate."""
    return pressurised(half=True, gap_mm=0.0)


def test_tangent_is_symmetric(blocked: FingerModel) -> None:
    """A pressurised, bent, blocked finger has a symmetric tangent, as its loads are conservative.

    What is factorised as LDLᵀ must be so to round-off.
    """
    model = blocked.model
    model.potential.carried.reset()
    matrix = fem_petsc.assemble_matrix(model.potential.tangent, bcs=model.supports)
    matrix.assemble()
    skew = matrix - matrix.transpose(PETSc.Mat())
    print("skew part", skew.norm() / matrix.norm())
    assert skew.norm() < 1e-12 * matrix.norm()


def test_pressure_is_a_follower(blocked: FingerModel) -> None:
    """The potential −p V pushes each free node as the traction −p n does on the bent cavity.

    It may differ where the cavity ends on the symmetry plane, in the direction that is held
    there, and nowhere else (Bonet & Wood, section 8.5.2).
    """
    model, u = blocked.model, blocked.model.u
    before = model.state()
    pushes = []
    for pressure in (PRESSURE_KPA, 0.0):
        model.prescribe({"pressure_kPa": pressure})
        pushes.append(model.reactions().ravel())
    model.restore(before)

    normal = ufl.FacetNormal(model.domain.mesh)
    v = ufl.TestFunction(u.function_space)
    traction = ufl.inner(current_area_vector(u, normal), v) * model.domain.surface(
        "cavity", quadrature_degree=4
    )
    follower = (
        PRESSURE_KPA
        * KPA
        * fem_petsc.assemble_vector(fem.form(traction, jit_options=jit.options())).array
    )
    difference = np.abs(pushes[0] - pushes[1] - follower)
    held = np.unique(np.concatenate([bc.dof_indices()[0] for bc in model.supports]))
    assert difference[held].max() > 1e-3 * np.abs(follower).max()
    difference[held] = 0.0
    print("largest difference", difference.max(), "of", np.abs(follower).max())
    assert difference.max() < 1e-12 * np.abs(follower).max()


def test_clamp_balances_plate(blocked: FingerModel) -> None:
    """The clamp's reaction along x is the plate's force, as the cavity is closed.

    Free rows of the gradient vanish, and neither the pressure nor the symmetry plane pushes
    along x on the whole: the sum over all rows is the clamp's. The half's is doubled.
    """
    reaction = 2 * blocked.model.reactions()[:, 0].sum()
    assert blocked.plate is not None
    print("reaction", reaction, "plate", blocked.plate.force_N())
    assert reaction == pytest.approx(-blocked.plate.force_N(), rel=1e-9)
