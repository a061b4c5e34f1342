"""The morph of a dolfinx mesh in memory is that of the mesh it was made from."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfingrip.config import Finger, Mesh
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.mechanics.model.morph import move, velocity
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.morph import Morph, morphed
from dolfingrip.meshes.solid import MeshError, SolidMesh

MORPH = Morph(0.4, -0.3, 9.5)


@pytest.fixture(scope="module", params=[1, 2])
def solid(request: pytest.FixtureRequest) -> SolidMesh:
    return finger_mesh(Finger(), Mesh(size_mm=10, order=request.param))


@pytest.fixture(params=["tetrahedra", "quadratic tetrahedra", "hexahedra"])
def domain(request: pytest.FixtureRequest) -> Domain:
    """The finger, or hexahedra of which some straddle the plane between the regions."""
    if request.param != "hexahedra":
        order = 2 if "quadratic" in request.param else 1
        return distribute(MPI.COMM_SELF, finger_mesh(Finger(), Mesh(size_mm=10, order=order)))
    box = mesh.create_box(
        MPI.COMM_SELF, [[0, 0, 0], [20, 10, 9]], [6, 2, 3], mesh.CellType.hexahedron
    )
    return Domain(box, {}, half=True)


def test_points_move_and_come_back(domain: Domain) -> None:
    original = domain.mesh.geometry.x.copy()
    move(domain, MORPH)
    if domain.mesh.geometry.cmap.degree == 1:
        assert np.abs(domain.mesh.geometry.x - MORPH.points(original)).max() < 1e-13
    move(domain, MORPH.inverse())
    assert np.abs(domain.mesh.geometry.x - original).max() < 1e-13


def test_in_place_is_as_on_the_file(solid: SolidMesh) -> None:
    domain = distribute(MPI.COMM_SELF, solid)
    move(domain, MORPH)
    # geometry.x is ordered anew by distribute, in the same way both times
    expected = distribute(MPI.COMM_SELF, morphed(solid, MORPH)).mesh.geometry.x
    assert np.abs(domain.mesh.geometry.x - expected).max() < 1e-13


def test_inversion_is_refused_and_changes_nothing(domain: Domain) -> None:
    original = domain.mesh.geometry.x.copy()
    with pytest.raises(MeshError, match=r"xi1 = -1\.5, xi2 = 0: turns"):
        move(domain, Morph(-1.5, 0.0, 9.5))
    np.testing.assert_array_equal(domain.mesh.geometry.x, original)


def test_velocity_gives_the_volume_s_derivative(domain: Domain) -> None:
    """d/dξ ∫dx = ∫div(v) dx; the volume is linear in ξ, so differences are exact."""
    move(domain, MORPH)

    def integral(density: ufl.core.expr.Expr | float) -> float:
        return float(fem.assemble_scalar(fem.form(density * ufl.dx(domain.mesh))))

    one = fem.Constant(domain.mesh, 1.0)
    slopes = [integral(ufl.div(field)) for field in velocity(domain, MORPH)]
    before = integral(one)
    move(domain, MORPH.inverse())
    for i, slope in enumerate(slopes):
        xi = [MORPH.xi1, MORPH.xi2]
        xi[i] += 0.1
        there = Morph(xi[0], xi[1], 9.5)
        move(domain, there)
        assert (integral(one) - before) / 0.1 == pytest.approx(slope, rel=1e-9)
        move(domain, there.inverse())
