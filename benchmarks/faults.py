"""Faults of the machine, injected for minutes: what they led to.

    scripts/faults [--only PART…] [--kills 50] [--ranks 25] [--jobs 300] [--seed 0] [--out FILE.csv]

=========== ==================================================================================
processes   SIGKILL of clients and of workers of a campaign at random moments; the same command is
            called until it ends
ranks       SIGKILL of one rank of a simulation on two, at random moments
disks       a full disk in every command that writes (``tests/faults/test_full_disk.py``)
damage      every damage of store and spool (``tests/faults/test_damage.py``)
memory      one process that computes many simulations of a coupon
=========== ==================================================================================

The table has for each part the number of faults, how many of them lost or changed a result, and a
sentence. Rows of parts that are not asked for stay.
"""

from __future__ import annotations

import argparse
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import pandas as pd
from support import analytic
from support.ranks import killed_ranks
from support.this_process import ThisProcess

from dolfingrip import config
from dolfingrip.design.campaign import campaign
from dolfingrip.experiments.request import Request
from dolfingrip.experiments.simulate import simulate
from dolfingrip.files import table

ROOT: Final = Path(__file__).parents[1]
GRID: Final = ("--parameter", "morph.xi1=-0.2:1:12", "--parameter", "morph.xi2=-0.5:1:10")
DESIGN_S: Final = 0.2
"""Seconds that a design takes."""

FINGER: Final = {
    "mesh.size_mm": 6.0, "mesh.edge_size_mm": 6.0, "finger.length_mm": 38.0, "finger.bellows": 2,
    "experiment.max_pressure_kPa": 10.0, "experiment.step_kPa": 10.0,
}  # fmt: skip

Row = dict[str, Any]


def _results(folder: Path) -> dict[str, tuple[str, str]]:
    rows = campaign.read(folder).by_key()
    return {key: (row.status, repr(row.outputs)) for key, row in rows.items()}


def _workers(client: int) -> list[int]:
    """Processes below a client that compute."""
    found = subprocess.run(
        ["ps", "-eo", "pid=,ppid=,args="], capture_output=True, text=True, check=True
    )
    lines = [line.split(None, 2) for line in found.stdout.splitlines()]
    return [int(p) for p, parent, args in lines if int(parent) == client and "spawn" in args]


def processes(asked: argparse.Namespace, folder: Path) -> Row:
    """Kill clients and workers of a campaign until it has come to its end."""
    rng = random.Random(asked.seed)
    command = [sys.executable, "-P", "-m", "dolfingrip", "doe", "--objective", analytic.PATH, *GRID]
    log = folder / "log"
    environment = {**os.environ, "DOLFINGRIP_TEST_SECONDS": str(DESIGN_S)}
    whole = subprocess.run([*command, "--out", folder / "whole"], stdout=-3, check=True)
    assert whole.returncode == 0
    expected = _results(folder / "whole")
    killed, calls, lost, number = 0, 0, 0, 0
    while killed < asked.kills:
        number += 1
        out, before = folder / f"killed{number}", {}
        noted = {**environment, "DOLFINGRIP_TEST_LOG": f"{log}{number}"}
        while True:
            calls += 1
            client = subprocess.Popen(
                [*command, "--out", out, "--workers", "2"], env=noted, stdout=-3, stderr=-3
            )
            while client.poll() is None and killed < asked.kills:
                time.sleep(rng.uniform(1.0, 6.0))
                workers = _workers(client.pid)
                one = rng.choice(workers) if workers and rng.random() < 0.5 else client.pid
                with suppress(ProcessLookupError):
                    os.kill(one, signal.SIGKILL)
                    killed += 1
            code = client.wait()
            if (out / "campaign.sqlite").exists():
                now = _results(out)
                lost += sum(now.get(k) != v for k, v in before.items() if v[0] != "pending")
                before = now
            if code == 0:
                break
        lost += sum(before.get(key) != value for key, value in expected.items())
        lost += len(before) - len(expected)
    return {"faults": killed, "bad": lost, "said": f"{calls} calls, {number} campaigns of 120"}


def ranks(asked: argparse.Namespace, folder: Path) -> Row:
    """Kill a rank of most runs, at most two of one simulation in a row."""
    rng = random.Random(asked.seed)
    row = 0
    finger = config.load(None, dict(FINGER))
    began_s = time.monotonic()
    simulate([Request.of("bending", finger, ranks=2)], folder / "timed", ThisProcess())
    lasts_s = time.monotonic() - began_s

    def chosen(before: int) -> float | None:
        nonlocal row
        row = 0 if row == 2 or rng.random() < 0.2 else row + 1
        return rng.uniform(0.0, lasts_s) if row else None

    killed, lost, designs = 0, 0, 0
    while killed < asked.ranks:
        designs += 1
        one = config.changed(finger, {"material.mu_MPa": 2.0 + 0.1 * designs})
        (expected,) = simulate([Request.of("bending", one)], folder / "alone", ThisProcess())
        row = 0
        with killed_ranks(chosen, asked.seed + designs) as ended:
            request = Request.of("bending", one, ranks=2)
            (found,) = simulate([request], folder / "ranks", ThisProcess())
        killed += len(ended)
        angles = [list(each.columns["angle_deg"]) for each in (expected, found)]
        apart = max(abs(a - b) for a, b in zip(*angles, strict=True))
        lost += int(found.failure_class is not None or apart > 1e-4)
        sys.stdout.write(f"ranks: {killed} killed, {designs} designs, {lost} lost\n")
        sys.stdout.flush()
    return {"faults": killed, "bad": lost, "said": f"{designs} designs; each has its angle"}


def _tests(name: str) -> Callable[[argparse.Namespace, Path], Row]:
    def run(asked: argparse.Namespace, folder: Path) -> Row:
        command = [sys.executable, "-m", "pytest", "-n0", "-m", "", "-q", f"tests/faults/{name}"]
        ended = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
        last = ended.stdout.splitlines()[-1]
        counts = {word: int(n) for n, word in re.findall(r"(\d+) (passed|failed|error)", last)}
        bad = counts.get("failed", 0) + counts.get("error", 0) + (ended.returncode != 0)
        return {"faults": sum(counts.values()), "bad": bad, "said": name}

    return run


def memory(asked: argparse.Namespace, folder: Path) -> Row:
    """The largest memory after a tenth of the simulations, and after all."""
    base = config.load(None, {"coupon.max_strain": 0.1, "coupon.step_strain": 0.05})

    def peak_MB() -> float:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024

    first, failed = 0.0, 0
    for number in range(asked.jobs):
        one = config.changed(base, {"material.mu_MPa": 1.0 + number / asked.jobs})
        (found,) = simulate([Request.of("coupon", one)], folder / "coupons", ThisProcess())
        failed += found.failure_class is not None
        if number + 1 == max(asked.jobs // 10, 1):
            first = peak_MB()
    grown = peak_MB() - first
    said = f"{first:.0f} MB after a tenth, {grown:.1f} MB more at the end"
    return {"faults": asked.jobs, "bad": failed + (grown > 0.1 * first), "said": said}


PARTS: Final = {
    "processes": processes,
    "ranks": ranks,
    "disks": _tests("test_full_disk.py"),
    "damage": _tests("test_damage.py"),
    "memory": memory,
}


def main() -> None:
    """Inject faults, and write the table."""
    parser = argparse.ArgumentParser(prog="scripts/faults")
    parser.add_argument("--only", nargs="*", choices=PARTS, default=list(PARTS))
    parser.add_argument("--kills", type=int, default=50)
    parser.add_argument("--ranks", type=int, default=25)
    parser.add_argument("--jobs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path)
    asked = parser.parse_args()
    sys.stdout.write(f"seed {asked.seed}\n")
    rows: dict[str, Row] = {}
    if asked.out is not None and asked.out.exists():
        rows = {row["part"]: row for row in pd.read_csv(asked.out).to_dict("records")}
    for part in asked.only:
        with tempfile.TemporaryDirectory(prefix="faults-", ignore_cleanup_errors=True) as folder:
            rows[part] = {"part": part, **PARTS[part](asked, Path(folder))}
        sys.stdout.write(f"{rows[part]}\n")
        sys.stdout.flush()
        if asked.out is not None:
            table.write(asked.out, [rows[each] for each in PARTS if each in rows])
    raise SystemExit(1 if any(rows[part]["bad"] for part in asked.only) else 0)


if __name__ == "__main__":
    main()
