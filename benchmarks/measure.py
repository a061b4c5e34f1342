"""Processes timed one at a time: wall, processor and memory, and how busy the machine was."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from support.calculix import run as calculix

from benchmarks.job import MARK

ROOT = Path(__file__).resolve().parents[1]


class JobError(RuntimeError):
    """A run that failed, with the last lines of its output."""


def idlest_core(seconds: float = 0.5) -> int:
    """The allowed core that has been idle most during the next moment."""

    def idle() -> dict[int, int]:
        lines = Path("/proc/stat").read_text(encoding="ascii").splitlines()
        table = [line.split() for line in lines if line[:3] == "cpu" and line[3].isdigit()]
        return {int(words[0][3:]): int(words[4]) for words in table}

    before = idle()
    time.sleep(seconds)
    after = idle()
    return max(os.sched_getaffinity(0), key=lambda core: after[core] - before[core])


def _start(spec: dict[str, Any], core: int | None) -> list[str]:
    command = [sys.executable, "-m", "benchmarks.job", json.dumps(spec)]
    if spec.get("ranks", 1) > 1:
        return ["mpirun", "-n", str(spec["ranks"]), *command]
    if core is not None and shutil.which("taskset"):
        return ["taskset", "-c", str(core), *command]
    return command


def run(spec: dict[str, Any], *, pinned: bool = True) -> dict[str, Any]:
    """Run a job in a separate process.

    Args:
        spec: of :mod:`benchmarks.job`, with ``ranks`` where it runs under ``mpirun``.
        pinned: to the idlest core; several ranks never are.

    Returns:
        The job's outcome, with the process' wall and processor time, start-up
        included (``process_s``, ``process_processor_s``), and the load averages of the last
        minute before and after it.

    Raises:
        JobError: where it fails.
    """
    before = os.getloadavg()[0]
    command = _start(spec, idlest_core() if pinned else None)
    environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    start = time.perf_counter()
    with subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as process:
        assert process.stdout is not None
        said = process.stdout.read()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    took = time.perf_counter() - start
    lines = [line for line in said.splitlines() if line.startswith(MARK)]
    if process.returncode or not lines:
        raise JobError(f"{spec}: {said.strip().splitlines()[-1:] or process.returncode}")
    return {
        **json.loads(lines[-1].removeprefix(MARK)),
        "process_s": took,
        "process_processor_s": usage.ru_utime + usage.ru_stime,
        "load": [before, os.getloadavg()[0]],
    }


def run_calculix(command: str, deck: Path) -> dict[str, Any]:
    """Time a deck's run by CalculiX, pinned to the idlest core.

    Args:
        command: CalculiX' executable.
        deck: that is run.

    Returns:
        Times as of :func:`run`.
    """
    before, core = os.getloadavg()[0], idlest_core()
    pin = ["taskset", "-c", str(core)] if shutil.which("taskset") else []
    start, used = time.perf_counter(), os.times()
    calculix(deck, *pin, command)
    took, now = time.perf_counter() - start, os.times()
    processor = now.children_user - used.children_user
    processor += now.children_system - used.children_system
    return {
        "process_s": took,
        "run_s": took,
        "processor_s": processor,
        "load": [before, os.getloadavg()[0]],
    }
