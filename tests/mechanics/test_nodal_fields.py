"""Fields at the nodes against closed forms of a bar, and against the force of the plate."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI
from support import small

from dolfingrip import config
from dolfingrip.channels import INSIDE
from dolfingrip.experiments import run
from dolfingrip.experiments.results.fields import FieldFile
from dolfingrip.mechanics.readings.nodal_fields import (
    CavityPressure,
    ContactPressure,
    Nodes,
    PrincipalStretch,
)
from dolfingrip.mechanics.readings.principal import largest_eigenvalue
from dolfingrip.report.fields import list_steps, read_grid, read_steps


@pytest.mark.parametrize("element", [None, "P2-P1"])
def test_a_bar_has_its_closed_form(element: str | None, tmp_path: Path) -> None:
    """σ = λ P, and ψ = μ/2 (λ² + 2/λ − 3) of an incompressible neo-Hookean bar."""
    settings = config.load(
        None,
        {
            "material.nu": 0.4999, "solver.element": element,
            "protocol.time_s": [0.0, 1.0], "protocol.displacement_mm": [0.0, 20.0],
        },
    )  # fmt: skip
    result = run("coupon", settings, out=tmp_path, comm=MPI.COMM_SELF)
    stretch = 1 + result.column("nominal_strain")
    stress = result.column("nominal_stress_MPa")
    _, _, found = read_steps(list_steps(tmp_path / "fields.pvd"))
    mu = settings.material.shear_MPa
    for row in (0, -1):
        x, p = stretch[row], stress[row]
        energy = mu / 2 * (x**2 + 2 / x - 3)
        for name, expected in (
            ("stretch", x), ("mises", x * p), ("stress", x * p), ("energy", energy)
        ):  # fmt: skip
            values = found[name][row]
            assert values == pytest.approx(np.full(len(values), expected), rel=2e-3, abs=1e-5), name
        assert not found["contact"][row].any()
    assert stretch[-1] > 1.2


def test_contact_pressure_has_the_force_of_the_plate() -> None:
    """The integral of the pressure over the deformed skin is the plate's force; else it is 0."""
    finger = small.model(small.short(), plate=True)
    model, plate = finger.model, finger.plate
    assert plate is not None
    nodes = Nodes(fem.functionspace(model.domain.mesh, ("Lagrange", 2)))
    contact = ContactPressure(model, nodes)
    plate.retract()
    assert not contact.at_vertices()[0].any()
    plate.put()
    for _ in small.pressurise(finger, [40.0]):
        pressure, area = contact.at_vertices()
    force = model.domain.copies * (pressure[:, None] * area).sum(axis=0) @ -plate.normal
    print("force of the pressure", force, "plate", plate.force_N())
    assert plate.force_N() > 0.1
    # forces of bellows on one another add up to little, and an edge's pressure acts on both faces
    assert force == pytest.approx(plate.force_N(), rel=0.02)
    (values,) = contact.values().values()
    assert values.max() == pytest.approx(1e3 * pressure.max(), rel=1e-6)


def test_chamber_walls_have_the_pressure_of_their_cavity() -> None:
    """Its mean over the walls is the cavity's share of the supply; over the skin it is 0."""
    settings = small.short().changed(cavity={"cavity": {"pressure_ratio": 0.5}})
    finger = small.model(settings, plate=False)
    domain = finger.model.domain
    field = fem.Function(fem.functionspace(domain.mesh, ("Lagrange", 2)))
    inside = CavityPressure(finger.pressures, finger.model, Nodes(field.function_space))
    for _ in small.pressurise(finger, [20.0]):
        field.x.array[:] = inside.values()[INSIDE.array]
    for name, expected in (("cavity", 10.0), ("skin", 0.0)):
        on = domain.surface(name)
        area = fem.assemble_scalar(fem.form(fem.Constant(domain.mesh, 1.0) * on))
        mean = fem.assemble_scalar(fem.form(field * on)) / area
        assert mean == pytest.approx(expected, abs=1e-9), name
    assert not CavityPressure({}, finger.model, Nodes(field.function_space)).values()


def test_the_largest_eigenvalue_is_that_of_lapack() -> None:
    """Also of equal and nearly equal eigenvalues, where a closed form loses digits."""
    generator = np.random.default_rng(75)
    print("seed 75")
    turns = np.linalg.qr(generator.standard_normal((400, 3, 3)))[0]
    values = generator.standard_normal((400, 3))
    values[:100, 1] = values[:100, 0]  # two are equal
    values[100:200] = values[100:200, :1] + 1e-9 * values[100:200]  # all are, nearly
    values[200:210] = 0.0
    tensors = turns @ (values[:, :, None] * turns.swapaxes(-1, -2))
    tensors = (tensors + tensors.swapaxes(-1, -2)) / 2
    expected = np.linalg.eigvalsh(tensors)[:, -1]
    np.testing.assert_allclose(largest_eigenvalue(tensors), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("element", ["S2", "P1"])
def test_the_file_has_the_fields_to_the_last_bit(element: str, tmp_path: Path) -> None:
    """Each array of a step is the one that was computed, at the node with these coordinates."""
    finger = small.model(small.short(f"solver.element={element}"), plate=False)
    model = finger.model
    model.u.interpolate(lambda x: np.stack([0.01 * x[0], 0.02 * x[2], -0.03 * x[1]]))
    degree = model.u.function_space.ufl_element().degree
    space = fem.functionspace(model.domain.mesh, ("Lagrange", degree))
    stretch = PrincipalStretch(model.u, Nodes(space)).values()["principal_stretch"]
    fields = FieldFile(model, tmp_path / "fields.pvd", finger.pressures)
    for time_s in (0.0, 1.0):
        fields.write(time_s)
    first, second = list_steps(tmp_path / "fields.pvd")
    assert [first.name, second.name] == ["fields000000.pvtu", "fields000001.pvtu"]
    grid = read_grid(second)
    x = np.asarray(grid.points)
    np.testing.assert_array_equal(x, space.tabulate_dof_coordinates())
    np.testing.assert_array_equal(grid["principal_stretch"], stretch)
    moved = np.stack([0.01 * x[:, 0], 0.02 * x[:, 2], -0.03 * x[:, 1]], axis=1)
    np.testing.assert_allclose(grid["displacement_mm"], moved, rtol=0, atol=1e-12)
    mesh, _, _ = read_steps([second])
    assert len(mesh.cells) == grid.n_cells == model.domain.mesh.topology.index_map(3).size_local
