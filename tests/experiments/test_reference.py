"""The reference finger on the default mesh, held to stored figures.

The figures are this code's own: they show a change, not correctness. That
is for the energies' tests against closed forms (tests/mechanics), the balance of forces
(test_forces) and the benchmarks against other codes.

Where the default mesh or the contact's discretisation changes on purpose, print the new figures:
``python -m pytest tests/experiments/test_reference.py -rP``.
"""

from __future__ import annotations

import pytest
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.experiments import Result, run
from dolfingrip.sections.tables import assignments

ELEMENTS = 1398
FIGURES: dict[tuple[str, float], dict[str, float]] = {
    ("bending", 50.0): {
        "angle_deg": 29.73239435, "tip_x_mm": -22.51034687, "tip_z_mm": -1.03135922,
    },
    ("bending", 100.0): {
        "angle_deg": 57.76888, "tip_x_mm": -42.1268952, "tip_z_mm": -9.40531518,
    },
    ("blocked_force", 100.0): {
        "angle_deg": 11.59583263, "tip_z_mm": 1.61065452, "force_N": 1.13887883,
    },
    ("blocked_force", 200.0): {
        "angle_deg": 24.01983269, "tip_z_mm": 2.77831136, "force_N": 2.77578796,
    },
}  # fmt: skip
"""Readings by experiment and pressure in kPa, at the default mesh (hexahedra, half)."""

TOLERANCE = 1e-6
STEPS = {"bending": (100, 50), "blocked_force": (200, 100)}
"""Highest pressure and distance of readings, kPa."""


MOST = {"bending": (13, 6), "blocked_force": (34, 18)}
"""Newton iterations and factorisations that a run may take: what was measured, and a tenth."""


@pytest.fixture(scope="module", params=STEPS)
def result(request: pytest.FixtureRequest) -> Result:
    highest, step = STEPS[request.param]
    settings = config.load(
        overrides=assignments(
            [f"experiment.max_pressure_kPa={highest}", f"experiment.step_kPa={step}"]
        )
    )
    return run(request.param, settings, comm=MPI.COMM_SELF)


def test_figures_stay(result: Result) -> None:
    assert result.failure is None
    rows = {(result.kind, row["pressure_kPa"]): row for row in result.rows}
    print(f"ELEMENTS = {result.facts.mesh.elements}")
    for key, row in rows.items():
        names = [name for name in ("angle_deg", "tip_x_mm", "tip_z_mm", "force_N") if name in row]
        print(f"    {key}: { ({name: round(row[name], 8) for name in names}) },")
    assert result.facts.mesh.elements == ELEMENTS
    expected = {key: figures for key, figures in FIGURES.items() if key[0] == result.kind}
    assert expected
    for key, figures in expected.items():
        for name, value in figures.items():
            assert rows[key][name] == pytest.approx(value, rel=TOLERANCE), (key, name)


def test_effort_stays(result: Result) -> None:
    """What a run costs on any machine."""
    newton = result.facts.newton
    iterations, factorisations = MOST[result.kind]
    print(f"{result.kind}: {newton}")
    assert newton.iterations <= iterations
    assert newton.factorisations <= factorisations
