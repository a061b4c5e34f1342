"""Friction planted on one mesh and found on another, from pick-up pressures in steps of 5 kPa.

    scripts/run python -m benchmarks.planted_friction [--out out/planted_friction]
        [--friction 0.2 --friction 0.38 --friction 0.7] [--publish]

The least pressures that pick up two cubes are found on the coarse preset with a known friction, and
``dolfingrip friction``'s search finds the friction from the first on another mesh. A step r of
pressures leaves μ open by at least r/(p − p₀) of it, p₀ the pressure of first touch: so cubes are
as heavy as pick-up pressures near 130 kPa need, and the second, whose weight differs by a part of
what a step of pressure lifts, narrows the interval. A call resumes one that was killed.
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
from dolfingrip.design.campaign.calibration import FrictionFound, friction, narrowed
from dolfingrip.design.campaign.pickup import ESTIMATES, pickup_pressure
from dolfingrip.design.campaign.trials import LIFT_MM, Trial, Trials

OURS = ("gripper.preset=coarse", "gripper.clearance_mm=4", f"gripper.lift_mm={LIFT_MM:g}")

OTHER_MESH = ("mesh.size_mm=7", "mesh.edge_size_mm=7")
"""A fifth more elements than the coarse preset's, elsewhere."""

DENSITIES_KG_M3: Mapping[float, float] = {0.2: 2000.0, 0.38: 3800.0, 0.7: 8000.0}
"""Of the first cube, by the friction that is planted."""

HEAVIER = (1.0, 1.015)
"""Weights of both cubes relative to the first: 5 kPa lift about 4 % more."""

RESOLUTION_KPA, START_KPA, TOLERANCE = 5.0, 115.0, 0.005

TABLE = Path(__file__).with_suffix(".csv")


def recovered(planted: float, base: Config, other: Config, out: Path) -> dict[str, float]:
    """Pick-up pressures with a friction, and what is found from them.

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

    first = DENSITIES_KG_M3.get(planted, DENSITIES_KG_M3[0.38])
    found: FrictionFound | None = None
    row = {"planted": planted, "density_kg_m3": first}
    for number, heavier in enumerate(HEAVIER, 1):
        food = {"density_kg_m3": first * heavier}
        screen.print(f"planted: μ = {planted:g}, cube {number}", markup=False)
        planting = base.changed(food={**food, "friction": planted})
        near = row.get("pickup_1_kPa")
        pressure = pickup_pressure(
            Trials(planting, out, show),
            RESOLUTION_KPA,
            near or START_KPA,
            estimates=0 if near else ESTIMATES,
        ).least_kPa
        if pressure is None:
            raise SystemExit(f"μ = {planted:g}: not picked up at any pressure")
        screen.print(f"picked up from {pressure:g} kPa on; sought:", markup=False)
        # the search starts from a friction that tells nothing of the planted one
        trials = Trials(other.changed(food=food), out, show)
        found = (
            friction(trials, pressure, RESOLUTION_KPA, TOLERANCE)
            if found is None
            else narrowed(found, trials, pressure, RESOLUTION_KPA)
        )
        screen.print(f"μ from {found.low:.4g} to {found.high:.4g}", markup=False)
        row |= {
            f"pickup_{number}_kPa": pressure,
            f"low_{number}": found.low,
            f"high_{number}": found.high,
        }
    assert found is not None
    return {**row, "found": found.friction, "error": found.friction - planted}


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
