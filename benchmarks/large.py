"""Time and memory against unknowns, by linear solver: free bending to 50 kPa.

    scripts/run python -m benchmarks.large [--only ELEMENT SIZE_mm SOLVER RANKS] [--draw]

Each rank is a process of its own on one core. A run's row is added to ``benchmarks/large.csv``, in
place of an earlier one of the same mesh, solver and number of ranks; ``docs/large.png`` is
drawn from the table. All of them take about 12 minutes of processor time, the largest model 5 GB.
"""

from __future__ import annotations

import argparse
import csv
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from benchmarks.orders import exponent
from dolfingrip.charts import theme
from dolfingrip.files.run import RunFile

TABLE = Path(__file__).with_suffix(".csv")
PICTURE = TABLE.parents[1] / "docs" / "large.png"
KEY = ("element", "size_mm", "solver", "ranks")
COLUMNS = (*KEY, "dofs", "wall_s", "processor_s", "peak_MB", "forecast_MB", "iterations", "angle")
SIZES = {"P2": ("2.8", "2", "1.25", "0.86", "0.61"), "S2": ("1", "2")}
"""Largest element (mm) of tetrahedra; divisions of hexahedra."""
STYLE = {"direct": ("o", theme.ORANGE), "iterative": ("s", theme.BLUE)}
LARGEST_DIRECT = "0.86"
"""Size of the finest mesh that is factorised."""
ON_TWO = ("P2", "0.61", "iterative", "2")
"""What two ranks solve, too."""


def run(element: str, size: str, solver: str, ranks: str) -> dict[str, object]:
    """One run's row."""
    key = "mesh.size_mm" if element == "P2" else "mesh.refine"
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    mpirun = [] if ranks == "1" else ["mpirun", "-n", ranks]
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            [*mpirun, sys.executable, "-m", "dolfingrip", "bend", "--pressure", "50", "-o", folder,
             "--set", f"solver.element={element}", "--set", f"{key}={size}",
             "--set", f"solver.linear={solver}"],
            check=True, env={**os.environ, "OMP_NUM_THREADS": "1"},
        )  # fmt: skip
        facts = RunFile.read(folder).plain()
        with (Path(folder) / "result.csv").open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {
        "element": element,
        "size_mm": size,
        "solver": solver,
        "ranks": ranks,
        "dofs": facts["mesh"]["dofs"],
        "wall_s": round(facts["wall_s"], 1),
        "processor_s": round(spent, 1),
        "peak_MB": facts["peak_memory_MB"],
        "forecast_MB": facts["memory_forecast_MB"],
        "iterations": facts["newton"]["iterations"],
        "angle": rows[-1]["angle_deg"],
    }


def table() -> list[dict[str, str]]:
    """The rows so far."""
    if not TABLE.exists():
        return []
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def add(row: dict[str, object]) -> None:
    """Write a row to the table."""
    new = {name: str(row[name]) for name in COLUMNS}
    same = [new[name] for name in KEY]
    rows = [old for old in table() if [old[name] for name in KEY] != same]
    rows = sorted([*rows, new], key=lambda r: (r["element"], r["solver"], int(r["dofs"])))
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def draw() -> None:
    """Draw the table."""
    rows = [row for row in table() if row["ranks"] == "1"]
    with theme.figure_theme():
        figure, panels = plt.subplots(1, 2, figsize=(7.0, 3.2), layout="constrained")
        for solver, (marker, colour) in STYLE.items():
            for element, line in (("P2", "-"), ("S2", ":")):
                points = [r for r in rows if (r["solver"], r["element"]) == (solver, element)]
                if len(points) < 2:
                    continue
                dofs = np.array([float(r["dofs"]) for r in points])
                for axes, column in zip(panels, ("processor_s", "peak_MB"), strict=True):
                    values = np.array([float(r[column]) for r in points])
                    label = f"{element} {solver}: dofs$^{{{exponent(dofs, values):.2f}}}$"
                    axes.loglog(dofs, values, marker + line, color=colour, label=label)
        panels[0].set(xlabel="unknowns", ylabel="processor time (s)")
        panels[1].set(xlabel="unknowns", ylabel="largest memory (MB)")
        for axes in panels:
            axes.legend(fontsize=7)
        figure.suptitle("Free bending to 50 kPa, one core", fontsize=9)
        figure.savefig(PICTURE)


def wanted() -> Iterable[tuple[str, ...]]:
    """All meshes and solvers, those that cost least first."""
    for element, sizes in SIZES.items():
        for size in sizes:
            for solver in STYLE:
                finer = element == "P2" and float(size) < float(LARGEST_DIRECT)
                if not (solver == "direct" and finer):
                    yield element, size, solver, "1"
    yield ON_TWO


def main() -> None:
    """Run what is asked for, and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", nargs=4, metavar=KEY)
    parser.add_argument("--draw", action="store_true", help="draw the table alone")
    asked = parser.parse_args()
    for case in [] if asked.draw else [tuple(asked.only)] if asked.only else wanted():
        row = run(*case)
        print(row, flush=True)
        add(row)
    draw()


if __name__ == "__main__":
    main()
