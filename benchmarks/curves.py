"""Designs that follow a curve: plane targets, and one that a finger of known sizes made.

    scripts/run python -m benchmarks.curves [NAME …] [--mesh-mm 8 4] [--free-form]

Each is a problem of eight bellows with a depth and a wall each, at 150 kPa, begun at the default
finger; the faces' free form may be added. The table has the root mean square distance on the mesh
of the design and on one with each cell divided in two along each axis, the simulations, and the
processor's time, which other work on the machine hardly changes.
Rows of other targets stay.
"""

from __future__ import annotations

import argparse
import csv
import math
import resource
import sys
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from dolfingrip.config import Change, Config, changed, load
from dolfingrip.design.gradient import curve, run, starts
from dolfingrip.design.gradient.descent import say_nothing
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import Compute, compute, computed_in
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import Pool

LENGTH_MM, PRESSURE_KPA, BELLOWS, PLACES = 90.0, 150.0, 8, 60
RANGES = {"depth_mm": (12.0, 22.0), "wall_mm": (1.2, 3.0)}
"""A wall of more than 3 mm leaves less than 1 mm of a bellows' chamber along z."""
FREE_FORM = "[free_form]\nalong = 6\nmost_mm = 1.0\n"
HERE = Path(__file__).parent


def bent(pieces: list[tuple[float, float]]) -> np.ndarray:
    """Points (n, 2) of a curve of pieces, each a length (mm) and a turn (deg) towards −x."""
    steps, angle = [], 0.0
    for length, turn in pieces:
        count = 60
        for i in range(count):
            at = math.radians(angle + turn * (i + 0.5) / count)
            steps.append([-length / count * math.sin(at), length / count * math.cos(at)])
        angle += turn
    return np.concatenate([[[0.0, 0.0]], np.cumsum(steps, axis=0)])


def known(mesh: Change) -> np.ndarray:
    """Points of the back of a finger of known sizes (seed 5)."""
    rng = np.random.default_rng(5)
    sizes = {
        f"finger.override.{i}.{key}": float(rng.uniform(*ends))
        for i in range(1, BELLOWS + 1)
        for key, ends in {"depth_mm": (13.0, 19.0), "wall_mm": (1.4, 2.0)}.items()
    }
    return backs(changed(Config(), {**mesh, **sizes}))


def backs(finger: Config) -> np.ndarray:
    """Points (n, 2) of a finger's back at the pressure, from the clamp on."""
    finger = changed(finger, {"camera.markers": PLACES})
    names = [f"marker_{i}_{axis}_mm" for i in range(1, PLACES + 1) for axis in "xz"]
    place = (Place("pressure_kPa", PRESSURE_KPA),)
    found = compute(Request.of("bending", finger, columns=tuple(names), places=place)).columns
    points = np.array([found[name][0] for name in names]).reshape(-1, 2)
    return np.concatenate([[[0.0, 0.0]], points])


TARGETS = {
    "late quarter circle": lambda mesh: bent([(30.0, 0.0), (60.0, 90.0)]),
    "two radii": lambda mesh: bent([(45.0, 25.0), (45.0, 65.0)]),
    "hook": lambda mesh: bent([(50.0, 10.0), (40.0, 90.0)]),
    "backwards": lambda mesh: bent([(45.0, -40.0), (45.0, 60.0)]),
    "known sizes": known,
}


def solve(
    name: str, mesh: Change, folder: Path, free_form: bool, refined: bool, most: int
) -> dict[str, object]:
    """Solve one problem; a row of the table."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "curve.csv").open("w", newline="") as stream:
        rows = csv.writer(stream)
        rows.writerow(["x_mm", "z_mm"])
        rows.writerows(np.round(TARGETS[name](mesh), 6).tolist())
    ranges = "".join(
        f"finger.override.{i}.{key} = [{low}, {high}]\n"
        for i in range(1, BELLOWS + 1)
        for key, (low, high) in RANGES.items()
    )
    settings = ", ".join(f'"{key}={value}"' for key, value in mesh.items())
    (folder / "design.toml").write_text(
        f'set = [{settings}]\n[objective]\nmatch = "curve.csv"\nat_pressure_kPa = {PRESSURE_KPA}\n'
        f"[method]\nsimulations = {most}\n[parameters]\n{ranges}{FREE_FORM if free_form else ''}"
    )
    problem = read(folder / "design.toml")
    every, design_s = timed(folder, lambda answers: starts.solve(problem, answers, say_nothing))
    found = every.best(problem)
    finer, finer_s = None, 0.0
    if refined:
        finer, finer_s = timed(folder, lambda answers: run.refine(problem, found, answers))
    result = run.facts(problem, found, finer, design_s)
    run.write(result, found, folder)
    assert result.matched is not None
    return {
        "target": name,
        "free_form": free_form,
        "cells_mm": "default" if not mesh else " and ".join(map(str, mesh.values())),
        "start_rms_mm": round(result.matched.start_rms_mm, 4),
        "rms_mm": round(result.matched.rms_mm, 4),
        "finer_mesh_rms_mm": finer and round(math.sqrt(finer.objective or math.nan), 4),
        "simulations": result.simulations,
        "processor_s": round(design_s),
        "finer_mesh_processor_s": round(finer_s),
        "stopped_by": "; ".join(
            f"{key.removeprefix('finger.override.')} {price:.2g}"
            for key, price in list(result.matched.stops_mm_per_unit.items())[:4]
        ),
        "told_at_once": curve.backwards(problem),
    }


def timed[T](folder: Path, task: Callable[[Compute], T]) -> tuple[T, float]:
    """Run a task with the answers in a folder.

    Args:
        folder: of a design, with its simulations.
        task: that asks for answers.

    Returns:
        Its result, and the time (s) that it took of the processor, workers included.
    """
    before = _processor_s()
    with Pool(Where(workers=1)) as pool:
        found = task(computed_in(folder / run.FOLDER, pool))
    return found, _processor_s() - before


def _processor_s() -> float:
    """Time of this process and of its children that have ended."""
    each = (resource.getrusage(of) for of in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(one.ru_utime + one.ru_stime for one in each)


def draw(mesh: Change, out: Path) -> None:
    """Draw targets and the backs of the designs in a folder, each solved once more."""
    import matplotlib.pyplot as plt

    found = [each for each in _named(TARGETS) if (out / each / "design.json").exists()]
    fig, panels = plt.subplots(
        1, len(found), figsize=(2.4 * len(found), 3.4), sharey=True, squeeze=False
    )
    start = backs(changed(Config(), mesh))
    for name, axes in zip(found, panels[0], strict=True):
        target = np.loadtxt(out / name / "curve.csv", delimiter=",", skiprows=1)
        axes.plot(*target.T, color="black", linewidth=4, alpha=0.25, label="target")
        axes.plot(*start.T, ":", color="grey", label="start")
        back = backs(load(out / name / "design.toml"))
        axes.plot(*back.T, color="tab:red", linewidth=1.5, label="design")
        axes.set(title=name.replace("_", " "), xlabel="x (mm)", aspect="equal")
    panels[0, 0].set_ylabel("z (mm)")
    panels[0, 0].invert_yaxis()
    panels[0, 0].legend(frameon=False, fontsize=8)
    fig.savefig(HERE.parent / "docs" / "curves.png", dpi=150, bbox_inches="tight")


def _named(names: Iterable[str]) -> list[str]:
    """Folders of targets, and those of the same with free form."""
    plain = [each.replace(" ", "_") for each in names]
    return [name + end for name in plain for end in ("", "_free_form")]


def main() -> None:
    """Write ``curves.csv`` and ``docs/curves.png``."""
    asked = argparse.ArgumentParser(description=__doc__)
    asked.add_argument("names", nargs="*", default=list(TARGETS))
    asked.add_argument("--mesh-mm", nargs=2, type=float, help="largest and smallest cells")
    asked.add_argument("--free-form", action="store_true", help="beside depth and wall")
    asked.add_argument("--simulations", type=int, default=20, help="at most")
    asked.add_argument("--unrefined", action="store_true", help="without the finer mesh")
    asked.add_argument("--out", type=Path, default=Path("out/curves"))
    given = asked.parse_args()
    mesh: Change = {}
    if given.mesh_mm:
        mesh = dict(zip(("mesh.size_mm", "mesh.edge_size_mm"), given.mesh_mm, strict=True))
    table = HERE / "curves.csv"
    for name in given.names:
        folder = given.out / _named([name])[given.free_form]
        found = solve(name, mesh, folder, given.free_form, not given.unrefined, given.simulations)
        row = {key: "" if each is None else str(each) for key, each in found.items()}
        print(row, file=sys.stderr, flush=True)
        with table.open(newline="") as stream:
            kept = list(csv.DictReader(stream))
        same = ("target", "free_form", "cells_mm")
        rows = [each for each in kept if any(each[key] != row[key] for key in same)]
        with table.open("w", newline="") as stream:
            writer = csv.DictWriter(stream, list(row))
            writer.writeheader()
            writer.writerows([*rows, row])
    draw(mesh, given.out)


if __name__ == "__main__":
    main()
