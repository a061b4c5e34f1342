"""The same answer on any number of ranks, and no rank left waiting.

Run as ``mpirun -n 2 python -m pytest tests/mpi`` (also with 3, or without mpirun). The reference is
what one rank found (:mod:`mpi.stored`).
"""

from __future__ import annotations

import errno
from pathlib import Path

import numpy as np
import pytest
from mpi4py import MPI
from support import small, stored

from dolfingrip import config
from dolfingrip.config import ConfigError
from dolfingrip.experiments import Result, run
from dolfingrip.experiments.derivatives import gradients
from dolfingrip.experiments.loop import follow
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.rigs.finger import build
from dolfingrip.experiments.rigs.observation import Observation
from dolfingrip.experiments.rigs.undeformed import load_domain
from dolfingrip.files import whole
from dolfingrip.files.whole import WriteError
from dolfingrip.mechanics.model.domain import on_root
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes import files
from dolfingrip.meshes.quality import check
from dolfingrip.report.fields import list_steps, read_grid, read_mesh
from dolfingrip.sections.tables import assignments

WORLD = MPI.COMM_WORLD
READINGS = (
    "angle_deg", "force_N", "tip_x_mm", "tip_z_mm", "chord_angle_deg", "cavity_volume_mm3",
    "contact_gap_mm", "plate_gap_mm",
)  # fmt: skip
STRICT = ("solver.rtol=1e-12", "solver.atol_N=1e-11")
"""Iterated until rounding, lest the comparison show where Newton's method was stopped."""

BLOCKED = small.short(
    *STRICT, "finger.gap_mm=0.4", "experiment.max_pressure_kPa=160", "experiment.step_kPa=80"
)
FREE = small.short(
    *STRICT, "contact.self_contact=false", "experiment.max_pressure_kPa=80",
    "experiment.step_kPa=40",
)  # fmt: skip


def _compare(case: str, result: Result) -> None:
    assert result.failure is None
    had = result.columns()  # a free finger has no force, and one without contact no gap
    columns = {name: result.column(name) for name in READINGS if name in had}
    found = {name: values for name, values in columns.items() if np.isfinite(values).any()}
    stored.compare(case, found, rtol=1e-8, by_scale=True)


def test_blocked_finger_with_bellows_in_contact() -> None:
    result = run("blocked_force", BLOCKED, comm=WORLD)
    gap = result.column("contact_gap_mm")
    assert gap[0] > BLOCKED.contact.barrier_mm > gap[-1]  # or there would be no contact to test
    assert result.column("force_N")[-1] > 0.1
    _compare("blocked", result)


@pytest.mark.parametrize("acceleration", [pytest.param(0.0, marks=pytest.mark.two_ranks), 9.81])
def test_gradient_of_the_blocked_force(acceleration: float) -> None:
    weight = {"acceleration_m_s2": acceleration, "direction": [-1.0, 0.0, 0.0]}
    tilted = config.from_dict(
        {**BLOCKED.model_dump(mode="json"), "plate": {"tilt_deg": 10.0}, "gravity": weight}
    )
    asked = Request.of("blocked_force", tilted, gradients.XI, at_highest=True, columns=("force_N",))
    rows = follow(asked, WORLD).sensitivities
    found = {each["parameter"]: each["derivative"] for each in rows}
    assert set(found) == set(gradients.XI)
    assert all(abs(slope) > 0.1 for slope in found.values())
    stored.compare(f"gradient at {acceleration} m/s²", found, rtol=1e-7)


@pytest.mark.two_ranks
@pytest.mark.parametrize("case", ["free", "blocked"])
def test_multigrid_finds_what_factors_find(case: str) -> None:
    """The reference is the direct solver's on one rank."""
    settings = (FREE if case == "free" else BLOCKED).changed(solver={"linear": "iterative"})
    experiment = "bending" if case == "free" else "blocked_force"
    _compare(case, run(experiment, settings, comm=WORLD))


def test_multigrid_iterates_as_on_one_rank() -> None:
    """One step: where its levels are wrong, factors take its place, or Newton iterates longer."""
    settings = small.short(
        *small.FEW, "solver.linear=iterative", "experiment.max_pressure_kPa=20",
        "experiment.step_kPa=20",
    )  # fmt: skip
    all_ranks, one = (run("bending", settings, comm=comm) for comm in (WORLD, MPI.COMM_SELF))
    assert all_ranks.failure is None
    found, expected = (each.facts.newton for each in (all_ranks, one))
    print(found, expected)
    assert found.linear_solver == "iterative"
    assert (found.iterations, found.factorisations) == (
        expected.iterations, expected.factorisations,
    )  # fmt: skip
    np.testing.assert_allclose(all_ranks["angle_deg"], one["angle_deg"], rtol=1e-6)


def test_free_finger_without_contact(shared: Path) -> None:
    result = run("bending", FREE, out=shared, comm=WORLD)
    _compare("free", result)
    assert result.facts.ranks == WORLD.size
    mesh = result.facts.mesh.model_dump()
    stored.compare("free, mesh", mesh, rtol=0)
    if WORLD.rank == 0:
        steps = list_steps(shared / "fields.pvd")
        assert len(steps) == len(result.rows)
        assert len(read_mesh(read_grid(steps[-1])).cells) == mesh["elements"]
        assert len((shared / "result.csv").read_text().splitlines()) == 1 + len(result.rows)


@pytest.mark.two_ranks
def test_whole_finger_of_linear_elements_with_a_tilted_plate() -> None:
    settings = small.short(
        *STRICT, "mesh.half=false", "solver.element=P1", "plate.tilt_deg=10",
        "experiment.max_pressure_kPa=30", "experiment.step_kPa=30",
    )  # fmt: skip
    _compare("linear elements, tilted plate", run("blocked_force", settings, comm=WORLD))


def test_stiffness_at_the_tip_of_a_hanging_finger() -> None:
    settings = small.short(
        *STRICT, "gravity.acceleration_m_s2=9.81", "gravity.direction=[0.6, 0.8, 0]",
        "mesh.half=false", "experiment.step_kPa=50",
    )  # fmt: skip
    result = run("push", settings, comm=WORLD)
    _compare("hanging", result)
    names = ("stiffness_x_N_per_mm", "stiffness_y_N_per_mm")
    stiffness = {name: result.column(name) for name in names}
    stored.compare("hanging, stiffness", stiffness, rtol=1e-7)


@pytest.mark.two_ranks
def test_mixed_element_with_contact_led_by_volume() -> None:
    settings = small.short(
        *STRICT, "solver.element=P2-P1", "material.nu=0.4999", "finger.gap_mm=0.4",
        "experiment.control=volume", "experiment.max_volume_ratio=1.5",
        "experiment.step_volume_ratio=0.25",
    )  # fmt: skip
    result = run("blocked_force", settings, comm=WORLD)
    assert result.column("contact_gap_mm")[-1] < settings.contact.barrier_mm
    assert result.column("pressure_kPa")[-1] > 10
    _compare("mixed, led by volume", result)


@pytest.mark.two_ranks
@pytest.mark.parametrize("element", ["P2", "P2-P1"])
def test_a_damped_solve(element: str) -> None:
    """Damped and searched, the finger is the same as plain solves find it: those are stored."""
    settings = config.from_dict(
        {**FREE.model_dump(mode="json"), "solver": {"element": element, "rtol": 1e-12}}
    )
    finger = build(settings, load_domain(settings, WORLD), plate=False)
    newton = Newton(finger.model, settings.solver)
    for pressure_kPa in (10.0, 20.0):
        finger.model.prescribe({"pressure_kPa": pressure_kPa})
        assert newton.solve(damped=not stored.WRITES).converged
    observation = Observation(finger).read()
    found = {name: observation[name] for name in ("angle_deg", "cavity_volume_mm3")}
    stored.compare(f"solved without damping, {element}", found, rtol=1e-7)


def test_ranks_without_skin_take_part() -> None:
    """On a few elements some ranks own none of what the plate or contact looks at."""
    settings = small.short(
        *STRICT, "mesh.size_mm=30", "mesh.edge_size_mm=30", "finger.bellows=1",
        "finger.base_block_mm=2", "finger.length_mm=20", "plate.contact_length_mm=1",
        "experiment.max_pressure_kPa=5", "experiment.step_kPa=5",
    )  # fmt: skip
    _compare("ranks without skin", run("blocked_force", settings, comm=WORLD))


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("finger.wall_mm=3.499999", "finger.wall_mm = 3.499999: leaves"),
        ("mesh.size_mm=0.001", "mesh.size_mm = 0.001: about"),
        ("mesh.file=/no/such.msh", "mesh.file = /no/such.msh: No such file or directory"),
    ],
)
def test_a_mesh_that_fails_on_rank_0_fails_on_all(override: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        run("bending", config.load(None, assignments([override])), comm=WORLD)
    assert WORLD.allreduce(1) == WORLD.size  # all are here, none waits


def test_a_folder_that_rank_0_cannot_make_fails_on_all(shared: Path) -> None:
    if WORLD.rank == 0:
        (shared / "file").write_text("in the way")
    WORLD.Barrier()
    with pytest.raises(WriteError, match=r"file/results/run\.json: .*: Not a directory"):
        run("bending", FREE, out=shared / "file" / "results", comm=WORLD)
    assert WORLD.allreduce(1) == WORLD.size


def test_fields_that_one_rank_cannot_write_fail_on_all(
    shared: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The last rank's disk is full."""

    def full(path: Path, *_: object) -> None:
        if WORLD.rank == WORLD.size - 1 and path.suffix == ".vtu":
            raise WriteError(errno.ENOSPC, "full", str(path))

    monkeypatch.setattr(whole, "require", full)
    with pytest.raises(WriteError, match=rf"fields_p{WORLD.size - 1}_000000\.vtu: cannot be"):
        run("bending", FREE, out=shared, comm=WORLD)
    assert WORLD.allreduce(1) == WORLD.size


def test_any_error_on_rank_0_is_raised_on_all() -> None:
    def fail() -> None:
        raise ZeroDivisionError("on rank 0")

    with pytest.raises(ZeroDivisionError, match="on rank 0"):
        on_root(WORLD, fail)
    assert WORLD.allreduce(1) == WORLD.size


@pytest.mark.two_ranks
def test_half_finger_from_a_file_refuses_sideways_loads(shared: Path) -> None:
    file = shared / "finger.msh"
    settings = small.short()

    def write() -> None:
        from dolfingrip.experiments.rigs.undeformed import solid

        mesh = solid(settings)
        assert check(mesh).cavity_mm3 > 0
        files.write(file, mesh)

    on_root(WORLD, write)
    across = config.load(
        None,
        assignments(
            [f"mesh.file={file}", "gravity.acceleration_m_s2=9.81", "gravity.direction=[0, 1, 0]"]
        ),
    )
    with pytest.raises(ConfigError, match=r"gravity.direction .*: allowed: no y-part"):
        run("bending", across, comm=WORLD)


def test_vibration_and_motion_are_those_of_one_rank() -> None:
    settings = small.short(
        *STRICT, "mesh.size_mm=10", "mesh.edge_size_mm=10", "contact.self_contact=false",
        "solver.element=P1",
        "experiment.max_pressure_kPa=20",
    )  # fmt: skip
    moving = settings.changed(
        experiment={"dynamic": True},
        protocol={"time_s": [0.0, 0.0005], "pressure_kPa": [0.0, 20.0]},
    )
    for name, column, asked in (
        ("vibration", "frequency_4_Hz", settings),
        ("bending", "tip_x_mm", moving),
    ):
        all_ranks, one = (run(name, asked, comm=comm) for comm in (WORLD, MPI.COMM_SELF))
        np.testing.assert_allclose(all_ranks.column(column), one.column(column), rtol=1e-6)
