"""The velocity of a distributed mesh's points by ξ1 and ξ2."""

from __future__ import annotations

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx import io as dolfinx_io
from mpi4py import MPI

from dolfingrip.config import Finger, Mesh
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.mechanics.model.morph import velocity
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.morph import Morph, second_order_edges

MORPH = Morph(0.4, -0.3, 9.5)


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


def move(domain: Domain, morph: Morph) -> None:
    """Morph the points of a domain's mesh in place."""
    geometry = domain.mesh.geometry
    own = np.asarray(geometry.dofmap, dtype=np.int64)
    order = dolfinx_io.gmshio.cell_perm_array(domain.mesh.topology.cell_type, own.shape[1])
    geometry.x[:] = morph.points(geometry.x, second_order_edges(own[:, np.argsort(order)]))


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
