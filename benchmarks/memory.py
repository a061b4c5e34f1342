"""Memory that each further run of an experiment keeps in one process, on the meshes by default.

    scripts/run python -m benchmarks.memory [EXPERIMENT …]

Each experiment has a process of its own and runs ten times in it. Earlier runs load compiled forms,
so the slope is that of runs 3 to 10. ``tests/test_memory.py`` asks for the same on coarse meshes.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
from mpi4py import MPI

from dolfingrip import config
from dolfingrip.experiments import run

RUNS, FIRST, MOST_MB = 10, 3, 2.0
PRESSED = {"experiment.max_pressure_kPa": 20, "experiment.step_kPa": 20}
CHANGES = {
    "bending": PRESSED,
    "blocked_force": PRESSED,
    "push": PRESSED,
    "cycle": PRESSED,
    "grasp": {
        **PRESSED,
        "gripper.half": True,
        "gripper.pressurise_s": 0.2,
        "gripper.settle_s": 0.1,
        "gripper.lift_mm": 0.2,
        "gripper.step_s": 0.4,
    },
}
"""Short paths: what a run keeps does not depend on their length."""


def resident_MB() -> float:
    """Return the memory of this process (10⁶ bytes)."""
    pages = Path("/proc/self/statm").read_text(encoding="ascii").split()
    return int(pages[1]) * 4096 / 1e6


def kept_MB(name: str) -> float:
    """Run an experiment ten times and print the memory after each run.

    Args:
        name: of the experiment.

    Returns:
        Slope of the memory over runs 3 to 10 (10⁶ bytes a run).
    """
    changed = config.load(None, CHANGES[name])
    memory_MB = []
    for _ in range(RUNS):
        found = run(name, changed, comm=MPI.COMM_SELF)
        memory_MB.append(resident_MB())
        print(f"{name}: {memory_MB[-1]:.1f} MB, {found.failure or 'whole'}", flush=True)
    later = np.arange(FIRST - 1, RUNS)
    return float(np.polyfit(later, np.array(memory_MB)[later], 1)[0])


def main() -> int:
    """Measure the experiments that are named, or all of them.

    Returns:
        Exit code: 1 where one keeps more than is allowed.
    """
    names = sys.argv[1:] or list(CHANGES)
    if len(names) == 1:
        slope = kept_MB(names[0])
        print(f"{names[0]}: {slope:.2f} MB a run; allowed: at most {MOST_MB:g} MB")
        return int(slope > MOST_MB)
    command = [sys.executable, "-m", "benchmarks.memory"]
    return max(subprocess.run([*command, name], check=False).returncode for name in names)


if __name__ == "__main__":
    sys.exit(main())
