"""The demo: pictures are announced before its design loop begins, and it ends with a report."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import pytest
from support.command import run_command

from dolfingrip import config
from dolfingrip.cli import doe_commands, loop_commands
from dolfingrip.cli.settings import DoeSettings
from dolfingrip.config import Config, changed
from dolfingrip.jobs.store import Store

COARSE = (
    "--set", "mesh.size_mm=8", "--set", "mesh.edge_size_mm=8", "--set", "finger.length_mm=38",
    "--set", "finger.bellows=2", "--set", "experiment.max_pressure_kPa=100",
    "--set", "experiment.step_kPa=50",
)  # fmt: skip
PICTURES = ("curve.png", "finger_0kPa.png", "finger_100kPa.png", "strip.png")


def test_an_older_campaign_is_refused_before_anything_is_solved(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    other = changed(config.load(), {"material.mu_MPa": 3.5})
    asked = DoeSettings(parameter=loop_commands.DESIGNS)
    designs = doe_commands.planned(asked, loop_commands.coarsened(other))
    with Store(tmp_path / "loop" / "doe", write=True) as store:
        store.add(designs.jobs(), designs.shared)
    assert run_command("demo", "-o", str(tmp_path)) == 2
    assert "material.mu_MPa was 3.5, now 2.93; allowed: the same settings" in capfd.readouterr().err
    assert not (tmp_path / "bending").exists()


@pytest.mark.slow
def test_pictures_come_before_the_design_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("torch", reason="the extra surrogate brings it")
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
