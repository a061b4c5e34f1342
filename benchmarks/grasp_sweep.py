"""The paper's Fig. 6: angles of thumb and finger against pressure, four foods, 200 to 300 kPa.

    scripts/run python -m benchmarks.grasp_sweep [--workers 2] [--out out/grasp_sweep] [--publish]
        [--set gripper.preset=default]

Sausages are pinched, potatoes stand between three fingers at α = 30°: the paper prints neither pose
nor distances. The mesh is the coarse preset. A call resumes one that was killed.

``grasp_sweep.csv`` has a row for each grasp, ``grasp_sweep.png`` the angles before the lift;
``--publish`` writes both beside this file, too.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from benchmarks import grasp_campaign
from benchmarks.grasp_campaign import FOOD, PRESSURE, Row
from dolfingrip import config as configuration
from dolfingrip.design.campaign.space import Inputs

ALPHA = "gripper.alpha_deg"

ALPHAS_DEG = {
    "sausage-long": 90.0,
    "sausage-short": 90.0,
    "potato-small": 30.0,
    "potato-large": 30.0,
}
"""Food by food, how fingers B and C are turned."""

PRESSURES_KPA = (200.0, 225.0, 250.0, 275.0, 300.0)

TABLE = Path(__file__).with_suffix(".csv")


def points() -> list[Inputs]:
    """The twenty grasps."""
    return [
        {FOOD: food, ALPHA: alpha, PRESSURE: pressure}
        for food, alpha in ALPHAS_DEG.items()
        for pressure in PRESSURES_KPA
    ]


def draw(rows: Sequence[Row], path: Path) -> None:
    """Angles against pressure, a panel for each food; hollow where it was not picked up."""
    import matplotlib.pyplot as plt

    from dolfingrip.report import theme

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


def main() -> int:
    """Run what is missing, then write table, picture and summary."""
    parser = grasp_campaign.options("grasp_sweep", "Four foods from 200 to 300 kPa.")
    asked = parser.parse_args()
    shared = configuration.load(None, asked.overrides, grasp_campaign.OURS)
    wanted = points()
    rows = grasp_campaign.compute(wanted, shared, asked)
    summary = grasp_campaign.counted(rows, "Fig. 6", len(wanted), "20 of 20")
    grasp_campaign.publish(rows, summary, asked, TABLE, draw)
    return 0


if __name__ == "__main__":
    sys.exit(main())
