"""Many grasps as one campaign: run what is missing, and a table of what became of them."""

from __future__ import annotations

import argparse
import csv
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from dolfingrip.cli import progress
from dolfingrip.cli.options import console
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign, grasps
from dolfingrip.design.campaign.cluster import Where
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.campaign.store import NAME, Store

FOOD, POSE = "food.kind", "gripper.pose"
PRESSURE, FRICTION = "experiment.max_pressure_kPa", "food.friction"

OURS = ("gripper.preset=coarse", "gripper.clearance_mm=4", "solver.time_limit_s=1800")
"""The coarse mesh, fingers near the food; a grasp that takes longer ends with what it has."""

FAILED = "failure: "
"""Before the class of a grasp that ended early with nothing decided."""

Row = dict[str, Any]


def plan(points: Sequence[Inputs], shared: Config) -> Plan:
    """The campaign of points that all vary the same keys."""
    return Plan(shared, tuple(points[0]), tuple(points), grasps.QUANTITIES, grasps.OBJECTIVE)


def options(name: str, description: str) -> argparse.ArgumentParser:
    """What both scripts may be told."""
    parser = argparse.ArgumentParser(prog=name, description=description)
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=Path("out") / name, metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--retry-failed", action="store_true", help="compute failures again")
    parser.add_argument("--publish", action="store_true", help="write into benchmarks/, too")
    return parser


def compute(points: Sequence[Inputs], shared: Config, asked: argparse.Namespace) -> list[Row]:
    """Compute what is missing; rows of all grasps that have an answer, also after Ctrl-C.

    Raises:
        SystemExit: one line, where that cannot be.
    """
    screen = console()
    try:
        with progress.designs(screen) as show:
            campaign.run(
                plan(points, shared), asked.out, Where(workers=asked.workers),
                retry_failed=asked.retry_failed, progress=show,
            )  # fmt: skip
    except (ConfigError, campaign.SchedulerGone) as error:
        raise SystemExit(str(error)) from None
    except KeyboardInterrupt:
        screen.print("interrupted; the same call goes on from there")
    return outcomes(points, shared, asked.out)


def outcomes(points: Sequence[Inputs], shared: Config, out: Path) -> list[Row]:
    """A row for each grasp that has an answer: what varies, the class, the figures."""
    if not (out / NAME).exists():
        return []
    with Store(out) as store:
        stored = {row["key"]: row for row in store.rows()}
    rows = []
    for number, design in enumerate(plan(points, shared).designs()):
        kept = stored.get(design.key)
        if kept is None or kept["status"] == "pending":
            continue
        curve, outputs = kept["curve"] or {}, kept["outputs"] or {}
        rows.append(
            {
                "grasp": number,
                **design.inputs,
                "outcome": curve.get("outcome", f"{FAILED}{kept['failure_class']}"),
                **{name: outputs.get(name) for name in grasps.QUANTITIES},
                "sentence": curve.get("sentence", kept["failure"]),
                "iterations": kept["iterations"],
                "wall_s": kept["wall_s"],
            }
        )
    return rows


def places(asked: argparse.Namespace, table: Path) -> list[Path]:
    """Where a table is written: into ``--out``, with ``--publish`` also at its own place."""
    return [asked.out / table.name, *([table] if asked.publish else [])]


def write_table(rows: Sequence[Row], path: Path) -> None:
    """A CSV of rows; nothing where there are none."""
    if not rows:
        return
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def counted(rows: Sequence[Row], said: str, asked: int, goal: str) -> str:
    """Number of grasps by what became of them, in Markdown."""
    ends = Counter(row["outcome"] for row in rows)
    well = sum(count for end, count in ends.items() if not end.startswith(FAILED))
    lines = [
        f"{said}; {len(rows)} of {asked} computed.",
        "",
        *("| outcome | grasps |", "|---|--:|"),
        *(f"| {end} | {count} |" for end, count in ends.most_common()),
        "",
        f"{well} of {len(rows)} end in a class; goal: {goal}.",
    ]
    return "\n".join(lines) + "\n"


def publish(
    rows: Sequence[Row],
    said: str,
    asked: argparse.Namespace,
    table: Path,
    draw: Callable[[Sequence[Row], Path], None] | None = None,
) -> None:
    """Write table, picture and summary into the campaign's folder; the first two beside this file.

    Args:
        rows: of the table.
        said: the summary.
        asked: options.
        table: where ``--publish`` puts the table; the picture has its name.
        draw: draws the rows.
    """
    asked.out.mkdir(parents=True, exist_ok=True)
    for path in places(asked, table):
        write_table(rows, path)
        if draw is not None and rows:
            draw(rows, path.with_suffix(".png"))
    (asked.out / "summary.md").write_text(said, encoding="utf-8")
    console().print(said, markup=False)
