"""The mesh in "Can I trust it?": told by the run, too coarse to tell, or not looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from support import hollow_box

from dolfingrip.config import Config, from_dict
from dolfingrip.experiments.bending import Bending
from dolfingrip.experiments.index import find
from dolfingrip.experiments.result import Result
from dolfingrip.files.run import MeshCheck, RunFile
from dolfingrip.meshes.quality import check, judge
from dolfingrip.report.page.content import Check
from dolfingrip.report.page.key_numbers import summary
from dolfingrip.report.page.trust import _estimated, checks


class _Run:
    """A finished bending to 147.6°, as the page's checks read it."""

    title, experiment, elements = "Free bending", Bending(), 1398

    def __init__(self, check: MeshCheck | None, config: Config | None = None) -> None:
        facts = RunFile(experiment="bending", complete=True, mesh_check=check)
        rows = [
            {"pressure_kPa": 0.0, "angle_deg": 0.0},
            {"pressure_kPa": 250.0, "angle_deg": 147.6},
        ]
        self.result = Result("bending", config or Config(), rows, facts=facts, folder=Path())

    def column(self, name: str) -> object:
        return self.result.column(name) if name in self.result else None


def _mesh(check: MeshCheck | None) -> Check:
    found = checks([_Run(check)], {}, {}, None)  # type: ignore[list-item]
    return next(each for each in found if each.name.endswith("mesh"))


@pytest.mark.parametrize(("error", "verdict"), [(-0.43, "pass"), (-8.0, "fail")])
def test_the_told_error_is_judged(error: float, verdict: str) -> None:
    found = _mesh(MeshCheck(errors={"angle_deg": (0.0, error)}))
    assert found.verdict == verdict
    assert f"(mesh: {error:+.1f}°)" in found.said


def test_what_is_not_told_is_open() -> None:
    told = _mesh(MeshCheck(why="the mesh is too coarse"))
    assert (told.verdict, told.said) == ("open", "cannot tell: the mesh is too coarse")
    told = _mesh(MeshCheck(reasons={"angle_deg": "its error changes its sign"}))
    assert (told.verdict, told.said) == ("open", "cannot tell: its error changes its sign")
    assert _mesh(None).verdict == "open"
    assert "--mesh-check" in _mesh(None).said


def test_checks_that_were_not_made_come_before_those_that_passed() -> None:
    (number,) = summary([Check("a", "1", "2", "pass", ""), Check("b", "–", "2", "open", "")])
    assert (number.name, number.value, number.verdict) == ("Checks not made", "1", "open")
    assert number.said == "1 of 1 made pass"


@pytest.mark.parametrize(("element", "verdict"), [(None, "pass"), ("P2", "pass"), ("P1", "fail")])
def test_one_element_through_the_wall_fails_linear_ones_alone(
    element: str | None, verdict: str
) -> None:
    """The warning of a hollow box, whose walls are one element thick."""
    mesh = hollow_box.mesh()
    (warning,) = judge(mesh, check(mesh), "try another --size-mm")
    part = {"finger": {"kind": "adopted"}, "mesh": {"file": "part.msh"},
            "adopted": {"back": "faces −x", "bends_to_back": True, "doubts": [warning]},
            "solver": {"element": element}}  # fmt: skip
    found = checks([_Run(None, from_dict(part))], {}, {}, None)  # type: ignore[list-item]
    (told,) = (each for each in found if each.name.endswith("elements of the part"))
    assert told.verdict == verdict


@pytest.mark.parametrize(("command", "advised"), [("bend", True), ("grasp", False)])
def test_a_check_is_advised_where_there_is_its_option(command: str, advised: bool) -> None:
    run: Any = _Run(None, Config())
    run.experiment = find(command)
    assert ("--mesh-check" in _estimated(run, "angle_deg", "mesh", "1 %").said) is advised


@pytest.mark.parametrize(("bends", "verdict"), [(True, "pass"), (False, "open")])
def test_what_adopt_told_of_a_part(bends: bool, verdict: str) -> None:
    told = {"back": "faces −x: the lever is 3 mm", "bends_to_back": bends, "doubts": []}
    for doubts, mesh in (((), "pass"), (("4 of 90 elements are nearly flat",), "fail")):
        part = {"finger": {"kind": "adopted"}, "adopted": {**told, "doubts": list(doubts)},
                "mesh": {"file": "part.msh"}}  # fmt: skip
        found = {
            each.name.partition(": ")[2]: each
            for each in checks([_Run(None, from_dict(part))], {}, {}, None)  # type: ignore[list-item]
        }
        assert found["back of the part"].verdict == verdict
        assert found["back of the part"].said == told["back"]
        assert found["elements of the part"].verdict == mesh
        assert not doubts or doubts[0] in found["elements of the part"].said
