"""What one command writes as a configuration, every command takes that takes a configuration.

Models are built, and nothing is solved: each load path fails before its first step, which every
command has to tell as such. ``tests/experiments/test_written_configurations.py`` goes through the
experiments.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from support import hollow_bar, hollow_box
from support.command import run_command
from support.example import EXAMPLES
from support.measured_files import CSV
from support.measured_files import written as written_table
from support.small import SHORT

from dolfingrip.cli import loop_commands
from dolfingrip.cli.command import settings_of
from dolfingrip.cli.commands import COMMANDS
from dolfingrip.experiments import loop
from dolfingrip.experiments.index import EXPERIMENTS
from dolfingrip.explore import server
from dolfingrip.mechanics.path.failure import Failure, FailureKind
from dolfingrip.meshes import files

OF_OTHERS = {
    "friction": "pickup's grasps", "optimise": "doe's configuration", "reproduce": "doe's, too",
}  # fmt: skip
"""Commands that take a configuration by what another one does with it, and what that is."""

TAKING = [
    each.name
    for each in COMMANDS
    if "--config" in [setting.flag for setting in settings_of(each.settings)]
    and each.name not in {*OF_OTHERS, *(one.command for one in EXPERIMENTS.values())}
]
"""Commands that take a configuration; one that is new is among them."""


@pytest.fixture(autouse=True)
def unsolved(threads: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def failed(*_: Any) -> Failure:
        return Failure(FailureKind.CONTACT, {"pressure_kPa": 0.0})

    monkeypatch.setattr(loop, "_lead", failed)
    for module, name in ((server, "serve"), (loop_commands, "run_small_loop")):
        monkeypatch.setattr(module, name, lambda *_: None)


def told(*settings: str) -> list[str]:
    return [word for each in settings for word in ("--set", each)]


def written(by: str, folder: Path) -> list[str | Path]:
    """What a command writes as a configuration, as options of another one."""
    if by == "adopt":
        part = hollow_bar.stl(folder / "bar.stl")
        assert run_command("adopt", part, "--out", folder, "--size-mm", "5") == 0
        return ["--config", folder / "adopted.toml"]
    if by == "export":
        assert run_command("export", folder / "finger.toml", *told(*SHORT)) == 0
        return ["--config", folder / "finger.toml"]
    if by == "grasp":
        assert run_command("grasp", "--out", folder, "--no-video", *told(*SHORT)) == 1
        return ["--config", folder / "run.json"]
    data = EXAMPLES / "coupons" / "ninjaflex_uniaxial.csv"
    assert run_command("coupon", "--fit", data, "--law", "neo-hooke", "--out", folder) == 0
    return ["--config", folder / "material.toml", *told(*SHORT)]


def arguments(command: str, folder: Path) -> list[str | Path]:
    """What a command needs beside a configuration."""
    out: list[str | Path] = ["--out", folder / "out"]
    if command == "morph":
        files.write(folder / "box.msh", hollow_box.mesh())
        return [folder / "box.msh", "--xi", "0", "0", "--out", folder / "moved.msh"]
    if command == "diagnose":
        table, _, _ = CSV.partition("blocked_force")
        return [written_table(folder, table, 'experiment = ["bending"]'), *out]
    if command == "pickup":
        return ["--start", "100", "--resolution", "100", "--highest", "200", *out]
    curve = folder / "curve.csv"
    curve.write_text("time_s,pressure_kPa\n0,0\n1,20\n2,20\n", encoding="utf-8")
    varied, film = ["--parameter", "material.mu_MPa=2:3:2"], EXAMPLES / "film"
    return {
        "config": [], "export": [folder / "finger.stl"], "doe": [*varied, *out],
        "explore": [*varied, *out], "supply": [curve, *out],
        "track": [film / "finger.mp4", "--silhouette", "--log", film / "log.csv", *out],
    }.get(command, out)  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("by", ["adopt", "export", "grasp", "coupon"])
def test_every_command_takes_what_another_wrote(
    by: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Each ends well, or tells of the load path that failed."""
    options = written(by, tmp_path)
    for command in TAKING:
        capfd.readouterr()
        folder = tmp_path / command
        folder.mkdir()
        code = run_command(command, *options, *arguments(command, folder))
        said = capfd.readouterr()
        text = said.out + said.err
        failed = re.search(r"stopped at 0 kPa \(contact\)|failure: contact", text)
        assert code in ((1, 2) if failed else (0,)), f"{command}: {code}: {text}"
