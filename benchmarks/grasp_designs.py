"""Does a design with more blocked force hold more weight? The original finger against OD3.

    scripts/run python -m benchmarks.grasp_designs [--pressure 100] [--out out/grasp_designs]
        [--set gripper.preset=coarse] [--publish]

Both designs pinch the same cube, set as wide, at one pressure; only its density differs. The
heaviest cube that is picked up is found on a grid of weights 4 % apart, from W = μ ΣN of one grasp
on. OD3 is the optimum that the paper prints (table III), its blocked force 12.1 % above the
original's there. A call resumes one that was killed.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Mapping
from pathlib import Path

from benchmarks.grasp_campaign import places
from dolfingrip import config as configuration
from dolfingrip.cli.options import console
from dolfingrip.config import Config
from dolfingrip.design.campaign.threshold import least
from dolfingrip.design.campaign.trials import Trial, Trials

DESIGNS: Mapping[str, tuple[float, float]] = {"original": (0.0, 0.0), "OD3": (0.306, -0.298)}
"""ξ1 and ξ2."""

OURS = ("gripper.preset=coarse", "gripper.clearance_mm=4", "gripper.lift_mm=10")

STEP = 1.04
"""Ratio of neighbouring weights."""

LEAST_KG_M3, PLACES = 500.0, 90
"""Density of the lightest cube that is tried, and number of weights."""

TABLE = Path(__file__).with_suffix(".csv")


def heaviest(base: Config, pressure_kPa: float, out: Path) -> tuple[Trial | None, list[Trial]]:
    """The grasp of the heaviest cube that is picked up, and all grasps.

    Args:
        base: configuration of a design.
        pressure_kPa: of the fingers.
        out: where grasps are kept.
    """
    made: dict[int, Trial] = {}

    def trial(place: int) -> Trial:
        if place not in made:
            density = round(LEAST_KG_M3 * STEP**place, 3)
            heavier = base.changed(food={"density_kg_m3": density})
            made[place] = Trials(heavier, out).at(pressure_kPa, base.food.friction)
        return made[place]

    place = round(PLACES / 4)
    first = trial(place)
    bears = base.food.friction * first.normal_N / first.weight_N
    while bears >= STEP and place < PLACES:
        place, bears = place + 1, bears / STEP
    # success is what falls with weight: so look for the least place that fails
    found = least(lambda at: not trial(at).picked_up, place, 0, PLACES)
    return None if found.fails is None else trial(found.fails), list(made.values())


def main() -> int:
    """Find both weights, then write and print the table."""
    parser = argparse.ArgumentParser(
        prog="grasp_designs", description="The heaviest cube that two designs hold."
    )
    parser.add_argument("--pressure", type=float, default=100.0, metavar="kPa")
    parser.add_argument("--out", type=Path, default=Path("out/grasp_designs"), metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--publish", action="store_true", help="write into benchmarks/, too")
    asked = parser.parse_args()
    shared = configuration.load(None, asked.overrides, OURS)
    screen, rows = console(), []
    for name, (xi1, xi2) in DESIGNS.items():
        base = shared.changed(morph={"xi1": xi1, "xi2": xi2})
        best, made = heaviest(base, asked.pressure, asked.out)
        for each in sorted(made, key=lambda trial: trial.weight_N):
            screen.print(
                f"{name}: {each.weight_N:.3f} N, normal forces {each.normal_N:.3f} N: "
                f"{each.outcome}",
                markup=False,
            )
        held = {} if best is None else {"held_N": best.weight_N, "normal_N": best.normal_N}
        rows.append({"design": name, "morph.xi1": xi1, "morph.xi2": xi2, **held})
    for path in places(asked, TABLE):
        with path.open("w", encoding="utf-8", newline="") as file:
            names = ["design", "morph.xi1", "morph.xi2", "held_N", "normal_N"]
            table = csv.DictWriter(file, names, lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
    first, last = (float(row.get("held_N", float("nan"))) for row in rows)
    screen.print(f"OD3 holds {100 * (last / first - 1):.1f} % more than the original", markup=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
