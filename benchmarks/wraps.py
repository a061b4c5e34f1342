"""Designs that touch a food with a uniform pressure: an egg and a sausage.

    scripts/run python -m benchmarks.wraps [NAME …] [--simulations 6] [--limits] [--unrefined]

The food stands beside the back of the default finger and bears 2 N. The contact face is bent by
splines, and the base layer has one thickness. With ``--limits`` the touching area and the lift may
not fall. The table has the standard deviation of the contact pressure by its mean, the area and the
lift at start and design, also on a mesh with each cell divided in two along each axis (unless
``--unrefined``), the simulations and the processor's time. Rows of other problems stay.
"""

from __future__ import annotations

import argparse
import csv
import sys
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.curves import timed
from dolfingrip.channels import OBSTACLE
from dolfingrip.config import Config
from dolfingrip.design.gradient import run, starts
from dolfingrip.design.gradient.read import read
from dolfingrip.design.gradient.trial import say_nothing
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.meshes.closed_surface import ClosedSurface

FORCE_N = 2.0
FOODS = {"egg": "egg.stl", "sausage": "sausage-long"}
MEASURED = ("obstacle_spread", "obstacle_area_mm2", "obstacle_lift_N")
HERE = Path(__file__).parent


def egg(around: int = 96, along: int = 48) -> ClosedSurface:
    """An egg of 44 by 57 mm (large, by the USDA), upright, a little thicker below."""
    v = np.pi * np.arange(1, along) / along
    u = 2 * np.pi * np.arange(around) / around
    wide = 22.0 * (1 - 0.12 * np.cos(v)) * np.sin(v)
    ring = np.stack([np.cos(u), np.sin(u), np.zeros(around)], axis=1)
    rings = wide[:, None, None] * ring + 28.5 * np.cos(v)[:, None, None] * [0.0, 0.0, 1.0]
    points = np.concatenate([rings.reshape(-1, 3), [[0.0, 0.0, 28.5], [0.0, 0.0, -28.5]]])
    i = np.arange(around)
    after, top, last = (i + 1) % around, len(points) - 2, (along - 2) * around
    found = [np.stack([np.full(around, top), i, after], axis=1)]
    for first in range(0, last, around):
        a, b, c, d = first + i, first + after, first + around + after, first + around + i
        found += [np.stack([a, c, b], axis=1), np.stack([a, d, c], axis=1)]
    found.append(np.stack([np.full(around, top + 1), last + after, last + i], axis=1))
    return ClosedSurface(points, np.concatenate(found))


def pressed(finger: Config, compute: Compute) -> dict[str, float]:
    """Spread, area and lift of a finger where the food bears the force."""
    place = (Place(OBSTACLE[0].name, FORCE_N),)
    (found,) = compute([Request.of("bending", finger, columns=MEASURED, places=place)])
    return {name: round(float(found.columns[name][0]), 3) for name in MEASURED}


def solve(
    name: str, mesh_mm: tuple[float, float], folder: Path, most: int, *, limits: bool, refined: bool
) -> dict[str, object]:
    """Solve one problem; a row of the table."""
    folder.mkdir(parents=True, exist_ok=True)
    egg().polydata().save(folder / "egg.stl")  # type: ignore[attr-defined]
    held = "".join(
        f'[[constraints]]\nof = "{each}"\nat_least = "start"\nat_force_N = {FORCE_N}\n'
        for each in MEASURED[1:]
        if limits
    )
    (folder / "design.toml").write_text(
        f'set = ["mesh.size_mm={mesh_mm[0]}", "mesh.edge_size_mm={mesh_mm[1]}", '
        f'"obstacle.z_mm=45.0"]\n[objective]\nwrap = "{FOODS[name]}"\nat_force_N = {FORCE_N}\n'
        f"{held}[method]\nsimulations = {most}\nradius = 0.08\n"
        "[parameters]\nfinger.base_layer_mm = [2.5, 6.0]\n"
        '[free_form]\nfaces = "contact face"\nalong = 12\nmost_mm = 1.5\nends = false\n'
    )
    problem = read(folder / "design.toml")
    every, design_s = timed(folder, lambda answers: starts.solve(problem, answers, say_nothing))
    found = every.best(problem)
    run.write(run.facts(problem, found, None, design_s), found, folder)
    row: dict[str, object] = {
        "food": name,
        "cells_mm": " and ".join(map(str, mesh_mm)),
        "limits": limits,
    }
    for word, refine in (("", 1), ("finer_mesh_", 2)):
        for at, trial in (("start", found.start), ("design", found.best)):
            values: dict[str, float | None] = dict.fromkeys(MEASURED)
            if refine == 1 or refined:
                finger = trial.shape.config.changed(mesh={"refine": refine})
                values |= timed(folder, partial(pressed, finger))[0]
            row |= {f"{word}{at}_{key}": value for key, value in values.items()}
    return row | {
        "simulations": found.simulations,
        "processor_s": round(design_s),
        "ending": found.ending,
    }


def main() -> None:
    """Write ``wraps.csv``."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("names", nargs="*", default=list(FOODS))
    asked.add_argument("--mesh-mm", nargs=2, type=float, default=(8.0, 4.0))
    asked.add_argument("--simulations", type=int, default=6, help="at most")
    asked.add_argument("--limits", action="store_true", help="of area and lift")
    asked.add_argument("--unrefined", action="store_true", help="without the finer mesh")
    asked.add_argument("--out", type=Path, default=Path("out/wraps"))
    given = asked.parse_args()
    table = HERE / "wraps.csv"
    for name in given.names:
        found = solve(
            name, tuple(given.mesh_mm), given.out / name, given.simulations,
            limits=given.limits, refined=not given.unrefined,
        )  # fmt: skip
        row = {key: "" if each is None else str(each) for key, each in found.items()}
        print(row, file=sys.stderr, flush=True)
        kept = []
        if table.exists():
            with table.open(newline="") as stream:
                kept = list(csv.DictReader(stream))
        same = ("food", "cells_mm", "limits")
        rows = [each for each in kept if any(each[key] != row[key] for key in same)]
        with table.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, list(row))
            writer.writeheader()
            writer.writerows([*rows, row])


if __name__ == "__main__":
    main()
