"""Newton iterations that friction costs: ``python -m benchmarks.friction_iterations``.

Prints a table of runs with the blocked finger, without friction and with it; docs/mechanics.md
holds it. Counts do not depend on the machine.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Final

from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.experiments import run

SHORT: Final = (
    "mesh.size_mm=6", "mesh.edge_size_mm=6", "finger.length_mm=38", "finger.bellows=2",
)  # fmt: skip
PLATE: Final = ("extensions.plate_friction={}",)
BELLOWS: Final = ("extensions.bellows_friction={}",)
LOW: Final = ("experiment.max_pressure_kPa=50", "experiment.cycles=2")
HIGH: Final = ("experiment.max_pressure_kPa=100", "experiment.cycles=2")
BY_10: Final = ("experiment.step_kPa=10",)
APART: Final = ("contact.self_contact=false",)

CASES: Final = {
    "plate, short finger, 2 × 50 kPa by 10": ((*SHORT, *LOW, *BY_10), PLATE),
    "plate, short finger, 2 × 50 kPa by 25": ((*SHORT, *LOW), PLATE),
    "bellows, short finger, 2 × 100 kPa by 25": ((*SHORT, *HIGH), BELLOWS),
    "both, the same": ((*SHORT, *HIGH), (*PLATE, *BELLOWS)),
    "plate, reference finger to 250 kPa": ((), PLATE),
    "the same, and back to 0 kPa": (("experiment.unload=true",), PLATE),
    "plate, reference finger, 2 × 100 kPa, bellows do not touch": ((*HIGH, *APART), PLATE),
    "both, reference finger, 2 × 200 kPa": (
        ("experiment.max_pressure_kPa=200", "experiment.cycles=2"), (*PLATE, *BELLOWS),
    ),
}  # fmt: skip
"""Overrides of a run, and those that add friction."""


def counts(*overrides: str) -> str:
    """Iterations, and factorisations in parentheses, of a run."""
    with tempfile.TemporaryDirectory() as folder:
        settings = configuration.load(None, overrides)
        result = run("blocked_force", settings, out=Path(folder), comm=MPI.COMM_SELF)
        assert result.failure is None, result.failure.sentence()
        newton = json.loads((Path(folder) / "run.json").read_text(encoding="utf-8"))["newton"]
    return f"{newton['iterations']} ({newton['factorisations']})"


def main() -> None:
    """Print the table."""
    print("| friction | none | with it |\n|---|---|---|", flush=True)
    for case, (settings, friction) in CASES.items():
        print(f"| {case} | {counts(*settings)} | {counts(*settings, *friction)} |", flush=True)


if __name__ == "__main__":
    main()
