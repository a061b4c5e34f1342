"""Processor times of the examples.

    scripts/run python docs/pictures/gallery.py [NAME…]

runs each example by the command that it names, or those that are named, and writes its time to
``docs/gallery.csv``. All of them take some hours; those of ``docs/gallery.csv`` are of an AMD EPYC.
"""

from __future__ import annotations

import csv
import os
import shlex
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "docs" / "_ext"))

import gallery  # noqa: E402  # it lies beside the pages


def measure(example: Path) -> float:
    """Run an example and return its processor time (s), with that of its processes."""
    command = shlex.split(gallery.command(example))[1:]  # we are inside the environment
    if command[0] == "dolfingrip":
        command = [sys.executable, "-m", *command]
    process = subprocess.Popen(
        command, cwd=ROOT, env={**os.environ, "OMP_NUM_THREADS": "1"},
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    _, status, usage = os.wait4(process.pid, 0)
    if status:
        raise RuntimeError(f"{shlex.join(command)} ended with {os.waitstatus_to_exitcode(status)}")
    return usage.ru_utime + usage.ru_stime


def main(names: list[str]) -> None:
    """Measure the examples that are named, or all."""
    for example in gallery.examples():
        name = str(example.relative_to(ROOT / "examples"))
        if names and example.name not in names and name not in names:
            continue
        seconds = f"{measure(example):.1f}"
        print(name, seconds, flush=True)
        rows = {row: dict(cells) for row, cells in gallery.rows().items()}  # others write it, too
        rows.setdefault(name, {"example": name, "picture": ""})["processor_s"] = seconds
        with gallery.TABLE.open("w", encoding="utf-8", newline="") as text:
            table = csv.DictWriter(text, ["example", "picture", "processor_s"], lineterminator="\n")
            table.writeheader()
            table.writerows(rows.values())


if __name__ == "__main__":
    main(sys.argv[1:])
