"""The demo: pictures are announced before its design loop begins, and it ends with a report."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest
from support.command import run_command

from dolfingrip.cli import loop_commands
from dolfingrip.config import Config

COARSE = (
    "--set", "mesh.size_mm=8", "--set", "mesh.edge_size_mm=8", "--set", "finger.length_mm=38",
    "--set", "finger.bellows=2", "--set", "experiment.max_pressure_kPa=100",
    "--set", "experiment.step_kPa=50",
)  # fmt: skip
PICTURES = ("curve.png", "finger_0kPa.png", "finger_100kPa.png", "strip.png")


def test_pictures_come_before_the_design_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    said = []

    def loop(config: Config, out: Path) -> None:
        assert out == tmp_path / "loop"
        said.append(capfd.readouterr().out)
        for kind in ("bending", "blocked_force"):
            for name in PICTURES:
                assert matplotlib.image.imread(tmp_path / kind / name)[..., :3].std() > 0.01

    monkeypatch.setattr(loop_commands, "run_small_loop", loop)
    assert run_command("demo", "-o", str(tmp_path), *COARSE) == 0
    after = capfd.readouterr()
    assert not after.err
    lines = said[0].splitlines()
    kinds = ("bending", "blocked_force")
    wrote = [f"wrote {tmp_path / kind / name}" for kind in kinds for name in PICTURES]
    assert lines[: len(wrote)] == wrote
    assert "Reference finger" in said[0]
    page = tmp_path / "report.html"
    assert after.out.splitlines() == [f"report: {page}"]
    assert "Free bending and blocked force" in page.read_text(encoding="utf-8")
