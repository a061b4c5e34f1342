"""Processor seconds of free bending with Debian's DOLFINx, and with PyPI's by CHOLMOD and by MUMPS.

    .ci/wheel && scripts/run python -m benchmarks.stacks out/wheel/venv/bin/python

The three take turns, so that what else the machine does meets all of them alike. Forms are compiled
before the first turn that counts.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

ROUNDS = 5
PROGRAM = """
import sys
from dolfingrip.cli.app import main
from dolfingrip.mechanics.newton import cholmod
if sys.argv[1] == "MUMPS":
    cholmod.available = lambda: False
assert cholmod.available() == (sys.argv.pop(1) == "CHOLMOD")
main()
"""


def processor_s(python: Path, factors: str, out: Path) -> float:
    """Processor seconds of one run (s), this Python's own start included.

    Args:
        python: with the package.
        factors: CHOLMOD or MUMPS.
        out: folder for results.
    """
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    alone = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    command = [python, "-c", PROGRAM, factors, "bend", "--out", out]
    subprocess.run(command, cwd=out, env=alone, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print the processor seconds of each, and by how much more they are than Debian's."""
    wheel = Path(sys.argv[1]).absolute()
    stacks = {
        "Debian, CHOLMOD": (Path(sys.executable), "CHOLMOD"),
        "PyPI, CHOLMOD": (wheel, "CHOLMOD"),
        "PyPI, MUMPS": (wheel, "MUMPS"),
    }
    spent: dict[str, list[float]] = {name: [] for name in stacks}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(ROUNDS + 1):
            for name, (python, factors) in stacks.items():
                found = processor_s(python, factors, Path(folder))
                if turn:
                    spent[name].append(found)
                print(f"{name}: {found:.1f} s", flush=True)
    least = {name: min(each) for name, each in spent.items()}
    for name, value in least.items():
        print(f"{name}: least {value:.1f} s, {value / least['Debian, CHOLMOD']:.2f} of Debian's")


if __name__ == "__main__":
    main()
