"""A bellows finger of bricks, whole or each cut into tetrahedra, bent along a circular arc."""

from __future__ import annotations

import csv
import json
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from dolfingrip import config
from dolfingrip.sections.tables import assignments

COARSE = (
    "finger.length_mm=38", "finger.bellows=2", "mesh.size_mm=8", "mesh.edge_size_mm=8",
)  # fmt: skip

PRESSURES_KPA = [0.0, 50.0, 100.0, 150.0, 200.0, 150.0, 100.0, 50.0, 0.0]
BRANCH = ["loading"] * 5 + ["unloading"] * 4
ANGLE_DEG_PER_KPA = 0.5
LENGTH_MM, WIDTH_MM, DEPTH_MM = 90.0, 20.0, 16.0


def angle_deg(step: int) -> float:
    """Tip angle of a step; 5 degrees of lag on the way back."""
    lag = 5.0 if BRANCH[step] == "unloading" else 0.0
    return ANGLE_DEG_PER_KPA * PRESSURES_KPA[step] + lag


def bend(x: npt.NDArray[np.float64], angle: float) -> npt.NDArray[np.float64]:
    """Displacement of points (3, n) bent ``angle`` degrees to −x; the back keeps its length."""
    kappa = np.radians(angle) / LENGTH_MM
    if kappa == 0.0:
        return np.zeros_like(x)
    turn, radius = kappa * x[2], 1 / kappa
    moved = np.array(
        [(radius + x[0]) * np.cos(turn) - radius, x[1], (radius + x[0]) * np.sin(turn)]
    )
    return np.asarray(moved - x)


def write_run(folder: Path, degree: int, half: bool = True, cell: str = "tetrahedron") -> None:
    """Write ``fields.pvd`` (Lagrange ``degree``) and ``result.csv`` of a bending test."""
    from dolfinx import fem, io, mesh
    from mpi4py import MPI

    comm = MPI.COMM_WORLD
    low, nx, ny, nz = (0.0, 4, 2, 45) if half else (-WIDTH_MM / 2, 4, 4, 45)
    box = mesh.create_box(
        comm,
        [[0, low, 0], [DEPTH_MM, WIDTH_MM / 2, LENGTH_MM]],
        [nx, ny, nz],
        mesh.CellType[cell],
    )
    domain = mesh.create_submesh(box, 3, mesh.locate_entities(box, 3, _solid))[0]
    vectors = fem.functionspace(domain, ("Lagrange", degree, (3,)))
    scalars = fem.functionspace(domain, ("Lagrange", degree))
    u = fem.Function(vectors, name="displacement_mm")
    stretch = fem.Function(scalars, name="principal_stretch")
    with io.VTKFile(comm, folder / "fields.pvd", "w") as file:
        for step in range(len(PRESSURES_KPA)):
            angle = angle_deg(step)
            kappa = np.radians(angle) / LENGTH_MM
            u.interpolate(lambda x, a=angle: bend(x, a))
            stretch.interpolate(lambda x, k=kappa: 1 + k * x[0])
            file.write_function([u, stretch], float(step))
    if comm.rank == 0:
        with (folder / "result.csv").open("w", encoding="utf-8", newline="") as stream:
            rows = csv.writer(stream)
            rows.writerow(["time_s", "pressure_kPa", "branch", "angle_deg"])
            for step, pressure in enumerate(PRESSURES_KPA):
                rows.writerow([step, pressure, BRANCH[step], angle_deg(step)])


def write_result(folder: Path, command: Sequence[str] = ("bend",)) -> None:
    """Write a bending test with the facts that a report reads, of a coarse finger."""
    folder.mkdir()
    write_run(folder, 1, cell="hexahedron")
    facts = {
        "experiment": "bending", "complete": True, "command": command,
        "config": config.load(None, assignments(COARSE)).model_dump(mode="json", exclude_none=True),
        "mesh": {"elements": 120, "half": True}, "wall_s": 1.0, "ranks": 1,
        "versions": {"dolfingrip": "0"},
    }  # fmt: skip
    (folder / "run.json").write_text(json.dumps(facts), encoding="utf-8")


def _solid(x: npt.NDArray[np.float64]) -> npt.NDArray[np.bool_]:
    """Vertices of the bricks kept: a base layer, and bellows 6 mm long every 10 mm."""
    phase = (x[2] - 10.0) % 10.0
    return (x[0] <= 8.01) | (phase <= 6.01) | (x[2] <= 10.01)


if __name__ == "__main__":
    write_run(Path(sys.argv[1]), int(sys.argv[2]), cell=sys.argv[3])
