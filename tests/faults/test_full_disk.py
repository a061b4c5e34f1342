"""Every command that writes, on a full disk: one line, exit code 1, and nothing has changed."""

from __future__ import annotations

import errno
import re
import sys
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path

import pytest
from support import analytic, posteriors, stand_in
from support.command import run_command
from support.disks import Disk, MemoryDisk
from support.example import EXAMPLES
from typer.testing import CliRunner

from dolfingrip import config
from dolfingrip.cli import app as cli
from dolfingrip.cli.commands import COMMANDS, app
from dolfingrip.design.campaign import campaign
from dolfingrip.design.surrogate.surrogate import load
from dolfingrip.design.surrogate.training import TrainingSettings, train
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.explore import server
from dolfingrip.files.whole import WriteError
from dolfingrip.jobs.spool import Spool
from dolfingrip.meshes import files
from dolfingrip.sections.posterior import PosteriorTable, WeightedFit
from dolfingrip.sections.tables import assignments
from dolfingrip.serving.guard import Handover

SHORT = (
    "mesh.size_mm=8", "mesh.edge_size_mm=8", "finger.length_mm=38", "finger.bellows=2",
    "experiment.max_pressure_kPa=20", "experiment.step_kPa=10", "cog.x_ref_mm=9",
)  # fmt: skip
OPTIONS = [text for each in SHORT for text in ("--set", each)]
ROOM = 65_536
"""Bytes that are enough for the record of a run, and not for its fields."""

COUPON = EXAMPLES / "coupons" / "ecoflex30_uniaxial.csv"

Refuse = Callable[..., str]
"""Runs a command; its one line."""

NAMES = ("--input", "morph.xi1", "--input", "morph.xi2", "--output", "cog_offset_mm", "--output",
         "force_N")  # fmt: skip
PAPER = Path(__file__).resolve().parents[2] / "examples" / "paper_study.toml"


@pytest.fixture
def refuse(
    disk: Disk, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Refuse:
    def run(*arguments: object, names: str, left: int = 0, changed: bool = False) -> str:
        """Run a command on the full disk.

        Args:
            arguments: of the command.
            names: the file that its line names, in the disk's folder.
            left: bytes that can be written.
            changed: whether other files may have changed before.
        """
        before = disk.contents()
        monkeypatch.setattr(sys, "argv", ["dolfingrip", *map(str, arguments)])
        capsys.readouterr()
        with disk.full(left), pytest.raises(SystemExit) as ended:
            cli.main()
        said = capsys.readouterr()
        line = rf"dolfingrip: {disk.folder}/{re.escape(names)}: cannot be written: {disk.reason}.*"
        assert re.fullmatch(line + r"\n", said.err), said.err
        assert ended.value.code == 1
        assert f"wrote {disk.folder}/{names}" not in said.out
        after = disk.contents()
        assert not [name for name in after if ".part" in name]
        assert changed or after.get(names) == before.get(names)
        if not changed:
            assert after == before
        return said.err

    return run


@pytest.fixture(scope="module")
def mesh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A mesh of the short finger."""
    file = tmp_path_factory.mktemp("mesh") / "finger.msh"
    files.write(
        file,
        solid(config.load(None, assignments([*SHORT, "mesh.size_mm=3", "mesh.edge_size_mm=3"]))),
    )
    return file


@pytest.mark.parametrize("left", [0, 8192])
@pytest.mark.parametrize("suffix", [".msh", ".inp", ".vtk", ".vtu"])
def test_morph(suffix: str, left: int, mesh: Path, disk: Disk, refuse: Refuse) -> None:
    """As it was seen: gmsh wrote 40,960 of 122,479 bytes, and `morph` told that it wrote them."""
    target = disk.folder / f"moved{suffix}"
    files.write(target, files.read(mesh))
    assert target.stat().st_size > 12_288
    asked = ("morph", mesh, "--out", target, "--xi", "0.1", "0.1", *OPTIONS)
    said = refuse(*asked, names=target.name, left=left)
    assert re.search(r"[\d,]+ (of [\d,]+ )?bytes (are|were) ", said)


def test_mesh(disk: Disk, refuse: Refuse) -> None:
    asked = ("mesh", "--out", disk.folder, *OPTIONS)
    refuse(*asked, names="finger.msh")
    (disk.folder / "finger.msh").write_bytes(b"another mesh")
    refuse(*asked, names="finger.msh", left=20_000)


@pytest.mark.parametrize("name", [f"finger.{end}" for end in ("stl", "step", "toml", "3mf", "inp")])
def test_export(name: str, disk: Disk, refuse: Refuse) -> None:
    if not name.endswith(".toml"):  # which is refused for what it holds
        (disk.folder / name).write_bytes(b"another finger")
    refuse("export", disk.folder / name, *OPTIONS, names=name, left=4096 * (name[-1] != "l"))


def test_a_mould(disk: Disk, refuse: Refuse) -> None:
    asked = ("export", "--mould", disk.folder / "mould", "--set", "finger.kind=cast")
    refuse(*asked, names="mould/half_1.stl")


@pytest.mark.parametrize(
    "command", ["bend", "force", "cycle", "push", "vibrate", "coupon", "grasp"]
)
def test_the_record_of_a_run(command: str, disk: Disk, refuse: Refuse) -> None:
    (disk.folder / "run.json").write_text("{}", encoding="utf-8")
    own = ("--set", "gripper.preset=coarse") if command == "grasp" else OPTIONS
    refuse(command, "--out", disk.folder, *own, names="run.json")


def test_the_fields_of_a_run(disk: Disk, refuse: Refuse) -> None:
    """The record says why the run has ended, and no part of the fields is cut."""
    asked = ("bend", "--out", disk.folder, *OPTIONS)
    refuse(*asked, names="fields_p0_000000.vtu", left=ROOM, changed=True)
    after = disk.contents()
    assert b'"complete": false' in after["run.json"]
    assert b"WriteError" in after["run.json"]
    assert set(after) <= {"run.json", "result.toml", "result.csv", "fields000000.pvtu"}
    assert len(after["result.csv"].splitlines()) == 1


def test_the_demo(disk: Disk, refuse: Refuse) -> None:
    asked = ("demo", "--out", disk.folder, *OPTIONS)
    refuse(*asked, names="bending/run.json")


@pytest.fixture(scope="module")
def surrogate(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of one that has hardly learnt."""
    folder = tmp_path_factory.mktemp("surrogate")
    train(stand_in.table(), TrainingSettings(epochs=20)).surrogate.save(folder)
    return folder


@pytest.fixture
def table(tmp_path: Path) -> Path:
    return stand_in.write_csv(tmp_path / "designs.csv")


@pytest.mark.usefixtures("surrogate")  # torch writes files when it is used first
def test_train(table: Path, disk: Disk, refuse: Refuse) -> None:
    asked = ("train", table, *NAMES, "--out", disk.folder, "--epochs", 20)
    refuse(*asked, names="learning_curve.csv")


def test_a_surrogate_is_replaced_as_a_whole(surrogate: Path, disk: Disk) -> None:
    """Its weights have room; its description, which must belong to them, has none."""
    known = load(surrogate)
    known.save(disk.folder)
    before = disk.contents()
    longer = known.facts.model_copy(update={"settings": {"note": "long" * 10_000}})
    known = replace(known, facts=longer)
    with disk.full(left=20_480), pytest.raises(WriteError, match=r"surrogate\.json: cannot be"):
        known.save(disk.folder)
    assert disk.contents() == before


def test_optimise(surrogate: Path, disk: Disk, refuse: Refuse) -> None:
    small = ("--population", 20, "--generations", 3, "--no-resolve")
    refuse("optimise", surrogate, "--out", disk.folder, *small, names="front.csv")


def test_study(surrogate: Path, disk: Disk, refuse: Refuse) -> None:
    small = ("--population", 20, "--generations", 3, "--seeds", 2, "--processes", 1, "--at-most", 3)
    asked = ("study", surrogate, "--out", disk.folder, *small)
    refuse(*asked, names="campaign.sqlite", changed=True)


@pytest.mark.usefixtures("threads")
def test_doe(disk: Disk, refuse: Refuse, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is in the store stays, and the same command goes on once there is room."""
    out = disk.folder / "doe"
    asked = ("doe", "--objective", analytic.PATH, "--points", "sobol", "--out", out, "--number")
    refuse(*asked, 3, names="doe/campaign.sqlite", changed=True)

    def answered() -> int:
        return sum(row.status != "pending" for row in campaign.read(out).designs)

    assert CliRunner().invoke(app, [*map(str, asked), "3"]).exit_code == 0
    refuse(*asked, 5, names="doe/campaign.sqlite", changed=True)
    assert answered() == 3
    # a limit of files' sizes also holds for the memory that SQLite shares beside what it reads
    limited = not isinstance(disk, MemoryDisk)
    table = "campaign.sqlite" if limited else "designs.csv"
    refuse("doe", "export", "--out", out, names=f"doe/{table}", changed=limited)
    with monkeypatch.context() as patch:
        patch.setattr(Spool, "write", _full(out / "spool" / "answer.json", disk))
        refuse(*asked, 5, names="doe/spool/answer.json", left=4 << 20, changed=True)
    assert answered() == 3
    assert CliRunner().invoke(app, [*map(str, asked), "5"]).exit_code == 0
    assert answered() == 5


def _full(file: Path, disk: Disk) -> Callable[..., None]:
    """A method that finds the disk full."""

    def write(self: object, answer: object) -> None:
        raise WriteError(errno.ENOSPC, disk.reason, str(file))

    return write


def test_report(table: Path, disk: Disk, tmp_path: Path, refuse: Refuse) -> None:
    trained = tmp_path / "surrogate"
    asked = ["train", str(table), *NAMES, "--out", str(trained), "--epochs", "20"]
    assert run_command(*asked) == 0
    (disk.folder / "r.html").write_bytes(b"another page")
    refuse("report", trained, "--out", disk.folder / "r.html", names="r.html", left=4096)


def test_explore(disk: Disk, refuse: Refuse, monkeypatch: pytest.MonkeyPatch) -> None:
    """The address of the server is handed over by a file in the cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(disk.folder))
    file = Handover.of(disk.folder).file.relative_to(disk.folder)
    monkeypatch.setattr(server, "serve", lambda *given: given[-1]("http://localhost/?token=t"))
    refuse("explore", "--out", disk.folder, "--port", 0, names=str(file))


def test_synthetic(disk: Disk, refuse: Refuse) -> None:
    asked = ("synthetic", "--experiments", "coupon", "--set", "coupon.max_strain=0.1")
    refuse(*asked, "--out", disk.folder, names="measured.csv")


def test_adopt(tmp_path: Path, disk: Disk, refuse: Refuse) -> None:
    part = tmp_path / "part.msh"
    files.write(
        part, solid(config.load(None, assignments([*SHORT, "mesh.half=false", "mesh.order=1"])))
    )
    refuse("adopt", part, "--out", disk.folder, names="adopted.msh", left=8192)


@pytest.mark.parametrize(
    "command", [("pickup", "--friction", "0.38"), ("friction", "--pickup-pressure", "60")]
)
def test_pickup(command: tuple[str, ...], disk: Disk, refuse: Refuse) -> None:
    asked = (*command, "--preset", "coarse", "--out", disk.folder)
    refuse(*asked, names="simulations/campaign.sqlite", changed=True)


def test_robot(disk: Disk, refuse: Refuse) -> None:
    refuse(
        "robot", "--out", disk.folder, *OPTIONS, names="simulations/campaign.sqlite", changed=True
    )


def test_design(disk: Disk, refuse: Refuse) -> None:
    file = EXAMPLES / "paper_design.toml"
    refuse("design", file, "--out", disk.folder, names="simulations/campaign.sqlite", changed=True)


def test_diagnose(disk: Disk, tmp_path: Path, refuse: Refuse) -> None:
    """With a tenth of the coupon's readings."""
    head, *rows = COUPON.read_text(encoding="utf-8").splitlines()
    few = tmp_path / "few.csv"
    few.write_text("\n".join([head, *rows[::10]]) + "\n", encoding="utf-8")
    few.with_suffix(".toml").write_bytes(COUPON.with_suffix(".toml").read_bytes())
    asked = ("diagnose", few, "--out", disk.folder, "--effects", "force_gain", "--quick")
    refuse(*asked, names="extended.toml", changed=True)


def test_predict(disk: Disk, tmp_path: Path, refuse: Refuse) -> None:
    fits = tmp_path / "extended.toml"
    settings = config.dumps(config.load(None, assignments([*SHORT, "experiment.step_kPa=2"])))
    fits.write_text(
        posteriors.appended(settings, PosteriorTable(fit=(WeightedFit(),))), encoding="utf-8"
    )
    asked = ("predict", "--from", fits, "--pressures", "5", "--out", disk.folder)
    refuse(*asked, names="fit-1/run.json", changed=True)


def test_reproduce(disk: Disk, refuse: Refuse) -> None:
    pytest.importorskip("torch", reason="the extra surrogate brings it")
    refuse("reproduce", PAPER, "--out", disk.folder, names="doe/campaign.sqlite", changed=True)


def test_plan_experiment(disk: Disk, refuse: Refuse) -> None:
    asked = ("plan-experiment", "--with", 'can_vary=["orientation"]', "--effects", "force_gain")
    refuse(
        *asked, "--quick", "--out", disk.folder, names="simulations/campaign.sqlite", changed=True
    )


def test_coupon(disk: Disk, refuse: Refuse) -> None:
    asked = ("coupon", "--fit", COUPON, "--law", "yeoh", "--out", disk.folder)
    refuse(*asked, names="material.toml")


def test_import(disk: Disk, tmp_path: Path, refuse: Refuse) -> None:
    table = tmp_path / "raw.csv"
    rows = [f"{p},{p / 10}" for p in range(0, 100, 10)]
    table.write_text("\n".join(["pressure [kPa],angle [deg]", *rows]) + "\n", encoding="utf-8")
    asked = ("import", table, "--out", disk.folder, "--experiment", "bending", "--rate", 10)
    refuse(*asked, names="raw.csv")


def test_supply(disk: Disk, tmp_path: Path, refuse: Refuse) -> None:
    curve = tmp_path / "wished.csv"
    curve.write_text("time_s,pressure_kPa\n0,0\n1,5\n", encoding="utf-8")
    asked = ("supply", curve, "--every", 0.5, *OPTIONS, "--out", disk.folder)
    refuse(*asked, names="commands.csv")


def test_track(disk: Disk, refuse: Refuse) -> None:
    """The sheet that is printed; a video's table is written as that of `import` is."""
    refuse("track", "--sheet", "a4", "--out", disk.folder / "sheet.pdf", names="sheet.pdf")


def test_every_command_that_writes_is_here() -> None:
    every = [each for command in COMMANDS for each in (command, *command.below)]
    writes = [
        each.name for each in every if {"out", "file"} & {key.name for key in fields(each.settings)}
    ]
    assert {"bend", "grasp", "export", "diagnose", "doe", "friction"} <= set(writes)
    source = Path(__file__).read_text(encoding="utf-8")
    assert not [name for name in writes if f'"{name}"' not in source]
