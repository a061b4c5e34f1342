"""Results of the version before are read, or refused in one line.

``tests/kept`` has what version 0.1 wrote at commit 494f2dd, before result files had versions: a
bend and a campaign of a short finger on elements of 10 mm, a surrogate and an optimum of it, and a
quick diagnosis of ``examples/coupons/ecoflex30_uniaxial.csv``.
"""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from support.command import run_command

from dolfingrip.experiments.result import Result
from dolfingrip.files.surrogate import SurrogateFile

KEPT = Path(__file__).resolve().parents[1] / "kept" / "before_files"


def test_a_run_is_read() -> None:
    result = Result.read(KEPT / "bend")
    assert (result.facts.experiment, result.facts.complete, len(result)) == ("bending", True, 2)
    assert result["pressure_kPa"][-1] == 25.0
    assert result["angle_deg"][-1] > 1.0
    assert result.config.finger.wall_mm > 0


def test_a_surrogate_is_read() -> None:
    assert set(SurrogateFile.read(KEPT / "surrogate").inputs) == {"morph.xi1", "morph.xi2"}


def test_a_report_shows_what_is_read(tmp_path: Path) -> None:
    shutil.copytree(KEPT / "bend", tmp_path / "bend")
    page = tmp_path / "report.html"
    assert run_command("report", str(tmp_path / "bend"), "-o", str(page)) == 0
    assert page.stat().st_size > 10_000


def test_a_surrogate_predicts() -> None:
    pytest.importorskip("torch", reason="the extra surrogate brings it")
    from dolfingrip.design.surrogate import surrogate

    found = surrogate.load(KEPT / "surrogate")
    middle = (found.inputs.low + found.inputs.high)[None] / 2
    inside = found.outputs.normalise(found.predict(middle))
    assert ((inside > -0.1) & (inside < 1.1)).all()


@pytest.mark.parametrize(
    ("command", "file", "said"),
    [
        (["report", "optimum", "-o", "page.html"], "optimum/optimum.json",
         "schema_version = 1; allowed: 2; dolfingrip optimise of this version writes it"),
        (["report", "diagnosis", "-o", "page.html"], "diagnosis/diagnosis.json",
         "schema_version = 2; allowed: 3; dolfingrip diagnose of this version writes it"),
        (["doe", "export", "--out", "doe"], "doe/campaign.sqlite",
         "has version 2 of the tables; allowed: 3, or another folder"),
    ],
)  # fmt: skip
def test_what_has_changed_is_refused_in_one_line(
    command: list[str], file: str, said: str, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    shutil.copytree(KEPT, tmp_path / "kept")
    monkeypatch.chdir(tmp_path / "kept")
    before = (tmp_path / "kept" / file).read_bytes()
    assert run_command(*command) == 2
    assert capfd.readouterr().err == f"dolfingrip: {file}: {said}\n"
    assert (tmp_path / "kept" / file).read_bytes() == before
