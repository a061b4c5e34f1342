"""Campaigns on local processes: resumed, killed at random moments, with progress."""

from __future__ import annotations

import csv
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest
from support import analytic
from support.campaign_store import failures
from support.command import run_command
from typer.testing import CliRunner, Result

from dolfingrip.cli.commands import app
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.jobs import pool
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.connections import broken_connections_are_errors
from dolfingrip.jobs.pool import Unfinished
from dolfingrip.jobs.run import Standing
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import Store
from dolfingrip.jobs.work import work

TESTS = Path(__file__).parents[1]
GRID = ("--parameter", "morph.xi1=-0.2:1:6", "--parameter", "morph.xi2=-0.5:1:4")
COMMAND = (sys.executable, "-P", "-m", "dolfingrip", "doe", "--objective", analytic.PATH)


def environment(log: Path, seconds: float) -> dict[str, str]:
    noted = {"DOLFINGRIP_TEST_LOG": str(log), "DOLFINGRIP_TEST_SECONDS": str(seconds)}
    return {**os.environ, **noted, "PYTHONPATH": str(TESTS)}


def started(log: Path) -> list[tuple[float, float]]:
    """Inputs of every design that was begun, in order."""
    if not log.exists():
        return []
    lines = log.read_text(encoding="utf-8").splitlines()
    return [(float(a), float(b)) for a, b, _ in map(str.split, lines)]


def finished(folder: Path) -> set[tuple[float, float]]:
    """Inputs of the designs whose answer is on the disk."""
    if not (folder / "campaign.sqlite").exists():
        return set()
    rows = campaign.read(folder).by_key()
    spooled = {answer.key for answer in Spool(folder / "spool").answers()}
    inputs = [row.inputs for key, row in rows.items() if row.status != "pending" or key in spooled]
    return {(point["morph.xi1"], point["morph.xi2"]) for point in inputs}


def ended(process: subprocess.Popen[str]) -> None:
    """Wait until a killed client's workers are gone too."""
    process.wait()
    assert process.stdout is not None
    process.stdout.read()  # they hold its other end


@pytest.mark.usefixtures("threads")
def test_derivatives_survive_a_killed_client(tmp_path: Path) -> None:
    """Answers that a killed client left in the spool bring their derivatives with them."""
    out = tmp_path / "doe"
    wanted = replace(small(-0.1, 0.3, 0.9), gradients=("morph.xi1", "morph.xi2"))
    spool = Spool(out / "spool")
    spool.folder.mkdir(parents=True)
    work(wanted.jobs()[0], spool.folder)
    standing = campaign.run(wanted, out, Where(workers=1))
    assert (standing.computed, standing.done, standing.failed) == (2, 2, 1)
    found = campaign.sensitivities(out).to_pylist()
    expected = [
        {"row": row, "column": column, "parameter": key, "derivative": slope}
        for row in (0, 1)  # the third design fails
        for column, slopes in analytic.SLOPES.items()
        for key, slope in slopes.items()
    ]
    assert found == expected
    assert campaign.write_sensitivities(out, out / "sensitivity.csv") == len(expected)
    lines = (out / "sensitivity.csv").read_text(encoding="utf-8").splitlines()
    assert lines[1] == '0,"cog_offset_mm","morph.xi1",1'
    # a campaign of other derivatives is another one
    for other in (None, ("morph.xi1",)):
        with pytest.raises(ConfigError, match="gradients was"):
            campaign.run(replace(wanted, gradients=other), out, Where(workers=1))


@pytest.mark.slow
def test_client_killed_at_random_moments_loses_and_repeats_nothing(tmp_path: Path) -> None:
    seed = int(os.environ.get("DOLFINGRIP_TEST_SEED", "2"))
    print(f"seed {seed}")
    moments = random.Random(seed)
    log, out = tmp_path / "log", tmp_path / "doe"
    call = [*COMMAND, "--out", str(out), *GRID, "--workers", "2"]
    kills = 0
    for _ in range(30):
        before, begun = finished(out), len(started(log))
        process = subprocess.Popen(
            call, env=environment(log, 0.1), stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, start_new_session=True,
        )  # fmt: skip
        late = moments.random() < 0.8  # most kills fall among the designs, some before the first
        while late and len(started(log)) == begun and process.poll() is None:
            time.sleep(0.005)
        try:
            process.wait(moments.uniform(0, 1) if kills < 3 else 60)
        except subprocess.TimeoutExpired:
            process.kill()
            kills += 1
        ended(process)
        again = set(started(log)[begun:]) & before
        assert not again, f"computed twice: {again}"
        assert before <= finished(out), "lost"
        if process.returncode == 0:
            break
    assert kills >= 3
    assert process.returncode == 0
    rows = campaign.read(out).designs
    with Store(out) as store:
        assert store.counts()["pending"] == 0
    assert len(rows) == 24
    for row in rows:
        xi1, xi2 = (float(row.inputs[f"morph.{name}"]) for name in ("xi1", "xi2"))
        if xi1 > analytic.FAILING:
            assert (row.status, row.outputs) == ("failed", None)
        else:
            assert row.outputs is not None
            assert row.outputs["force_N"] == 4 + xi1 - xi2
    assert list((out / "spool").iterdir()) == []


@pytest.mark.slow
def test_workers_killed_at_random_moments_lose_and_repeat_nothing(tmp_path: Path) -> None:
    seed = int(os.environ.get("DOLFINGRIP_TEST_SEED", "3"))
    print(f"seed {seed}")
    moments = random.Random(seed)
    log, out = tmp_path / "log", tmp_path / "doe"
    call = [*COMMAND, "--out", str(out), *GRID, "--workers", "2"]
    process = subprocess.Popen(
        call, env=environment(log, 0.2), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    kills = []
    for _ in range(3):
        time.sleep(moments.uniform(0.3, 0.9))
        while not started(log):
            time.sleep(0.01)
        worker = int(log.read_text(encoding="utf-8").splitlines()[-1].split()[2])
        before, begun = finished(out), len(started(log))
        try:
            os.kill(worker, signal.SIGKILL)
        except ProcessLookupError:
            continue
        kills.append((before, begun))
    said = process.communicate(timeout=90)[0]
    assert process.returncode == 0, said
    assert kills
    for before, begun in kills:
        assert not set(started(log)[begun:]) & before
    with Store(out) as store:
        assert store.counts()["pending"] == 0
        assert failures(store) == {"limit point": 8}
    assert "24 designs: 24 computed now, 16 done, 8 failed" in said


@pytest.mark.slow
def test_client_killed_while_a_cluster_computes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The workers outlive the client and finish what they have: nothing is even begun twice."""
    import dask
    from distributed import LocalCluster

    seed = int(os.environ.get("DOLFINGRIP_TEST_SEED", "4"))
    print(f"seed {seed}")
    moments = random.Random(seed)
    log, out = tmp_path / "log", tmp_path / "doe"
    for name, value in environment(log, 0.15).items():
        monkeypatch.setenv(name, value)
    monkeypatch.setenv("DASK_CONFIG", str(with_keys(tmp_path / "home")))
    collected = dask.config.collect([os.environ["DASK_CONFIG"]])
    with (
        broken_connections_are_errors(),
        dask.config.set(dask.config.merge(dask.config.global_config, collected)),
        LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address="127.0.0.1:0"
        ) as cluster,
    ):
        assert cluster.scheduler_address.startswith("tls://")
        call = [*COMMAND, "--out", str(out), *GRID, "--scheduler", cluster.scheduler_address]
        for attempt in range(4):
            begun = len(started(log))
            process = subprocess.Popen(call, stdout=subprocess.PIPE, text=True)
            while attempt < 3 and len(started(log)) == begun and process.poll() is None:
                time.sleep(0.005)
            if attempt < 3:
                time.sleep(moments.uniform(0, 0.5))
                process.kill()
            said = process.communicate(timeout=60)[0]
    assert process.returncode == 0
    assert "16 done, 8 failed" in said
    assert len(started(log)) == len(set(started(log))) == 24


def with_keys(home: Path) -> Path:
    """A folder of keys and Dask's configuration, made as docs/cluster.md tells."""
    page = (TESTS.parent / "docs" / "cluster.md").read_text(encoding="utf-8")
    told = page.replace("/home/me", str(home))
    home.mkdir()
    make = next(block for block in re.findall(r"```sh\n(.*?)```", told, re.S) if "openssl" in block)
    subprocess.run(["sh", "-ec", make], capture_output=True, check=True)
    folder = home / "keys"
    (content,) = re.findall(r"```yaml\n(.*?)```", told, re.S)
    (folder / "dask.yaml").write_text(content, encoding="utf-8")
    return folder


def small(*xi1: float, objective: str = analytic.PATH, **changes: object) -> Plan:
    points = tuple({"morph.xi1": value} for value in xi1)
    return Plan(Config.model_validate(changes), ("morph.xi1",), points, objective=objective)


@pytest.mark.usefixtures("threads")
def test_repeated_call_computes_only_what_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    log, out = tmp_path / "log", tmp_path / "doe"
    monkeypatch.setenv("DOLFINGRIP_TEST_LOG", str(log))
    told: list[tuple[int, int, int]] = []

    def progress(standing: Standing) -> None:
        missing = standing.total - standing.done - standing.failed
        told.append((standing.done, standing.failed, missing))

    first = campaign.run(small(0.1, 0.7), out, Where(), progress=progress)
    assert (first.computed, first.done, first.failed) == (2, 1, 1)
    assert first.classes == {"limit point": 1}
    assert told[0] == (0, 0, 2)
    assert told[-1] == (1, 1, 0)
    second = campaign.run(small(0.1, 0.7, 0.2), out, Where())
    assert (second.total, second.computed, second.done, second.failed) == (3, 1, 2, 1)
    monkeypatch.setattr(pool, "connected", None)  # no worker is started for nothing
    assert campaign.run(small(0.1), out, Where()).computed == 0
    monkeypatch.undo()
    assert len(started(log)) == 3
    monkeypatch.setenv("DOLFINGRIP_TEST_LOG", str(log))
    third = campaign.run(small(0.1, 0.7, 0.2), out, Where(), retry_failed=True)
    assert (third.computed, third.failed) == (1, 1)
    assert len(started(log)) == 4


@pytest.mark.usefixtures("threads")
@pytest.mark.parametrize(("least", "code"), [(0.0, 0), (0.7, 1)])
def test_a_campaign_without_any_result_is_no_success(
    least: float, code: int, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """As of other searches: the exit code is 1 where every design failed, 0 where some did."""
    varied = ("--parameter", f"morph.xi1={least}:0.9:2", "--parameter", "morph.xi2=0.1:0.2:2")
    asked = ("doe", "--objective", analytic.PATH, *varied, "--out", tmp_path / "doe")
    for _ in range(2):  # the second call computes nothing
        assert run_command(*asked) == code
        assert f"{4 if code else 2} failed" in capfd.readouterr().out


def test_interrupt_is_quiet_and_resumed(tmp_path: Path) -> None:
    """Ctrl-C on a terminal reaches the workers too."""
    log, out = tmp_path / "log", tmp_path / "doe"
    process = subprocess.Popen(
        [*COMMAND, "--out", str(out), *GRID], env=environment(log, 0.1), stdout=subprocess.PIPE,
        stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    while len(started(log)) < 3:
        assert process.poll() is None
        time.sleep(0.01)
    os.killpg(process.pid, signal.SIGINT)
    said, errors = process.communicate(timeout=30)
    assert process.returncode == 130
    assert errors == (
        f"dolfingrip: interrupted: what was computed is kept in {out}; "
        "the same command goes on from there\n"
    )
    assert "0 of 24 designs" in said
    assert len(finished(out)) >= 2


def test_a_design_that_kills_its_workers_is_told_and_not_stored(tmp_path: Path) -> None:
    plan = small(0.1, material={"mu_MPa": 6.66})
    with pytest.raises(Unfinished, match=r"^1 of 1 could not be computed .* every worker .* died"):
        campaign.run(plan, tmp_path, Where())
    assert [row.status for row in campaign.read(tmp_path).designs] == ["pending"]


def test_an_existing_cluster_is_used_and_left_running(tmp_path: Path) -> None:
    from distributed import Client, LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as cluster:
        where = Where(scheduler=cluster.scheduler_address)
        assert campaign.run(small(0.1, 0.2), tmp_path, where).done == 2
        with Client(cluster.scheduler_address) as client:
            assert client.submit(len, [1]).result() == 1


def test_no_scheduler_is_one_line(tmp_path: Path) -> None:
    call = [*COMMAND, "--out", str(tmp_path / "doe"), "--scheduler", "nonsense://x:1"]
    done = subprocess.run(
        call, env=environment(tmp_path / "log", 0), capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    lines = [line for line in done.stderr.splitlines() if line.startswith("dolfingrip: ")]
    assert len(lines) == 1
    assert "--scheduler nonsense://x:1" in lines[0]


def called(*arguments: str) -> Result:
    """The command ``doe`` in this process."""
    return CliRunner().invoke(app, ["doe", *arguments])


@pytest.mark.usefixtures("threads")
def test_command_and_export(tmp_path: Path) -> None:
    out = str(tmp_path / "doe")
    # two Sobol points more are two more to compute
    for number, computed in (("3", 3), ("5", 2)):
        objective = ("--objective", analytic.PATH)
        done = called(*objective, "--out", out, "--points", "sobol", "--number", number)
        assert (done.exit_code, done.stderr) == (0, "")
        assert f"{number} designs: {computed} computed now" in done.stdout
    done = called("export", "--out", out)
    assert (done.exit_code, done.stderr) == (0, "")
    assert (tmp_path / "doe" / "designs.parquet").exists()
    text = (tmp_path / "doe" / "designs.csv").read_text(encoding="utf-8")
    assert len(text.splitlines()) == 6
    assert json.dumps("morph.xi1") in text.splitlines()[0]


@pytest.mark.usefixtures("threads")
def test_command_writes_derivatives(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Of the centroid alone, which no finite elements are needed for."""
    out = tmp_path / "doe"
    keys = "finger.wall_mm,material.mu_MPa"
    call = ("--out", str(out), "--parameter", "finger.wall_mm=1.5:1.7:2")
    few = ("--set", "mesh.size_mm=6", "--quantity", "cog_offset_mm")
    asked = ("--gradients", "--parameters", keys)
    done = called(*call, *few, *asked)
    assert (done.exit_code, done.stderr) == (0, "")
    assert f"wrote 4 derivatives: {out / 'sensitivity.csv'}" in done.stdout
    with (out / "sensitivity.csv").open(encoding="utf-8", newline="") as file:
        slopes = list(csv.DictReader(file))
    with (out / "designs.csv").open(encoding="utf-8", newline="") as file:
        first, second = csv.DictReader(file)
    assert [(row["row"], row["parameter"]) for row in slopes] == [
        (row, key) for row in ("0", "1") for key in keys.split(",")
    ]
    # the mean of both ends' slopes is that of the chord but for the third derivative
    rise = float(second["cog_offset_mm"]) - float(first["cog_offset_mm"])
    run = float(second["finger.wall_mm"]) - float(first["finger.wall_mm"])
    mean = (float(slopes[0]["derivative"]) + float(slopes[2]["derivative"])) / 2
    assert mean == pytest.approx(rise / run, rel=5e-3)
    assert float(slopes[1]["derivative"]) == 0.0
    wrong = (("--gradients", "--objective", analytic.PATH), ("--parameters", keys))
    for options, said in zip(wrong, ("without --objective", "with --gradients"), strict=True):
        assert run_command("doe", *call, *options) == 2
        assert f"allowed: {said}" in capfd.readouterr().err
