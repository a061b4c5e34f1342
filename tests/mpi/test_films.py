"""Regions, membranes and chords: any number of ranks read what one did."""

from __future__ import annotations

from mpi4py import MPI
from support import stored

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.sections.tables import assignments

PNEUNET = (
    "finger.kind=pneunet", "pneunet.chambers=2", "pneunet.tube=true", "material.mu_MPa=0.06",
    "material.base.mu_MPa=0.1", "film.sheet.region=paper", "film.sheet.Et_N_per_mm=5.0",
    "film.sheet.fibre_deg=[0.0]", "film.sheet.fibre_Et_N_per_mm=[10.0]",
    "mesh.size_mm=4", "mesh.edge_size_mm=2", "camera.chord=back edges",
    "experiment.max_pressure_kPa=1", "experiment.step_kPa=0.5", "solver.max_step_kPa=0.5",
    "solver.rtol=1e-10",
)  # fmt: skip


def test_readings_do_not_depend_on_the_ranks() -> None:
    settings = config.load(None, assignments(PNEUNET))
    result = run("bending", settings, comm=MPI.COMM_WORLD)
    assert result.failure is None
    columns = ("angle_deg", "chord_angle_deg", "tip_x_mm", "cavity_volume_mm3")
    found = {column: result.column(column)[-1] for column in columns}
    stored.compare("a pneunet with a film", found, rtol=1e-7)
