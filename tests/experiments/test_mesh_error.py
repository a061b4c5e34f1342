"""The told error of a mesh against runs on the bisected mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small

from dolfingrip.config import load
from dolfingrip.experiments import run
from dolfingrip.experiments.mesh_error import estimate, whole
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results.readings import Readings
from dolfingrip.sections.tables import assignments


@pytest.mark.parametrize(
    ("kind", "column"), [("bending", "angle_deg"), ("blocked_force", "force_N")]
)
def test_the_change_is_that_of_a_run_on_the_bisected_mesh(kind: str, column: str) -> None:
    """The error is a multiple of this change, with the sign of a mesh that is too stiff."""
    config = small.short("experiment.step_kPa=25")
    told = run(kind, config, mesh_check=True)
    fine = run(kind, small.short("experiment.step_kPa=25", "mesh.refine=2"))
    check = told.facts.mesh_check
    assert check is not None
    assert check.why == ""
    change = fine.column(column) - told.column(column)
    found = -np.array(check.errors[column]) / whole(config)
    print(kind, "change", change, "found", found)
    assert found == pytest.approx(change, rel=1e-6, abs=1e-9)
    assert check.errors[column][-1] < 0
    assert check.errors[column][0] == pytest.approx(0, abs=1e-9)


def _readings(*values: float) -> Readings:
    rows = [
        {"branch": "loading", "pressure_kPa": 50.0 * i, "force_N": value}
        for i, value in enumerate(values)
    ]
    return Readings("blocked_force", small.config.Config(), rows)


@pytest.mark.parametrize(
    ("changes", "order"),
    [
        ([], 1.08),  # twice the exponent of the displacement at an edge of 270°
        (["solver.element=P2"], 1.08),
        (["solver.integration=selective"], 2.0),
        (["finger.kind=cast"], 2.0),
        (["finger.kind=cast", "solver.integration=full"], 1.08),
    ],
)
def test_the_whole_error_is_that_of_bisections_without_end(
    changes: list[str], order: float
) -> None:
    """A reading whose error falls with h to the order: the first change tells the whole error."""
    config = load(None, assignments(changes))
    exact, error = 3.0, 0.1
    coarse, fine = exact + error, exact + error / 2**order
    assert whole(config) * (coarse - fine) == pytest.approx(error, rel=1e-12)


def test_an_error_that_changes_its_sign_is_told_at_each_load() -> None:
    """The default finger's blocked force is too large at 50 kPa and too small at 250 kPa."""
    check = estimate(_readings(0.0, 0.5251, 3.8842), _readings(0.0, 0.5214, 3.9102))
    factor = whole(small.config.Config())
    assert check.errors.keys() == {"force_N"}
    assert check.errors["force_N"] == pytest.approx((0.0, 0.0037 * factor, -0.0260 * factor))


def test_what_cannot_be_told_is_said() -> None:
    check = estimate(_readings(0.0, 1.0), _readings(0.0, 1.2))
    assert check.errors == {}
    assert check.reason("force_N") == "the mesh is too coarse: its error is above 25 %"
    check = estimate(_readings(0.0, 1.0, 2.0), _readings(0.0, 1.0))
    assert "ends earlier" in check.reason("force_N")


def test_it_is_told_of_tetrahedra_with_a_pressure_of_their_own(tmp_path: Path) -> None:
    """The mixed element's cells are bisected; the file has the error beside the readings."""
    config = small.short(
        "solver.element=P2-P1", "mesh.size_mm=20", "experiment.max_pressure_kPa=5",
        "experiment.step_kPa=5",
    )  # fmt: skip
    told = run("bending", config, out=tmp_path, mesh_check=True)
    fine = run("bending", config.changed(mesh={"refine": 2}))
    check = Result.read(tmp_path).facts.mesh_check
    assert check is not None
    change = fine.column("angle_deg") - told.column("angle_deg")
    print("change", change, check)
    assert change[-1] > 0
    reason = check.reason("angle_deg")
    if reason:
        assert "too coarse" in reason
    else:
        assert -np.array(check.errors["angle_deg"]) / whole(config) == pytest.approx(change)


def test_stops_must_be_known_beforehand() -> None:
    config = small.short(
        "experiment.control=volume", "experiment.max_volume_ratio=1.02",
        "experiment.step_volume_ratio=0.02",
    )  # fmt: skip
    check = run("bending", config, mesh_check=True).facts.mesh_check
    assert check is not None
    assert 'experiment.control = "volume": allowed: "pressure"' in check.why


def test_none_is_made_unless_asked_for() -> None:
    config = small.short("experiment.max_pressure_kPa=5")
    assert run("bending", config).facts.mesh_check is None
