"""The command, on a rig of coupons, whose simulation is cheap."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command import run_command

from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.additions.checks import coupon_check
from dolfingrip.diagnosis.additions.protocols import proposals
from dolfingrip.diagnosis.answer.noise import instrument_noise
from dolfingrip.diagnosis.data import rig
from dolfingrip.diagnosis.plan import read_alike
from dolfingrip.diagnosis.policy import Policy
from dolfingrip.files.plan import PlanFile

RIG = """experiment = "coupon"
gauge_length_mm = 33.0
area_mm2 = 9.0
[noise]
force_N = 0.05
[protocol]
can_vary = ["coupon"]
"""


@pytest.mark.slow
@pytest.mark.usefixtures("threads")
def test_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Softening is seen on loading, relaxation only with another branch, a hold or another rate."""
    (tmp_path / "rig.toml").write_text(RIG, encoding="utf-8")
    out = tmp_path / "out"
    options = [str(tmp_path / "rig.toml"), "--workers", "1", "--out", str(out),
               "--effects", "mooney_rivlin,ogden_terms,prony"]  # fmt: skip
    assert run_command("plan-experiment", *options) == 0
    said = capfd.readouterr().out
    found = PlanFile.read(out / "plan.json")
    effects = {each.effect: each for each in found.effects}
    assert effects["mooney_rivlin"].strength_sigma > 2 * effects["prony"].strength_sigma
    assert effects["mooney_rivlin"].named_from is not None
    assert effects["mooney_rivlin"].ordinary.startswith("C01_MPa = ")
    assert "ogden_terms" in effects["prony"].confused_with
    assert effects["prony"].named_from is None
    additions = {each.name: each for each in found.additions}
    assert additions["a coupon, loading and unloading"].share > found.share + 0.1
    assert "prony" in additions["a coupon, loading and unloading"].lifts
    assert found.additions[0].gain_per_minute == max(a.gain_per_minute for a in found.additions)
    assert "prony" in said
    assert "these effects alone were compared" in found.warnings[-1]
    assert {"plan.json", "plan.md", "plan.png"} <= {each.name for each in out.iterdir()}
    # nothing is simulated: the same where nothing may be
    few = ["--with", "can_vary=[]"]
    assert run_command("plan-experiment", *options, *few, "--quick") == 0
    again = PlanFile.read(out / "plan.json")
    assert again.effects == found.effects
    assert again.additions == ()


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        (["--with", "cycles=0"], "cycles = 0: allowed: at least 1"),
        (["--with", "tip=maybe"], 'tip = "maybe": allowed: true, false'),
        (["--with", 'can_vary=["luck"]'], "can_vary = luck: allowed: unloading, cycles"),
        (["--with", "colour=1"], "colour: unknown key"),
        (["--noise", "force_N=-1"], "--noise force_N = -1: allowed"),
        (["--effects", "magic"], "--effects magic: allowed"),
        (["nowhere.toml"], "nowhere.toml: no such file"),
    ],
)
def test_bad_input_is_one_line(
    options: list[str],
    complaint: str,
    tmp_path: Path,
    capfd: pytest.CaptureFixture[str],
) -> None:
    assert run_command("plan-experiment", *options, "--out", str(tmp_path / "out")) == 2
    errors = capfd.readouterr().err
    assert complaint in errors
    assert errors.count("\n") == 1


def test_every_addition_that_a_rig_may_vary_is_proposed() -> None:
    paper, _ = rig.read(None, Config())
    at_rest = {each.kind for each in proposals(paper, Config())}
    filled = Config().changed(supply={"source": "ideal"})
    moving = proposals(paper, filled)
    assert at_rest | {each.kind for each in moving} == set(rig.KINDS)
    times = [each.measurement.listed["time_s"].max() for each in moving]
    lasts = [paper.rows(number)["time_s"].max() for number in (0, 0, 1, 1)]
    assert times == pytest.approx([by * s for by, s in zip([2, 0.5] * 2, lasts, strict=True)])
    assert not np.any([each.measurement.listed["value"] for each in moving])


def test_an_addition_is_read_by_the_rigs_instruments() -> None:
    """Its readings are 0 and alike, which tells nothing of the noise."""
    paper, _ = rig.read(None, Config(), noise={"angle_deg": 0.1})
    for proposal in proposals(paper, Config()):
        found, _ = instrument_noise(read_alike(proposal, paper))
        columns = proposal.measurement.listed["column"]
        assert (found.independent[columns == "force_N"] == 0.02).all()
        assert (found.independent[columns == "angle_deg"] == 0.1).all()


def test_an_addition_tells_how_it_is_made() -> None:
    """A program that leads the rig needs no sentence: rows, columns, and what is set otherwise."""
    paper, _ = rig.read(None, Config())
    by_kind = {each.kind: each for each in proposals(paper, Config())}
    away, up, down = *by_kind["gap"].tests, *by_kind["orientation"].tests
    assert away.experiment == "blocked_force"
    assert away.control == "pressure_kPa"
    assert away.read == ("force_N",)
    assert away.settings["plate.gap_mm"] == Config().plate.gap_mm + 2
    assert [each.settings["gravity.direction"][2] for each in (up, down)] == [1.0, -1.0]
    (loop,) = by_kind["unloading"].tests
    assert len(loop.value) == len(loop.time_s) == len(loop.branch) == 21
    assert loop.value[0] == loop.value[-1] == 0
    assert loop.value[10] == max(loop.value) == 250
    assert loop.branch[10:12] == ("loading", "unloading")
    assert by_kind["coupon"].quantities == ()
    (pulled,) = coupon_check(Policy()).quantities
    assert (pulled.key, pulled.configured, pulled.std) == ("modulus", 1.0, 0.05)


def test_a_rig_that_is_none(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text("protocol = 3\n", encoding="utf-8")
    with pytest.raises(ConfigError, match="allowed: a table"):
        rig.read(tmp_path / "rig.toml", Config())
