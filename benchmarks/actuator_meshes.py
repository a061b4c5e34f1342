"""A measured actuator on finer meshes: ``python -m benchmarks.actuator_meshes [NUMBER …]``.

Each row is a run of c5-w7 (examples/ecoflex_actuators), free, through ballooning: angles at
pressures below 30 kPa, pressures at angles beyond. A run that ends before an angle leaves it empty.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
from mpi4py import MPI

from dolfingrip import config as configuration
from dolfingrip.experiments import run
from dolfingrip.experiments.results.result import Result
from dolfingrip.experiments.rigs.undeformed import solid

HERE = Path(__file__).resolve().parent
ACTUATOR = HERE.parent / "examples" / "ecoflex_actuators" / "c5-w7.toml"

MESHES = (
    ("mesh.edge_size_mm=1", "mesh.both_sides=false"),
    (),
    ("mesh.edge_size_mm=0.35", "experiment.max_volume_ratio=60"),
    ("mesh.edge_size_mm=0.25",),
)
"""The second is the example's own."""

PRESSURES_KPA = (10.0, 20.0, 27.5)
ANGLES_DEG = (15.0, 25.0, 35.0, 45.0, 55.0, 65.0)


def row(keys: tuple[str, ...]) -> dict[str, object]:
    """One run's figures."""
    config = configuration.load(ACTUATOR, overrides=list(keys))
    start = time.process_time()
    result = run("bending", config, comm=MPI.COMM_SELF)
    found: dict[str, object] = {
        "mesh": " ".join(keys) or "as in the example",
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
    """Run those that are asked for, or all, and write each row as soon as it is known."""
    asked = [int(each) for each in sys.argv[1:]] or range(len(MESHES))
    out = HERE / "actuator_meshes.csv"
    for number in asked:
        found = row(MESHES[number])
        print(found, flush=True)
        known = pd.read_csv(out, keep_default_na=False) if out.exists() else pd.DataFrame()
        if len(known):
            known = known[known["mesh"] != found["mesh"]]
        table = pd.concat([known, pd.DataFrame([found])]).sort_values("hexahedra")
        table.to_csv(out, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
