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
from dolfingrip.mechanics.readings.nodal_fields import CavityPressure, ContactPressure, Nodes
from dolfingrip.report.fields import list_steps, read_steps


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
