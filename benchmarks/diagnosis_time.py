"""How long one diagnosis takes: bending and blocked force, three cycles, the whole catalogue.

    scripts/run python -m benchmarks.diagnosis_time [--workers 2] [--only nothing,secants]

The measurement is the worked case of ``docs/diagnosis.md``, a viscous reference finger. It is
diagnosed by ``dolfingrip diagnose`` twice, each time with an empty store: "nothing" computes all
simulations, "secants" takes those that come with the package. Prints for each the wall time, the
processor time of all processes, how many simulations were computed, and the verdict. The machine
should have nothing else to do. Forms that were never compiled before take their time, too.
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

STARTS: Final = {"nothing": ("--anew",), "secants": ()}
"""What is there at the start, and options of ``dolfingrip diagnose``."""


def called(*arguments: str) -> None:
    """Run ``dolfingrip``; what it says is shown."""
    subprocess.run(["dolfingrip", *arguments], check=True)


def processor_s() -> float:
    """Return the processor time of all processes that have ended (s)."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def timed(data: Path, start: str, workers: int, out: Path) -> str:
    """Diagnose once, and tell what it took, in one line."""
    shutil.rmtree(out, ignore_errors=True)
    wall, processor = time.monotonic(), processor_s()
    called("diagnose", str(data), "--workers", str(workers), "--out", str(out), *STARTS[start])
    wall, processor = time.monotonic() - wall, processor_s() - processor
    with Store(out / "simulations") as store:
        rows = list(store.rows())
    computed = [row for row in rows if row["worker"] != "shipped"]
    verdict = DiagnosisFile.read(out).verdict
    return (
        f"from {start}: {wall / 60:.1f} min on {workers} workers ({os.cpu_count()} cores), "
        f"processor {processor:.0f} s, {len(computed)} of {len(rows)} simulations computed; "
        f"{verdict.answer}: {', '.join((*verdict.effects, *verdict.second))} "
        f"({verdict.probability:.2f})"
    )


def main() -> None:
    """Make the measurement where it is not there, and diagnose it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", default=",".join(STARTS), help=f"of {', '.join(STARTS)}")
    parser.add_argument("--out", type=Path, default=Path("out/diagnosis_time"))
    options = parser.parse_args()
    starts = options.only.split(",")
    for start in starts:
        if start not in STARTS:
            parser.error(f"--only {start}: allowed: {', '.join(STARTS)}")
    data = options.out / "measured.csv"
    if not data.is_file():
        called("synthetic", *SYNTHETIC, "--out", str(options.out))
    lines = [timed(data, start, options.workers, options.out / start) for start in starts]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
