"""Two round bellows side by side: an actuator of thin walls, on a coarse mesh."""

from __future__ import annotations

from mpi4py import MPI

from dolfingrip import config
from dolfingrip.experiments import run
from dolfingrip.sections.tables import assignments

SHORT = (
    "finger.kind=round_bellows", "round_bellows.convolutions=2", "material.mu_MPa=10",
    "cavity.cavity_2.pressure_ratio=0", "mesh.size_mm=4", "contact.self_contact=false",
    "experiment.max_pressure_kPa=20", "experiment.step_kPa=10",
)  # fmt: skip


def test_thin_walls_take_few_iterations() -> None:
    """The driven bellows lengthens, and the actuator bends away from it.

    With steps of constant length, each of 10 kPa took 34 iterations or more with walls so thin.
    """
    result = run("bending", config.load(None, assignments(SHORT)), comm=MPI.COMM_SELF)
    assert result.failure is None
    angle, iterations = result.column("angle_deg"), result.column("iterations")
    print(angle, iterations, result.column("tip_z_mm"), result.facts.mesh)
    assert angle[2] > angle[1] > 1.0
    assert result.column("tip_z_mm")[1] > 0.1
    assert iterations.sum() <= 30
