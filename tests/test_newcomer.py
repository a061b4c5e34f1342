"""What somebody meets who uses the package for the first time: options, names, refusals."""

from __future__ import annotations

from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from dolfingrip.cli.app import app
from dolfingrip.config import ConfigError
from dolfingrip.diagnosis.data import table
from dolfingrip.experiments.index import EXPERIMENTS, find
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.sections import protocol_file

COMMAND = typer.main.get_command(app)
PRESSURISED = ("bend", "force", "cycle", "push", "grasp")


@pytest.mark.parametrize("name", PRESSURISED)
def test_each_experiment_with_pressure_has_its_option(name: str) -> None:
    command = COMMAND.commands[name]  # type: ignore[attr-defined]
    assert "--pressure" in {flag for option in command.params for flag in option.opts}


def test_a_protocol_has_its_own_pressures(tmp_path: Path) -> None:
    asked = ["bend", "--pressure", "100", "--protocol", "x.toml", "-o", str(tmp_path / "out")]
    found = CliRunner().invoke(app, asked)
    assert isinstance(found.exception, ConfigError)
    assert "--pressure 100: allowed: without --protocol" in str(found.exception)


@pytest.mark.parametrize(("command", "name"), [("bend", "bending"), ("force", "blocked_force")])
def test_an_experiment_is_found_by_either_name(command: str, name: str) -> None:
    assert find(command) is find(name) is EXPERIMENTS[name]
    assert f"In files and Python: {name}." in EXPERIMENTS[name].summary()
    with pytest.raises(ConfigError, match=rf"{name} \(or {command}\)"):
        find("bendign")


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_csv_with_another_separator_is_told_so(separator: str, tmp_path: Path) -> None:
    file = tmp_path / "measured.csv"
    names = ["time_s", "displacement_mm", "force_N"]
    rows = [["0", "0", "0"], ["1", "0,5", "0,12"], ["2", "1", "0,2"]]
    file.write_text("\n".join(separator.join(row) for row in [names, *rows]) + "\n")
    said = "its entries are separated by (semicolons|tabs); allowed: commas"
    with pytest.raises(ConfigError, match=said):
        coupons.read(file)
    with pytest.raises(ConfigError, match=said):
        protocol_file.read(file, "coupon", "displacement_mm")
    with pytest.raises(ConfigError, match=said):
        table.read(file, ["coupon"])
