"""``dolfingrip coupon --fit``: what it prints, draws and writes."""

from __future__ import annotations

from pathlib import Path

import pytest
from support.example import EXAMPLES
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError

FILE = EXAMPLES / "coupons" / "ecoflex30_uniaxial.csv"


def test_the_table_of_all_laws_fits_into_80_columns(tmp_path: Path) -> None:
    found = CliRunner().invoke(app, ["coupon", "--fit", str(FILE), "-o", str(tmp_path)])
    assert found.exit_code == 0, found.output
    tables, _, _ = found.output.partition("\n- ")
    assert max(map(len, tables.splitlines())) <= 80
    assert "…" not in tables


def test_the_best_law_is_written_and_drawn(tmp_path: Path) -> None:
    asked = ["--law", "neo-hooke", "--law", "yeoh", "--law", "polynomial"]
    found = CliRunner().invoke(app, ["coupon", "--fit", str(FILE), *asked, "-o", str(tmp_path)])
    assert found.exit_code == 0, found.output
    tables, _, _ = found.output.partition("\n- ")  # the remarks below
    assert max(map(len, tables.splitlines())) <= 80
    assert "…" not in tables
    headings = "Law rms (MPa) (%) Correlation BIC equibiaxial) Balloon's maximum Parameter Value"
    assert set(headings.split()) <= set(tables.split())
    row = next(line.split() for line in tables.splitlines() if "C30_MPa" in line)
    assert [float(cell) for cell in row[-2:]] == pytest.approx([3.852e-6, 1.5e-6], rel=0.05)
    said = " ".join(found.output.split())
    assert "73 readings; uniaxial: 1 specimen, to a stretch of 7.2" in said
    assert "Yeoh ←" in said
    assert "fits equally, the other factors refitted" in said
    assert "laws that fit equally well differ in equibiaxial tension" in said
    material = config.load(tmp_path / "material.toml").material
    assert material.law == "polynomial"
    assert material.C10_MPa == pytest.approx(0.0103, rel=0.02)
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--law", "hooke", "--fit", str(FILE)], "--law hooke: allowed: neo-hooke, mooney-rivlin"),
        (["--law", "yeoh"], "--law yeoh: allowed: with --fit FILE.csv"),
        (["--max-stretch", "0.5", "--fit", str(FILE)], "--max-stretch 0.5: allowed: above 1"),
    ],
)
def test_bad_options_are_one_line(options: list[str], said: str, tmp_path: Path) -> None:
    found = CliRunner().invoke(app, ["coupon", *options, "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, ConfigError)
    assert said in str(found.exception)
    assert not (tmp_path / "out").exists()
