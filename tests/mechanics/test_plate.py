"""The plate as a sum over points is the integral of its barrier at the nodes."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem import petsc as fem_petsc
from support import bodies, small

from dolfingrip.forms import plate as form
from dolfingrip.mechanics.contact.plate import RigidPlate
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.unknowns import Gradient

SEED = 29


def on_tetrahedra() -> tuple[Model, RigidPlate]:
    body = bodies.body(bodies.hollow_cube(), 2)
    return body.model, body.plate


def on_hexahedra() -> tuple[Model, RigidPlate]:
    finger = small.model(small.short("plate.barrier_mm=0.5", "plate.tilt_deg=10"), plate=True)
    assert finger.plate is not None
    return finger.model, finger.plate


@pytest.mark.parametrize("build", [on_tetrahedra, on_hexahedra])
def test_sum_over_points_is_the_integral(build: object) -> None:
    """Energy, gradient, Hessian and force to rounding, nodes in both stages of the barrier."""
    print("seed", SEED)
    model, plate = build()  # type: ignore[operator]
    u, mesh = model.u, model.domain.mesh
    rng = np.random.default_rng(SEED)
    u.x.array[:] = 0.3 * plate.width_mm * rng.uniform(-1, 1, u.x.array.shape)
    plate.offset.value += plate.gap_mm() - 0.1 * plate.width_mm
    dofs = u.x.array
    gaps = plate.gaps_mm(dofs) / plate.width_mm
    assert (gaps < 0.5).any()
    assert ((gaps > 0.5) & (gaps < 1)).any()
    position = ufl.variable(plate.offset)
    normal = fem.Constant(mesh, plate.normal)
    gap = form.distance(u, mesh, normal, position)
    width, stiffness = (
        fem.Constant(mesh, value) for value in (plate.width_mm, plate.density.stiffness_MPa)
    )
    density = form.energy(gap, width, stiffness)
    energy = density * plate.measure
    assert plate.value(dofs) == pytest.approx(fem.assemble_scalar(fem.form(energy)), rel=1e-12)
    force = fem.assemble_scalar(fem.form(ufl.diff(density, position) * plate.measure))
    assert plate.force_N() == pytest.approx(model.domain.copies * force, rel=1e-12)

    slope = ufl.derivative(energy, u, ufl.TestFunction(u.function_space))
    expected = fem.assemble_vector(fem.form(slope)).array
    found = Gradient(model.unknowns)
    plate.add_gradient(dofs, found)
    scale = np.abs(expected).max()
    np.testing.assert_allclose(found.array, expected, rtol=0, atol=1e-12 * scale)

    curve = ufl.derivative(slope, u, ufl.TrialFunction(u.function_space))
    matrix = fem_petsc.assemble_matrix(fem.form(curve))
    matrix.assemble()
    w, product = matrix.createVecs()
    w.array[:] = rng.uniform(-1, 1, dofs.shape)
    matrix.mult(w, product)
    (coupling,) = plate.couplings(dofs)
    places = (3 * coupling.nodes[:, None] + np.arange(3)).ravel()
    own = np.zeros_like(dofs)
    own[places] = coupling.hessian @ w.array[places]
    scale = np.abs(product.array).max()
    np.testing.assert_allclose(own, product.array, rtol=0, atol=1e-12 * scale)
