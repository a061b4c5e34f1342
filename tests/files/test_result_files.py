"""Result files: what is written is read again; what is not such a file is refused in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dolfingrip.files.campaign import CampaignFile
from dolfingrip.files.design import DesignFile, DesignParameter
from dolfingrip.files.diagnosis import DesignChange, DiagnosisFile, Downstream
from dolfingrip.files.diagnosis_words import fate
from dolfingrip.files.front import FrontFile
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.files.plan import PlanFile
from dolfingrip.files.result_file import ResultFile, ResultFileError
from dolfingrip.files.run import GraspKind, GraspOutcome, RunFailure, RunFile, TurningPoint
from dolfingrip.files.surrogate import SurrogateFile
from dolfingrip.report.page.sources import MARKS

FILES = (
    RunFile, DiagnosisFile, DesignFile, FrontFile, OptimumFile, SurrogateFile, PlanFile,
    CampaignFile,
)  # fmt: skip

RUN = RunFile(
    experiment="blocked_force",
    config={"finger": {"wall_mm": 1.5}},
    failure=RunFailure(kind="contact", last_good={"pressure_kPa": 40.0}, said="stopped at 40 kPa"),
    turning_point=TurningPoint(170.0, 1.7, 0.01, 0.02),
    outcome=GraspOutcome(GraspKind.SLIPPED, 1.5, "sank"),
)

DESIGN = DesignFile(
    of="maximise force_N at 250 kPa",
    quantity="force_N",
    objective=3.0,
    start=2.5,
    gain=0.2,
    simulations=3,
    ending="no step promises more",
    parameters={"morph.xi1": DesignParameter(start=0.0, value=0.5, low=-0.2, high=1.0)},
)

OLD_RUN = {
    "command": ["bend"], "config": {}, "experiment": "bending", "complete": True,
    "mesh": {"elements": 120, "dofs": 900, "half": True},
    "newton": {"iterations": 12, "factorisations": 4, "load_steps": 4, "damped_steps": 0,
               "linear_solver": "direct", "matrix_patterns": 1},
    "failure": None, "notes": [], "turning_point": None, "outcome": None, "ranks": 1,
    "compiled_for": "x", "wall_s": 1.5, "memory_forecast_MB": 10, "peak_memory_MB": 300,
    "profile": {"mesh": {"wall_s": 0.1, "calls": 1}}, "versions": {"dolfingrip": "0"},
    "machine": {"system": "Linux", "processors": 2},
}  # fmt: skip
"""Keys of the ``run.json`` that had no schema_version."""


def test_the_curve_of_a_file_without_quantity_is_shown_in_mm() -> None:
    """Files of earlier versions name what is improved in words alone."""
    old = DESIGN.model_dump() | {"of": "minimise curve_mean_square_mm2", "objective": 9.0}
    del old["quantity"]
    shown = DesignFile.model_validate(old).shown
    assert (shown.of, shown.quantity) == ("minimise curve_rms_mm", "curve_rms_mm")
    assert shown.objective == 3.0


@pytest.mark.parametrize("content", [RUN, DESIGN])
def test_what_is_written_is_read(content: ResultFile, tmp_path: Path) -> None:
    file = content.write(tmp_path / "new")
    assert file.name == content.FILE
    assert type(content).read(tmp_path / "new") == content
    assert type(content).read(str(file)) == content
    assert json.loads(file.read_text(encoding="utf-8"))["schema_version"] == 1


def test_a_run_of_the_version_before_is_read(tmp_path: Path) -> None:
    (tmp_path / "run.json").write_text(json.dumps(OLD_RUN), encoding="utf-8")
    found = RunFile.read(tmp_path)
    assert (found.newton.iterations, found.mesh.half, found.wall_s) == (12, True, 1.5)
    assert set(OLD_RUN) <= set(found.plain())


@pytest.mark.parametrize("kind", FILES)
@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "No such file or directory"),
        ("{", "not JSON"),
        ("[]", "no JSON object; allowed: a file that dolfingrip wrote"),
        ('{"schema_version": 99}', "schema_version = 99; allowed: "),
        ("{}", "Field required"),
    ],
)
def test_other_files_are_refused_in_one_line(
    kind: type[ResultFile], text: str | None, said: str, tmp_path: Path
) -> None:
    if text == "{}" and kind.model_fields["schema_version"].default != 1:
        said = "schema_version = 1; allowed: "  # as the version before wrote it
    if text is not None:
        (tmp_path / kind.FILE).write_text(text, encoding="utf-8")
    with pytest.raises(ResultFileError) as caught:
        kind.read(tmp_path)
    line = str(caught.value)
    assert line.startswith(f"{tmp_path / kind.FILE}: ")
    assert said in line
    assert "\n" not in line


def test_every_kind_of_result_has_a_mark() -> None:
    marks = {"run.json", "diagnosis.json", "design.json", "front.json", "optimum.json",
             "surrogate.json", "campaign.json"}  # fmt: skip
    assert marks <= set(MARKS.values())
    assert len(set(MARKS.values())) == len(MARKS)


def test_only_their_classes_take_result_files_apart() -> None:
    """Reports and the explorer read no JSON but of their own scripts and sockets."""
    root = Path(__file__).resolve().parents[2] / "dolfingrip"
    found = {
        file.relative_to(root).as_posix()
        for folder in ("report", "explore")
        for file in (root / folder).rglob("*.py")
        if "json.load" in file.read_text(encoding="utf-8")
    }
    assert found <= {"report/page/html.py", "explore/session.py", "explore/server.py"}


def test_what_a_run_has_not_counted_yet_is_none_or_zero(tmp_path: Path) -> None:
    """As ``run.json`` stands from the start of a run on, and after a kill."""
    RunFile(experiment="bending").write(tmp_path)
    facts = json.loads((tmp_path / "run.json").read_text("utf-8"))
    assert facts["complete"] is False
    assert facts["wall_s"] is None
    assert facts["mesh"] == {"elements": 0, "dofs": 0, "half": False, "single_walls": 0.0}
    counts = {key: value for key, value in facts["newton"].items() if isinstance(value, int)}
    assert counts == {"iterations": 0, "factorisations": 0, "load_steps": 0, "damped_steps": 0,
                      "matrix_patterns": 1}  # fmt: skip


@pytest.mark.parametrize(
    ("after", "said"),
    [
        ((5.0, 4.0), "φ of the campaign's optimum 50.0% → 25.0%; it stays the best of the 2 that"),
        ((4.0, 5.0), "φ of the campaign's optimum 50.0% → 0.0%; the best is now morph.xi1 = 0.2 "),
        ((None, 5.0), "the campaign's optimum could not be computed with the extended model"),
    ],
)
def test_the_fate_of_a_campaigns_optimum(after: tuple[float | None, float], said: str) -> None:
    """φ is the force over the original finger's, which is 2 N before and 4 N after, less 1."""
    designs = [
        DesignChange(
            inputs={"morph.xi1": 0.1 * (number + 1)}, cog_offset_mm=1.0,
            force_before_N=3.0 - number, phi_before=0.5 - 0.5 * number,
            force_after_N=force, phi_after=None if force is None else force / 4 - 1,
        )
        for number, force in enumerate(after)
    ]  # fmt: skip
    found = Downstream(original_before_N=2.0, original_after_N=4.0, designs=tuple(designs))
    assert fate(found).startswith(said)


def test_a_failures_sentence_has_its_documented_name(tmp_path: Path) -> None:
    facts = json.loads(RUN.write(tmp_path).read_text("utf-8"))
    assert facts["failure"] == {
        "kind": "contact", "last_good": {"pressure_kPa": 40.0}, "sentence": "stopped at 40 kPa"
    }  # fmt: skip
