"""Designs that touch a food with a uniform pressure: an egg and a sausage.

    scripts/run python -m benchmarks.wraps [NAME …] [--simulations 6 14]
        [--finer-mesh-mm 6 3]

The food stands beside the back of the default finger and bears 2 N. The contact face is bent by
splines, and the base layer has one thickness; the egg's place may change, too. The first of several
searches has no limits. Each later one begins at the design of the one before, and may make neither
the touching area nor the lift less than the default finger's. A run that was stopped goes on.

The table has the standard deviation of the contact pressure by its mean, the area and the lift at
start, at the design without limits and at the last design, start and last design also on a finer
mesh where it is asked for, the simulations of each search, and the processor's time of all commands
that came to their end. Rows of other problems stay.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from benchmarks.curves import timed
from dolfingrip.channels import OBSTACLE
from dolfingrip.config import Config
from dolfingrip.design.gradient import run, starts
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.problem import Constraint
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import Compute
from dolfingrip.meshes.closed_surface import ClosedSurface

FORCE_N = 2.0
FOODS = {"egg": "../egg.stl", "sausage": "sausage-long"}
BASE = {"finger.base_layer_mm": [2.5, 6.0]}
PARAMETERS = {
    "egg": {**BASE, "obstacle.z_mm": [35.0, 60.0], "obstacle.gap_mm": [0.5, 6.0]},
    "sausage": BASE,
}
MEASURED = ("obstacle_spread", "obstacle_area_mm2", "obstacle_lift_N")
HERE = Path(__file__).parent


def egg(around: int = 192, along: int = 96) -> ClosedSurface:
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


def search(
    name: str, folder: Path, most: int, begin: str, held: dict[str, float]
) -> tuple[Descent, float]:
    """Search once.

    Args:
        name: of the food.
        folder: of this search; the egg's file is in the one above.
        most: largest number of simulations.
        begin: what the design file says of the finger that it begins with.
        held: least value of quantities.

    Returns:
        The descent, and the processor's time (s) of this command.
    """
    folder.mkdir(parents=True, exist_ok=True)
    limits = "".join(
        f'[[constraints]]\nof = "{each}"\nat_least = {least}\nat_force_N = {FORCE_N}\n'
        for each, least in held.items()
    )
    parameters = "".join(f"{key} = {ends}\n" for key, ends in PARAMETERS[name].items())
    (folder / "design.in.toml").write_text(
        f'{begin}\n[objective]\nwrap = "{FOODS[name]}"\nat_force_N = {FORCE_N}\n'
        f"{limits}[method]\nsimulations = {most}\nradius = 0.08\n[parameters]\n{parameters}"
        '[free_form]\nfaces = "contact face"\nalong = 12\nmost_mm = 1.5\nends = false\n'
    )
    problem = read(folder / "design.in.toml")

    def say(trial: Trial, limits: Sequence[tuple[Constraint, float]]) -> None:
        values = (trial.objective, *trial.limits)
        said = trial.failure or ", ".join(f"{each:.4g}" for each in values)
        word = " accepted" * trial.accepted
        print(f"{folder}: {trial.simulations} of {most}: {said}{word}", file=sys.stderr, flush=True)

    every, design_s = timed(folder, lambda answers: starts.solve(problem, answers, say))
    found = every.best(problem)
    run.write(run.facts(problem, found, None, design_s), found, folder)
    return found, design_s


def solve(
    name: str, mesh_mm: Sequence[float], folder: Path, most: Sequence[int], finer: Sequence[float]
) -> dict[str, object]:
    """Solve one problem by searches of so many simulations; a row of the table."""
    folder.mkdir(parents=True, exist_ok=True)
    egg().polydata().save(folder / "egg.stl")  # type: ignore[attr-defined]
    spent = folder / "processor_s.txt"
    begin = (
        f'set = ["mesh.size_mm={mesh_mm[0]}", "mesh.edge_size_mm={mesh_mm[1]}", '
        '"obstacle.z_mm=45.0"]'
    )
    row: dict[str, object] = {"food": name, "cells_mm": " and ".join(map(str, mesh_mm))}
    held: dict[str, float] = {}
    fingers: dict[str, Config] = {}
    found: list[Descent] = []
    total_s = float(spent.read_text()) if spent.exists() else 0.0

    def took(further_s: float) -> None:
        nonlocal total_s
        total_s += further_s
        spent.write_text(f"{total_s:.1f}\n")

    def measured(word: str, finger: Config) -> dict[str, float]:
        values, further_s = timed(folder, partial(pressed, finger))
        took(further_s)
        row.update({f"{word}_{key}": value for key, value in values.items()})
        print(row, file=sys.stderr, flush=True)
        return values

    for number, simulations in enumerate(most, 1):
        descent, design_s = search(name, folder / str(number), simulations, begin, held)
        took(design_s)
        found.append(descent)
        if number == 1:
            fingers = {"start": descent.start.shape.config, "unlimited": descent.best.shape.config}
            at_start = measured("start", fingers["start"])
            held = {key: at_start[key] for key in MEASURED[1:]}
            measured("unlimited", fingers["unlimited"])
        begin = f'config = "../{number}/design.toml"'
    fingers["design"] = found[-1].best.shape.config
    measured("design", fingers["design"])
    row["finer_cells_mm"] = " and ".join(map(str, finer))
    for word in ("start", "design"):
        row |= {f"finer_mesh_{word}_{key}": None for key in MEASURED}
        if finer:
            mesh = dict(zip(("size_mm", "edge_size_mm"), finer, strict=True))
            measured(f"finer_mesh_{word}", fingers[word].changed(mesh=mesh))
    return row | {
        "simulations": " + ".join(str(each.simulations) for each in found),
        "processor_s": round(total_s),
        "ending": found[-1].ending,
    }


def main() -> None:
    """Write ``wraps.csv``."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("names", nargs="*", default=list(FOODS))
    asked.add_argument("--mesh-mm", nargs=2, type=float, default=(8.0, 4.0))
    asked.add_argument(
        "--simulations", nargs="+", type=int, default=(6, 14), help="of each search, at most"
    )
    asked.add_argument("--finer-mesh-mm", nargs=2, type=float, default=(), help="for a check")
    asked.add_argument("--out", type=Path, default=Path("out/wraps"))
    given = asked.parse_args()
    table = HERE / "wraps.csv"
    for name in given.names:
        found = solve(
            name, given.mesh_mm, given.out / name, given.simulations, given.finer_mesh_mm
        )  # fmt: skip
        row = {key: "" if each is None else str(each) for key, each in found.items()}
        print(row, file=sys.stderr, flush=True)
        kept = []
        if table.exists():
            with table.open(newline="") as stream:
                kept = list(csv.DictReader(stream))
        same = ("food", "cells_mm")
        rows = [each for each in kept if any(each[key] != row[key] for key in same)]
        with table.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, list(row))
            writer.writeheader()
            writer.writerows([*rows, row])


if __name__ == "__main__":
    main()
