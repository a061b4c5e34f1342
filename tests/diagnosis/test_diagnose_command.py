"""The command ``diagnose``: a run that goes on where it was, and bad input."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from support.command import run_command
from support.delivered import delivered
from support.example import EXAMPLES
from support.here import Here
from support.invented_coupon import TOLD, made
from support.measured_files import written

from dolfingrip.config import Config, changed
from dolfingrip.diagnosis.data.measurement import read, selected
from dolfingrip.diagnosis.diagnose import DiagnosisSettings, diagnose_measurement
from dolfingrip.experiments.request import Answer, Request
from dolfingrip.files import diagnosis as outcome
from dolfingrip.files.diagnosis_words import lines
from dolfingrip.sections.tables import assignments

COUPONS = EXAMPLES / "coupons/ninjaflex_uniaxial.csv"


def test_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Coupons in closed form: the page's first lines, and the same once more."""
    file, out = made(tmp_path / "lab"), tmp_path / "out"
    options = ["--quick", "--workers", "1", "--effects", "force_gain", "--out", str(out)]
    said = []
    for _ in range(2):
        assert run_command("diagnose", str(file), *options) == 0
        said.append(capfd.readouterr().out)
    assert said[1].splitlines()[-4:] == said[0].splitlines()[-4:]
    result = outcome.DiagnosisFile.read(out)
    assert said[0].splitlines()[-4:-1] == [*lines(result)]
    assert result.verdict.answer == "none"
    assert not result.verdict.claimed  # the modulus does as much
    assert result.headline.number.key == "material.mu_MPa"
    assert {"summary.md", "extended.toml", "overlay.png"} <= {each.name for each in out.iterdir()}


@dataclass(frozen=True, slots=True)
class Dying(Here):
    """Ends after some batches, as if killed."""

    lives: list[int] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)

    def results(self, requests: Sequence[Request]) -> list[Answer]:
        self.asked.extend(each.key for each in requests)
        if not self.lives:
            raise KeyboardInterrupt
        self.lives.pop()
        return Here.results(self, requests)


@pytest.mark.slow
def test_a_second_run_goes_on(tmp_path: Path) -> None:
    """It gives what one run does, and asks for the same simulations in the same order.

    Both laws follow the readings to a hundredth of the largest one.
    """
    # with a raster that is turned a coupon has no closed form
    raster = ("k_MPa=0.1", "raster_deg=5.0")
    config = changed(
        Config(), assignments([f"extensions.print_anisotropy.{each}" for each in raster])
    )
    measurement, _ = selected(read([COUPONS], config), config)
    settings = DiagnosisSettings(effects=("mooney_rivlin", "yeoh"))
    first = Dying(tmp_path, lives=[1, 1])
    with pytest.raises(KeyboardInterrupt):
        diagnose_measurement(measurement, config, first, settings)
    second = Dying(tmp_path, lives=[1] * 99)
    found = diagnose_measurement(measurement, config, second, settings)
    assert second.asked[: len(first.asked)] == first.asked
    assert delivered(found, tmp_path / "out").verdict.effects == ("mooney_rivlin", "yeoh")


@pytest.mark.parametrize(
    ("csv", "toml", "options", "complaint"),
    [
        ("displacement_mm,force\n1,2\n", TOLD, [], "column force: unknown"),
        ("displacement_mm,force_N\n1,2\n2,x\n", TOLD, [], "line 3: force_N = x: not a number"),
        ("displacement_mm,force_N\n1,2\n2,3\n", "", [], "experiment: missing"),
        ("displacement_mm,force_N\n1,2\n2,3\n", TOLD, ["--effects", "magic"], "--effects magic"),
        ("displacement_mm,force_N\n1,2\n2,3\n", TOLD, ["--effects", "plate_gap"], "plate_gap"),
    ],
)
def test_bad_input_is_one_line(
    csv: str,
    toml: str,
    options: list[str],
    complaint: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    file = written(tmp_path, csv, toml)
    out = tmp_path / "out"
    assert run_command("diagnose", str(file), "-o", str(out), *options) == 2
    errors = capfd.readouterr().err
    assert complaint in errors
    assert errors.count("\n") == 1
    assert not out.exists()
