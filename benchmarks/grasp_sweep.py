"""The paper's Fig. 6: angles of thumb and finger against pressure, four foods, 200 to 300 kPa.

    scripts/run python -m benchmarks.grasp_sweep [--workers 2] [--out out/grasp_sweep] [--publish]
        [--set gripper.preset=default]

Sausages are pinched, potatoes stand between three fingers at α = 30°: the paper prints neither pose
nor distances. The mesh is the coarse preset. A call resumes one that was killed.

``grasp_sweep.csv`` has a row for each grasp, ``docs/grasp_sweep.png`` the angles before the lift;
``--publish`` also writes both into the folder of this file.
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from dolfingrip import config as configuration
from dolfingrip.cli import progress
from dolfingrip.cli.console import console
from dolfingrip.config import Config, ConfigError
from dolfingrip.design.campaign import campaign
from dolfingrip.design.campaign.plan import Plan
from dolfingrip.design.campaign.space import Inputs
from dolfingrip.design.quantities.grasp import QUANTITIES
from dolfingrip.jobs.cluster import Where
from dolfingrip.jobs.pool import SchedulerGone
from dolfingrip.jobs.store import NAME
from dolfingrip.sections.tables import assignments

FOOD, ALPHA, PRESSURE = "food.kind", "gripper.alpha_deg", "experiment.max_pressure_kPa"

OURS = ("gripper.preset=coarse", "gripper.clearance_mm=4", "solver.time_limit_s=1800")
"""The coarse mesh, fingers near the food; a grasp that takes longer ends with what it has."""

ALPHAS_DEG = {
    "sausage-long": 90.0,
    "sausage-short": 90.0,
    "potato-small": 30.0,
    "potato-large": 30.0,
}
"""Food by food, how fingers B and C are turned."""

PRESSURES_KPA = (200.0, 225.0, 250.0, 275.0, 300.0)

FAILED = "failure: "
"""Before the class of a grasp that ended early with nothing decided."""

TABLE = Path(__file__).with_suffix(".csv")
PICTURE = TABLE.parents[1] / "docs" / "grasp_sweep.png"

Row = dict[str, Any]


def points() -> list[Inputs]:
    """The twenty grasps."""
    return [
        {FOOD: food, ALPHA: alpha, PRESSURE: pressure}
        for food, alpha in ALPHAS_DEG.items()
        for pressure in PRESSURES_KPA
    ]


def plan(points: Sequence[Inputs], shared: Config) -> Plan:
    """The campaign of points that all vary the same keys."""
    return Plan(shared, tuple(points[0]), tuple(points), QUANTITIES)


def compute(points: Sequence[Inputs], shared: Config, asked: argparse.Namespace) -> list[Row]:
    """Compute what is missing; rows of all grasps that have an answer, also after Ctrl-C.

    Raises:
        SystemExit: one line, where that cannot be.
    """
    screen = console()
    try:
        with progress.jobs(screen, "designs", progress.FEW) as show:
            campaign.run(
                plan(points, shared), asked.out, Where(workers=asked.workers),
                retry_failed=asked.retry_failed, progress=show,
            )  # fmt: skip
    except (ConfigError, SchedulerGone) as error:
        raise SystemExit(str(error)) from None
    except KeyboardInterrupt:
        screen.print("interrupted; the same call goes on from there")
    return outcomes(points, shared, asked.out)


def outcomes(points: Sequence[Inputs], shared: Config, out: Path) -> list[Row]:
    """A row for each grasp that has an answer: what varies, the class, the figures."""
    if not (out / NAME).exists():
        return []
    stored = campaign.read(out).by_key()
    rows = []
    for number, design in enumerate(plan(points, shared).designs()):
        kept = stored.get(design.key)
        if kept is None or kept.status == "pending":
            continue
        curve, outputs = kept.curve or {}, kept.outputs or {}
        rows.append(
            {
                "grasp": number,
                **design.inputs,
                "outcome": curve.get("outcome", f"{FAILED}{kept.failure_class}"),
                **{name: outputs.get(name) for name in QUANTITIES},
                "sentence": curve.get("sentence", kept.failure),
                "iterations": kept.iterations,
                "wall_s": kept.wall_s,
            }
        )
    return rows


def write_table(rows: Sequence[Row], path: Path) -> None:
    """A CSV of rows; nothing where there are none."""
    if not rows:
        return
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        for row in rows:
            table.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})


def counted(rows: Sequence[Row], asked: int) -> str:
    """Number of grasps by what became of them, in Markdown."""
    ends = Counter(row["outcome"] for row in rows)
    well = sum(count for end, count in ends.items() if not end.startswith(FAILED))
    lines = [
        f"Fig. 6; {len(rows)} of {asked} computed.",
        "",
        *("| outcome | grasps |", "|---|--:|"),
        *(f"| {end} | {count} |" for end, count in ends.most_common()),
        "",
        f"{well} of {len(rows)} end in a class; goal: 20 of 20.",
    ]
    return "\n".join(lines) + "\n"


def draw(rows: Sequence[Row], path: Path) -> None:
    """Angles against pressure, a panel for each food; hollow where it was not picked up."""
    import matplotlib.pyplot as plt

    from dolfingrip.charts import theme

    with theme.figure_theme():
        figure, panels = plt.subplots(
            1, len(ALPHAS_DEG), figsize=(9.6, 2.8), sharey=True, layout="constrained"
        )
        for axes, food in zip(panels, ALPHAS_DEG, strict=True):
            mine = [row for row in rows if row[FOOD] == food and row["angle_A_deg"] is not None]
            for column, label, colour in (
                ("angle_A_deg", "thumb", theme.GREEN),
                ("angle_B_deg", "finger", theme.BLUE),
            ):
                axes.plot(
                    [row[PRESSURE] for row in mine],
                    [row[column] for row in mine],
                    "-",
                    color=colour,
                )
                for row in mine:
                    axes.plot(
                        row[PRESSURE],
                        row[column],
                        "o",
                        color=colour,
                        markerfacecolor=colour if row["outcome"] == "picked up" else "none",
                    )
                axes.plot([], [], "o-", color=colour, label=label)
            axes.set_title(food.replace("-", ", "), fontsize=9)
            axes.set(xlabel="pressure (kPa)", xlim=(190, 310))
        panels[0].set_ylabel("angle before the lift (°)")
        panels[0].legend()
        figure.savefig(path)
        plt.close(figure)


def publish(rows: Sequence[Row], asked: argparse.Namespace) -> None:
    """Write table, picture and summary into ``--out``; ``--publish``: also the committed ones."""
    asked.out.mkdir(parents=True, exist_ok=True)
    files = [(asked.out / TABLE.name, (asked.out / TABLE.name).with_suffix(".png"))]
    if asked.publish:
        files.append((TABLE, PICTURE))
    for table, picture in files:
        write_table(rows, table)
        if rows:
            draw(rows, picture)
    said = counted(rows, len(points()))
    (asked.out / "summary.md").write_text(said, encoding="utf-8")
    console().print(said, markup=False)


def parsed(arguments: Sequence[str] | None = None) -> argparse.Namespace:
    """Parse the command line."""
    name = "grasp_sweep"
    parser = argparse.ArgumentParser(prog=name, description="Four foods from 200 to 300 kPa.")
    parser.add_argument("--workers", type=int, default=1, metavar="N", help="default: 1")
    parser.add_argument("--out", type=Path, default=Path("out") / name, metavar="FOLDER")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", dest="overrides")
    parser.add_argument("--retry-failed", action="store_true", help="compute failures again")
    parser.add_argument("--publish", action="store_true", help="write into benchmarks/, too")
    return parser.parse_args(arguments)


def main() -> int:
    """Run what is missing, then write table, picture and summary."""
    asked = parsed()
    shared = configuration.load(None, assignments(asked.overrides), assignments(OURS))
    publish(compute(points(), shared, asked), asked)
    return 0


if __name__ == "__main__":
    sys.exit(main())
