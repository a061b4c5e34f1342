"""How long one diagnosis takes: bending and blocked force, three cycles, the whole catalogue.

    scripts/run python -m benchmarks.diagnosis_time [--workers 2]

The measurement is the worked case of ``docs/diagnosis.md``, a viscous reference finger. It is
diagnosed by ``dolfingrip diagnose`` with an empty store. Prints the wall time, the processor time
of all processes, how many simulations were computed, and the verdict. The machine should have
nothing else to do. Forms that were never compiled before take their time, too.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import time
from pathlib import Path
from typing import Final

from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.jobs.store import Store

SYNTHETIC: Final = (
    "--set", "experiment.cycles=3", "--set", "experiment.unload=true",
    "--hide", "extensions.prony.g=[0.25]", "--hide", "extensions.prony.tau_s=[8.0]",
    "--hide", "material.mu_MPa=2.7", "--seed", "4",
)  # fmt: skip
"""The worked case."""


def called(*arguments: str) -> None:
    """Run ``dolfingrip``; what it says is shown."""
    subprocess.run(["dolfingrip", *arguments], check=True)


def processor_s() -> float:
    """Return the processor time of all processes that have ended (s)."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(data: Path, workers: int, out: Path) -> str:
    """Diagnose once, and tell what it took, in one line."""
    shutil.rmtree(out, ignore_errors=True)
    wall, processor = time.monotonic(), processor_s()
    called("diagnose", str(data), "--workers", str(workers), "--out", str(out))
    wall, processor = time.monotonic() - wall, processor_s() - processor
    with Store(out / "simulations") as store:
        count = len(list(store.rows()))
    verdict = DiagnosisFile.read(out).verdict
    return (
        f"{wall / 60:.1f} min on {workers} workers ({os.cpu_count()} cores), "
        f"processor {processor:.0f} s, {count} simulations; "
        f"{verdict.answer}: {', '.join((*verdict.effects, *verdict.second))} "
        f"({verdict.probability:.2f})"
    )


def main() -> None:
    """Make the measurement where it is not there, and diagnose it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, default=Path("out/diagnosis_time"))
    options = parser.parse_args()
    data = options.out / "measured.csv"
    if not data.is_file():
        called("synthetic", *SYNTHETIC, "--out", str(options.out))
    print(timed(data, options.workers, options.out / "diagnosis"))


if __name__ == "__main__":
    main()
