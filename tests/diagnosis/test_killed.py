"""A diagnosis that is killed goes on where it was, and computes nothing twice."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from support.example import EXAMPLES
from typer.testing import CliRunner

from dolfingrip.cli.commands import app
from dolfingrip.config import ConfigError
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.jobs.spool import Spool
from dolfingrip.jobs.store import Store

COUPONS = EXAMPLES / "coupons/ninjaflex_uniaxial.csv"
KILLED_AFTER = 6
"""Simulations: base and three shapes are five of seven, so that a fit is going on, and all forms
are compiled."""


def finished(folder: Path) -> dict[str, str]:
    """When each simulation whose result is on the disk was begun, by its key."""
    try:
        with Store(folder) as store:
            rows = [row for row in store.rows() if row["status"] != "pending"]
    except ConfigError:
        return {}
    found = {answer.key: str(answer.started_at) for answer in Spool(folder / "spool").answers()}
    return found | {row["key"]: str(row["started_at"]) for row in rows}


def arguments(out: Path) -> list[str]:
    # with a raster that is turned a coupon has no closed form
    raster = [f"extensions.print_anisotropy.{each}" for each in ("k_MPa=0.1", "raster_deg=5.0")]
    sets = [text for each in raster for text in ("--set", each)]
    options = ["--effects", "prony", "--workers", "1", "--out", str(out), *sets]
    return ["diagnose", str(COUPONS), *options]


@pytest.mark.slow
def test_killed_in_the_middle(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    """What is killed is a process with a worker of its own; what goes on runs here."""
    out = tmp_path / "out"
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "dolfingrip", *arguments(out)],
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
    )  # fmt: skip
    while len(finished(out / "simulations")) < KILLED_AFTER:
        assert process.poll() is None, process.stdout and process.stdout.read()
        time.sleep(0.1)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    assert process.stdout is not None
    process.stdout.read()  # its workers hold the other end
    before = finished(out / "simulations")
    assert not (out / "diagnosis.json").exists()
    request.getfixturevalue("threads")
    done = CliRunner().invoke(app, arguments(out))
    assert done.exit_code == 0, done.output
    after = finished(out / "simulations")
    assert len(after) > len(before) >= KILLED_AFTER
    assert {key: after[key] for key in before} == before
    resumed = DiagnosisFile.read(out)
    # a third run computes nothing, and says the same
    done = CliRunner().invoke(app, arguments(out))
    assert done.exit_code == 0, done.output
    assert finished(out / "simulations") == after
    assert DiagnosisFile.read(out) == resumed
