"""The told error of a mesh against runs on the bisected mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support import small

from dolfingrip.experiments import run
from dolfingrip.experiments.mesh_error import POLICY, CannotTell, at_all_loads
from dolfingrip.experiments.result import Result
from dolfingrip.experiments.results.readings import Readings


@pytest.mark.parametrize(
    ("kind", "column"), [("bending", "angle_deg"), ("blocked_force", "force_N")]
)
def test_the_change_is_that_of_a_run_on_the_bisected_mesh(kind: str, column: str) -> None:
    """One linear system and some corrections find what a run on the bisected mesh reads.

    The error is a multiple of this change. Both have the sign of a mesh that is too stiff.
    """
    config = small.short("experiment.step_kPa=25")
    told = run(kind, config, mesh_check=True)
    fine = run(kind, small.short("experiment.step_kPa=25", "mesh.refine=2"))
    check = told.facts.mesh_check
    assert check is not None
    assert check.why == ""
    assert check.at == (25, 50)
    change = fine.column(column) - told.column(column)
    found = -np.array(check.errors[column]) / POLICY.whole(config)
    print(kind, "change", change, "found", found, "at", check.at)
    assert found[1] == pytest.approx(change[1], rel=0.1)
    assert found[2] == pytest.approx(change[2], rel=0.1)
    assert check.errors[column][-1] < 0
    assert check.errors[column][0] == pytest.approx(0, abs=1e-9)


def _blocked(places: list[int], found: list[float]) -> np.ndarray:
    """Errors of the default finger's blocked force at 0, 50, 125 and 250 kPa."""
    rows = [
        {"pressure_kPa": pressure, "force_N": force}
        for pressure, force in [(0.0, 0.0), (50.0, 0.5251), (125.0, 1.4842), (250.0, 3.8842)]
    ]
    result = Readings("blocked_force", small.config.Config(), rows)
    return at_all_loads("force_N", places, np.array(found), result)


def test_an_error_that_changes_its_sign_is_not_taken_to_other_loads() -> None:
    """What the default finger's blocked force had: +0.003 N would be told where −0.044 N is true.

    Errors are those of a run on the bisected mesh, times 1.9, and of the extrapolated mesh.
    """
    with pytest.raises(CannotTell, match="do not tell that at 250 kPa"):
        _blocked([1, 2], [0.0069, 0.0013])
    with pytest.raises(CannotTell, match="50 kPa alone"):
        _blocked([1], [0.0069])
    told = _blocked([1, 3], [0.0069, -0.0438])
    assert told[[1, 3]] == pytest.approx([0.0069, -0.0438])
    relative = 0.0069 / 0.5251 * 0.625 - 0.0438 / 3.8842 * 0.375  # 125 between 50 and 250 kPa
    assert told[2] == pytest.approx(relative * 1.4842)


@pytest.mark.parametrize(
    ("larger", "tells"), [(0.6, False), (1.0, True), (2.0, True), (3.0, False)]
)
def test_an_error_in_proportion_is_taken_to_other_loads(larger: float, tells: bool) -> None:
    """From 50 to 125 kPa the relative error grows by a factor, and goes on so to 250 kPa."""
    found = [-0.01 * 0.5251, -0.01 * larger * 1.4842]
    if tells:
        assert _blocked([1, 2], found)[3] == pytest.approx(-0.01 * larger * 3.8842)
    else:
        with pytest.raises(CannotTell):
            _blocked([1, 2], found)


def test_what_it_cannot_tell_is_said(tmp_path: Path) -> None:
    """A mixed element has another system; the file says so, and the run is not in danger."""
    config = small.short("solver.element=P2-P1", "mesh.size_mm=20", "experiment.max_pressure_kPa=5")
    run("bending", config, out=tmp_path, mesh_check=True)
    check = Result.read(tmp_path).facts.mesh_check
    assert check is not None
    assert check.errors == {}
    assert "mixed element" in check.why


def test_a_mesh_that_is_too_coarse_cannot_tell() -> None:
    """Round bellows with walls of 0.8 mm bend by a third more on a finer mesh.

    With elements as wide as the neck, the walls of the bisected mesh lie elsewhere.
    """
    config = small.config.load(None, {
        "finger.kind": "round_bellows", "round_bellows.convolutions": 1, "mesh.size_mm": 12.0,
        "plate.contact_length_mm": 5.0, "cavity.cavity_2.pressure_ratio": 0.0,
        "contact.self_contact": False, "experiment.max_pressure_kPa": 20.0,
        "experiment.step_kPa": 20.0,
    })  # fmt: skip
    check = run("bending", config, mesh_check=True).facts.mesh_check
    assert check is not None
    print(check)
    assert "too coarse" in check.reason("angle_deg")
    assert "angle_deg" not in check.errors


def test_none_is_made_unless_asked_for() -> None:
    config = small.short("experiment.max_pressure_kPa=5")
    assert run("bending", config).facts.mesh_check is None
