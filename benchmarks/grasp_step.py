"""Halve the longest step in time of a grasp: how much angles and the pick-up pressure change.

    scripts/run python -m benchmarks.grasp_step [--halvings 1] [--out out/grasp_step]
        [--set gripper.preset=coarse] [--set gripper.clearance_mm=4] [--publish]

The cube is pinched up to 100 kPa. Angles are those before the lift; the pick-up pressure is where
normal forces, linear between readings, reach W/μ. A row whose grasp is in ``--out`` is not computed
again.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from benchmarks.grasp_campaign import places
from dolfingrip import config as configuration
from dolfingrip.cli.options import console
from dolfingrip.config import Config

OURS = (
    "gripper.preset=coarse", "gripper.clearance_mm=4", "gripper.lift_mm=10",
    "experiment.max_pressure_kPa=100", "experiment.step_kPa=12.5",
)  # fmt: skip

TABLE = Path(__file__).with_suffix(".csv")

LETTERS = "ABC"


def figures(columns: Mapping[str, Sequence[float]], friction: float) -> dict[str, float]:
    """Angles before the lift (°) and the pick-up pressure (kPa) of one grasp.

    Args:
        columns: of its result.
        friction: μ of fingers on food.
    """
    before = np.asarray(columns["table_z_mm"]) >= 0
    last = int(np.flatnonzero(before)[-1])
    loading = np.asarray([branch == "loading" for branch in columns["branch"]])
    pressure = np.asarray(columns["pressure_kPa"])[loading]
    normal = sum(np.asarray(columns[f"normal_{letter}_N"])[loading] for letter in LETTERS)
    wanted = float(columns["table_N"][0]) / friction
    reached = float(np.interp(wanted, normal, pressure)) if normal.max() >= wanted else np.nan
    angles = {f"angle_{letter}_deg": float(columns[f"angle_{letter}_deg"][last])
              for letter in LETTERS}  # fmt: skip
    return {**angles, "pickup_kPa": reached}


def row(config: Config, out: Path) -> dict[str, float]:
    """Figures of one grasp, kept in ``out``."""
    from dolfingrip.experiments import run

    step_s = config.gripper.step_s
    kept = out / f"step-{step_s:g}.json"
    if kept.exists():
        found: dict[str, float] = json.loads(kept.read_text(encoding="utf-8"))
        return found
    result = run("grasp", config)
    if result.failure is not None:
        raise SystemExit(f"step of {step_s:g} s: {result.failure.sentence()}")
    found = {
        "step_s": step_s,
        **figures(result.columns(), config.food.friction),
        "load_steps": float(sum(each["load_steps"] for each in result.rows)),
        "iterations": float(result.facts["newton"]["iterations"]),
    }
    out.mkdir(parents=True, exist_ok=True)
    kept.write_text(json.dumps(found), encoding="utf-8")
    return found


def main() -> int:
    """Compute what is missing, then write and print the table."""
    import pandas as pd

    parser = argparse.ArgumentParser(prog="grasp_step", description="Halve a grasp's steps.")
    parser.add_argument("--halvings", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=Path("out/grasp_step"), metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--publish", action="store_true", help="write into benchmarks/, too")
    asked = parser.parse_args()
    base = configuration.load(None, asked.overrides, OURS)
    steps = [base.gripper.step_s / 2**i for i in range(asked.halvings + 1)]
    rows = [row(base.changed(gripper={"step_s": step_s}), asked.out) for step_s in steps]
    table = pd.DataFrame(rows)
    change = (table.iloc[:-1] / table.iloc[1:].to_numpy() - 1).abs() * 100
    for path in places(asked, TABLE):
        table.to_csv(path, index=False, float_format="%.6g", lineterminator="\n")
    screen = console()
    screen.print(table.to_string(index=False), markup=False)
    for name in change.columns[1:5]:
        changes = ", ".join(f"{value:.3g} %" for value in change[name])
        screen.print(f"{name}: changes by {changes} as the step is halved", markup=False)
    return 0


if __name__ == "__main__":
    sys.exit(main())
