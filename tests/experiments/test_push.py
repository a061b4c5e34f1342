"""The tip's stiffness against beam theory, finite loads and symmetry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support import bodies, small
from support.paths import by_pressure

from dolfingrip import config
from dolfingrip.experiments import push, run
from dolfingrip.experiments.rigs import tip_load
from dolfingrip.experiments.rigs.finger import FingerModel, build
from dolfingrip.experiments.rigs.undeformed import load_domain, solid
from dolfingrip.mechanics.model.model import Control
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.mechanics.path.path import LoadPath
from dolfingrip.mechanics.readings.tip import TipDisplacement
from dolfingrip.meshes import files
from dolfingrip.sections.tables import assignments

X, Y = COLUMNS = [each.name for each in push.Push.columns]
EVEN = ("mesh.size_mm=4.2", "mesh.edge_size_mm=4.2")
"""Elements that lie alike on both sides of y = 0, and so in half a finger."""

STRICT = ("solver.rtol=1e-12", "solver.atol_N=1e-11", "contact.self_contact=false")


def loaded(path: LoadPath, axis: str, force_N: float) -> float:
    """Displacement of the tip along the axis under a load."""
    model = path.model
    name = f"load_{axis}_N"
    assert path.advance({name: force_N}).failure is None
    return TipDisplacement(model, axis).value()


def controlled(finger: FingerModel) -> FingerModel:
    """The finger with its loads among the controls."""
    for axis in tip_load.AXES:
        constant = finger.parameters[tip_load.load(axis)]
        finger.model.controls[f"load_{axis}_N"] = Control(constant)
    return finger


def test_a_bar_is_timoshenkos_cantilever() -> None:
    """1/k = L³/(3EI) + 6L/(5GA), of a bar that is wider than thick (Timoshenko)."""
    sides, length = (3.0, 4.5), 60.0
    settings = config.load(None, assignments([*STRICT, "material.nu=0.05"]))
    bar = bodies.box((2, 3, 24), (*sides, length))
    ends = {"clamp": bodies.plane(2, 0.0), "tip": bodies.plane(2, length)}
    finger = controlled(
        build(settings, bodies.domain(bar, ends), plate=False, adds=tip_load.dead_loads)
    )
    newton = Newton(finger.model, settings.solver)
    found = tip_load.stiffness(newton)()
    shear = settings.material.mu_MPa
    young, area = 2 * shear * 1.05, sides[0] * sides[1]
    path = by_pressure(newton)
    for axis, column, depth in zip(tip_load.AXES, COLUMNS, sides, strict=True):
        inertia = area * depth**2 / 12
        compliance = length**3 / (3 * young * inertia) + 6 * length / (5 * shear * area)
        assert found[column] == pytest.approx(1 / compliance, rel=5e-3)
        force = 1e-3 * found[column]  # moves the tip by a micrometre
        moved = loaded(path, axis, force)
        assert force / moved == pytest.approx(found[column], rel=1e-6)
        loaded(path, axis, 0.0)


def test_a_pressurised_finger_gives_way_to_finite_loads_as_its_tangent_says() -> None:
    """Half the difference of loads to and fro: what a load bends is of their square.

    The finger is symmetric, so that in y each is the other's image, and nothing moves in x.
    """
    settings = push.Push().settings(small.short(*STRICT, *EVEN))
    domain = load_domain(settings, MPI.COMM_SELF)
    finger = controlled(build(settings, domain, plate=False, adds=tip_load.dead_loads))
    newton = Newton(finger.model, settings.solver)
    path = by_pressure(newton)
    assert path.advance({"pressure_kPa": 40.0}).failure is None
    tangent = tip_load.stiffness(newton)()
    rest = TipDisplacement(finger.model, "x").value()
    for axis, column in zip(tip_load.AXES, COLUMNS, strict=True):
        force = 1e-2 * tangent[column]
        to, fro = (loaded(path, axis, sign * force) for sign in (1, -1))
        assert 2 * force / (to - fro) == pytest.approx(tangent[column], rel=1e-5)
        if axis == "y":
            assert to == pytest.approx(-fro, rel=1e-6)
        loaded(path, axis, 0.0)
        assert TipDisplacement(finger.model, "x").value() == pytest.approx(rest, abs=1e-9)


def test_half_a_finger_is_as_stiff_in_the_plane_of_bending() -> None:
    found = []
    for half in ("true", "false"):
        settings = small.short(*EVEN, f"mesh.half={half}")
        finger = build(settings, load_domain(settings, MPI.COMM_SELF), plate=False)
        tip = TipDisplacement(finger.model, "x")
        solve = Newton(finger.model, settings.solver).linear()
        found.append(tip_load.compliance_mm_per_N(solve, tip))
    assert found[0] == pytest.approx(found[1], rel=1e-6)


def test_the_experiment() -> None:
    settings = small.short("experiment.step_kPa=25")
    result = run("push", settings, comm=MPI.COMM_SELF)
    assert result.failure is None
    assert result.config.mesh.half is False
    assert list(result.column("pressure_kPa")) == [0, 25, 50]
    for column in (X, Y):
        assert (result.column(column) > 0).all()
    # the reading disturbs nothing: the free finger's angles are those of bending
    bent = run("bending", result.config, comm=MPI.COMM_SELF)
    np.testing.assert_allclose(
        result.column("angle_deg"), bent.column("angle_deg"), rtol=1e-5, atol=1e-9
    )


def test_half_a_mesh_file_is_mirrored(tmp_path: Path) -> None:
    """A file's half has the whole finger's stiffness; the elements are the same."""
    file = tmp_path / "half.msh"
    made = small.short(*EVEN, "experiment.step_kPa=50")
    files.write(file, solid(made))
    unsized = {"file": file, "size_mm": None, "edge_size_mm": None}
    found = [run("push", each, comm=MPI.COMM_SELF) for each in (made, made.changed(mesh=unsized))]
    for column in (X, Y):
        np.testing.assert_allclose(*(each.column(column) for each in found), rtol=1e-5)
