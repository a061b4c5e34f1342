"""Friction planted on one mesh and found on another, from pick-up pressures in steps of 5 kPa.

    scripts/run python -m benchmarks.planted_friction [--out out/planted_friction]
        [--friction 0.2 --friction 0.38 --friction 0.7] [--publish]

The least pressure that picks up a cube is found on the coarse preset with a known friction, and
``dolfingrip friction``'s search finds the friction from it on another mesh. A step r of pressures
leaves μ open by about r/(p − p₀) of it, p₀ the pressure of first touch: so each cube is as heavy as
its pick-up pressure needs to be 110 to 125 kPa. A call resumes one that was killed.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping
from pathlib import Path

from benchmarks.grasp_campaign import places
from dolfingrip import config as configuration
from dolfingrip.cli.options import console
from dolfingrip.config import Config
from dolfingrip.design.campaign.pickup import LIFT_MM, Trial, Trials, friction, pickup_pressure

OURS = ("gripper.preset=coarse", "gripper.clearance_mm=4", f"gripper.lift_mm={LIFT_MM:g}")

OTHER_MESH = ("mesh.size_mm=7", "mesh.edge_size_mm=7")
"""A fifth more elements than the coarse preset's, elsewhere."""

DENSITIES_KG_M3: Mapping[float, float] = {0.2: 2000.0, 0.38: 3800.0, 0.7: 8000.0}
"""Of the cube, by the friction that is planted."""

RESOLUTION_KPA, START_KPA, TOLERANCE = 5.0, 115.0, 0.005

TABLE = Path(__file__).with_suffix(".csv")


def recovered(planted: float, base: Config, other: Config, out: Path) -> dict[str, float]:
    """Pick-up pressure with a friction, and what is found from it.

    Args:
        planted: the friction.
        base: configuration with which it is planted.
        other: that of the search.
        out: where grasps are kept.
    """
    screen = console()

    def show(trial: Trial) -> None:
        screen.print(
            f"  {trial.pressure_kPa:g} kPa, μ = {trial.friction:.4g}: {trial.outcome}", markup=False
        )

    food = {"density_kg_m3": DENSITIES_KG_M3.get(planted, DENSITIES_KG_M3[0.38])}
    screen.print(f"planted: μ = {planted:g}", markup=False)
    planting = base.changed(food={**food, "friction": planted})
    pressure = pickup_pressure(Trials(planting, out, show), RESOLUTION_KPA, START_KPA)
    if pressure.least_kPa is None:
        raise SystemExit(f"μ = {planted:g}: not picked up at any pressure")
    screen.print(f"picked up from {pressure.least_kPa:g} kPa on; sought:", markup=False)
    # the search starts from a friction that tells nothing of the planted one
    trials = Trials(other.changed(food=food), out, show)
    found = friction(trials, pressure.least_kPa, RESOLUTION_KPA, TOLERANCE)
    return {
        "planted": planted,
        "density_kg_m3": food["density_kg_m3"],
        "pickup_kPa": pressure.least_kPa,
        "low": found.low,
        "high": found.high,
        "found": found.friction,
        "error": found.friction - planted,
    }


def main() -> int:
    """Compute what is missing, then write and print the table."""
    import pandas as pd

    parser = argparse.ArgumentParser(
        prog="planted_friction", description="Friction planted on one mesh, found on another."
    )
    parser.add_argument("--friction", type=float, action="append", metavar="MU")
    parser.add_argument("--out", type=Path, default=Path("out/planted_friction"), metavar="FOLDER")
    parser.add_argument("--publish", action="store_true", help="write into benchmarks/, too")
    asked = parser.parse_args()
    base = configuration.load(None, [], OURS)
    other = configuration.load(None, OTHER_MESH, OURS)
    rows = [recovered(mu, base, other, asked.out) for mu in asked.friction or DENSITIES_KG_M3]
    table = pd.DataFrame(rows)
    for path in places(asked, TABLE):
        table.to_csv(path, index=False, float_format="%.6g", lineterminator="\n")
    console().print(table.to_string(index=False), markup=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
