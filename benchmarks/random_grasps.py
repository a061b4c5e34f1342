"""Random grasps: food, pose, pressure and friction at random; how many end in a class of outcome.

    scripts/run python -m benchmarks.random_grasps [--number 100] [--seed 0] [--workers 1]
        [--out out/random_grasps] [--publish]

Food is one of the kinds, the pose scoop, pinch or claw, the pressure 100 to 300 kPa, friction 0.1
to 0.8; a gripper that cannot stand so is drawn again. The mesh is the coarse preset. A longer table
of the same seed contains the shorter one, and a call resumes one that was killed.

``outcomes.csv`` has a row for each grasp that was computed, ``summary.md`` the counts;
``--publish`` copies the table to ``benchmarks/random_grasps.csv``.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.options import console
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign, grasps
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.campaign.store import Store
from dolfingrip.sections.food import ORDINARY
from dolfingrip.sections.gripper import GripPose

FOOD, POSE = "food.kind", "gripper.pose"
PRESSURE, FRICTION = "experiment.max_pressure_kPa", "food.friction"
DRAWN = (FOOD, POSE, PRESSURE, FRICTION)

PRESSURES_KPA, FRICTIONS = (100.0, 300.0), (0.1, 0.8)

OURS = ("gripper.preset=coarse", "solver.time_limit_s=1800")

GOAL = 0.97
"""Required part of grasps that end in a class."""

TABLE = Path(__file__).with_name("random_grasps.csv")


def draw(number: int, seed: int, shared: Config) -> list[Inputs]:
    """The first ``number`` possible grasps of a seed."""
    rng = np.random.default_rng(seed)
    found: list[Inputs] = []
    while len(found) < number:
        inputs: Inputs = {
            FOOD: str(rng.choice(list(ORDINARY))),
            POSE: str(rng.choice(list(get_args(GripPose)))),
            PRESSURE: round(float(rng.uniform(*PRESSURES_KPA)), 1),
            FRICTION: round(float(rng.uniform(*FRICTIONS)), 3),
        }
        if possible(inputs, shared):
            found.append(inputs)
    return found


def possible(inputs: Inputs, shared: Config) -> bool:
    """Whether fingers can stand around the food so."""
    from dolfingrip.experiments.rigs.grasped import grasped
    from dolfingrip.experiments.rigs.gripper import stands_of

    config = configuration.from_dict(plan([inputs], shared).designs()[0].config)
    try:
        stands_of(config, grasped(config.food))
    except ConfigError:
        return False
    return True


def base(overrides: Sequence[str] = ()) -> Config:
    """What all grasps share."""
    return configuration.load(None, overrides, OURS)


def plan(points: Sequence[Inputs], shared: Config) -> Plan:
    """The campaign."""
    return Plan(shared, DRAWN, tuple(points), grasps.QUANTITIES, grasps.OBJECTIVE)


def outcomes(out: Path, points: Sequence[Inputs], shared: Config) -> list[dict[str, Any]]:
    """A row for each grasp that was computed: what was drawn, the class, the figures."""
    designs = plan(points, shared).designs()
    with Store(out) as store:
        stored = {row["key"]: row for row in store.rows()}
    rows = []
    for number, design in enumerate(designs):
        kept = stored.get(design.key)
        if kept is None or kept["status"] == "pending":
            continue
        curve, outputs = kept["curve"] or {}, kept["outputs"] or {}
        rows.append(
            {
                "grasp": number,
                **design.inputs,
                "outcome": curve.get("outcome", f"failure: {kept['failure_class']}"),
                **{name: outputs.get(name) for name in grasps.QUANTITIES},
                "sentence": curve.get("sentence", kept["failure"]),
                "iterations": kept["iterations"],
                "wall_s": kept["wall_s"],
            }
        )
    return rows


def write_table(rows: Sequence[dict[str, Any]], path: Path) -> None:
    """A CSV of rows; nothing where there are none."""
    if not rows:
        return
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def summary(rows: Sequence[dict[str, Any]], seed: int) -> str:
    """Number of grasps by what became of them."""
    ends = Counter(row["outcome"] for row in rows)
    well = sum(count for end, count in ends.items() if not end.startswith("failure"))
    lines = [
        f"{len(rows)} random grasps of seed {seed}, coarse preset.",
        "",
        *("| outcome | grasps |", "|---|--:|"),
        *(f"| {end} | {count} |" for end, count in ends.most_common()),
        "",
        f"{well} of {len(rows)} end in a class; goal: {GOAL:.0%} or more.",
    ]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Compute what is missing, then write the table and the summary."""
    parser = argparse.ArgumentParser(
        prog="random_grasps", description="Random grasps, and how many end in a class."
    )
    parser.add_argument("--number", type=int, default=100, metavar="N", help="default: 100")
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="default: 0")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=Path("out/random_grasps"), metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--retry-failed", action="store_true", help="compute failures again")
    parser.add_argument("--publish", action="store_true", help=f"write {TABLE.name}, too")
    asked = parser.parse_args()
    for name in ("number", "workers"):
        if getattr(asked, name) < 1:
            parser.error(f"--{name} {getattr(asked, name)}: allowed: 1 or more")
    screen = console()
    try:
        shared = base(asked.overrides)
        points = draw(asked.number, asked.seed, shared)
        screen.print(f"random grasps: {len(points)} of seed {asked.seed}", soft_wrap=True)
        with progress.designs(screen) as show:
            campaign.run(
                plan(points, shared), asked.out, Where(workers=asked.workers),
                retry_failed=asked.retry_failed, progress=show,
            )  # fmt: skip
    except ConfigError as error:
        parser.error(str(error))
    except campaign.SchedulerGone as gone:
        screen.print(f"random grasps: {gone}", soft_wrap=True)
        return 1
    finally:
        rows = (
            outcomes(asked.out, points, shared) if (asked.out / "campaign.sqlite").exists() else []
        )
        write_table(rows, asked.out / "outcomes.csv")
        if asked.publish:
            write_table(rows, TABLE)
        screen.print(summary(rows, asked.seed), markup=False)
    (asked.out / "summary.md").write_text(summary(rows, asked.seed), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
