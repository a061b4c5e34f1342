"""Fingers that are sucked until their walls meet, and blown up again: iterations, gaps, crossings.

    scripts/run env PYTHONPATH=tests python -m benchmarks.suction [NAME…]

makes ``benchmarks/suction.csv``, row by row. A finger whose rows are whole is not measured again,
so a command that was ended goes on with the finger that it was at; ``--anew`` starts from nothing.
The edges of the whole surface that pass through a triangle are counted in every accepted state,
without the code of the contact. All take about ten minutes of one core.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any, Final

import pandas as pd
from mpi4py import MPI
from support.passing import WholeSurface

from dolfingrip.config import load
from dolfingrip.experiments.index import find
from dolfingrip.experiments.rigs.finger_rig import FingerRig
from dolfingrip.files import table
from dolfingrip.mechanics.model.profile import Profile
from dolfingrip.mechanics.model.state import State
from dolfingrip.sections.tables import assignments

TABLE: Final = Path(__file__).with_suffix(".csv")

_SILICONE: Final = (
    "material.mu_MPa=0.03 material.nu=0.45 mesh.size_mm=8 "
    "experiment.max_pressure_kPa=-40 experiment.step_kPa=4"
)

FINGERS: Final = {
    "reference": "experiment.min_pressure_kPa=-80 experiment.max_pressure_kPa=250 "
    "experiment.unload=true",
    "cast": "finger.kind=cast cast.chambers=2 cast.chamber_height_mm=10 cast.chamber_width_mm=10 "
    f"cast.chamber_length_mm=2 cast.wall_mm=4 {_SILICONE}",
    "pneunet": f"finger.kind=pneunet pneunet.chambers=1 {_SILICONE}",
    "pneunet of two": f"finger.kind=pneunet pneunet.chambers=2 {_SILICONE} "
    "mesh.size_mm=4 mesh.edge_size_mm=2",
}
"""Settings of each finger, as KEY=VALUE."""


class Watched:
    """Counts accepted states, and edges that pass through triangles in them."""

    def __init__(self, surface: WholeSurface) -> None:
        self._surface = surface
        self.states, self.passing = 0, 0

    def converged(self, before: State) -> None:
        """Look at a state that was accepted."""
        self.states += 1
        self.passing += self._surface.passing()


def measured(name: str, settings: str, rows: list[dict[str, Any]]) -> None:
    """Take the readings of a finger, and add a row for each to the table."""
    config = load(None, assignments(settings.split()))
    experiment = find("bend")
    stops = experiment.schedule(config)
    if sum(row["finger"] == name for row in rows) == len(stops):
        return
    rows[:] = [row for row in rows if row["finger"] != name]
    rig = experiment.prepare(experiment.settings(config), MPI.COMM_SELF, Profile())
    assert isinstance(rig, FingerRig)
    watched = Watched(WholeSurface(rig.specimen))
    path, start = rig.path([watched]), time.process_time()
    for stop in stops:
        went = path.advance(rig.controls(stop))
        read = rig.read()
        rows.append(
            {
                "finger": name,
                "pressure_kPa": stop.value,
                "branch": stop.branch,
                "angle_deg": round(read["angle_deg"], 3),
                "cavity_volume_mm3": round(read["cavity_volume_mm3"], 2),
                "wall_gap_mm": round(read["wall_gap_mm"], 4),
                "iterations": path.newton.counts.iterations,
                "states": watched.states,
                "passing": watched.passing,
                "processor_s": round(time.process_time() - start, 1),
                "failure": "" if went.failure is None else went.failure.kind,
            }
        )
        print(*rows[-1].values(), sep="\t", flush=True)
        table.write(TABLE, sorted(rows, key=lambda row: [*FINGERS].index(row["finger"])))
        if went.failure is not None:
            return


def main() -> None:
    """Measure the fingers that are asked for; rows of others stay."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("names", nargs="*", default=list(FINGERS), choices=[[], *FINGERS])
    parser.add_argument("--anew", action="store_true", help="measure them again")
    asked = parser.parse_args()
    kept = pd.read_csv(TABLE).to_dict("records") if TABLE.exists() else []
    rows = [row for row in kept if not (asked.anew and row["finger"] in asked.names)]
    for name in asked.names:
        measured(name, FINGERS[name], rows)


if __name__ == "__main__":
    main()
