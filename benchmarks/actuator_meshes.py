"""A measured actuator on finer meshes: ``python -m benchmarks.actuator_meshes [OUT.csv]``.

Each row is a run of c5-w7 (examples/ecoflex_actuators), free, through ballooning: angles at
pressures below 30 kPa, pressures at angles beyond. A run that ends before an angle leaves it empty.
"""

from __future__ import annotations

import csv
import sys
import time
from pathlib import Path

import numpy as np
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.experiments import run
from dolfingrip.experiments.results.result import Result
from dolfingrip.experiments.rigs.undeformed import solid

HERE = Path(__file__).resolve().parent
ACTUATOR = HERE.parent / "examples" / "ecoflex_actuators" / "c5-w7.toml"

BEYOND = "experiment.max_volume_ratio=46", "experiment.step_volume_ratio=1.5"

MESHES = (
    ("mesh.edge_size_mm=1", "solver.integration=full"),
    ("mesh.edge_size_mm=0.5", "mesh.both_sides=true", "solver.integration=full"),
    ("mesh.edge_size_mm=0.5", "mesh.both_sides=true", "solver.integration=selective"),
    ("mesh.edge_size_mm=0.25", "mesh.both_sides=true", "solver.integration=full"),
)

PRESSURES_KPA = (10.0, 20.0, 27.5)
ANGLES_DEG = (15.0, 25.0, 35.0, 45.0)


def row(keys: tuple[str, ...]) -> dict[str, object]:
    """One run's figures."""
    config = configuration.load(ACTUATOR, overrides=[*keys, *BEYOND])
    start = time.process_time()
    result = run("bending", config, comm=MPI.COMM_SELF)
    found: dict[str, object] = {
        "mesh": " ".join(keys),
        "hexahedra": len(solid(config).cells),
        "processor_s": round(time.process_time() - start),
    }
    return {**found, **_figures(result)}


def _figures(result: Result) -> dict[str, object]:
    pressure, angle = (
        np.array(result.column(name)) for name in ("pressure_kPa", "chord_angle_deg")
    )
    figures: dict[str, object] = {
        f"angle_deg_at_{at:g}_kPa": round(float(np.interp(at, pressure[:13], angle[:13])), 3)
        for at in PRESSURES_KPA
    }
    for at in ANGLES_DEG:
        reached = angle.max() >= at
        figures[f"pressure_kPa_at_{at:g}_deg"] = (
            round(float(np.interp(at, angle, pressure)), 3) if reached else ""
        )
    figures["largest_angle_deg"] = round(float(angle.max()), 1)
    figures["largest_kPa"] = round(float(pressure.max()), 2)
    figures["ended"] = "" if result.failure is None else str(result.failure.kind)
    return figures


def main() -> None:
    """Run all, and write each row as soon as it is known."""
    out = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE / "actuator_meshes.csv"
    with out.open("w", newline="", encoding="utf-8") as file:
        writer: csv.DictWriter[str] | None = None
        for keys in MESHES:
            found = row(keys)
            print(found, flush=True)
            if writer is None:
                writer = csv.DictWriter(file, list(found), lineterminator="\n")
                writer.writeheader()
            writer.writerow(found)
            file.flush()


if __name__ == "__main__":
    main()
