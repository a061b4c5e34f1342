"""Draws what ``fit.py`` and ``dolfingrip predict`` wrote: ``measured_actuators.png``.

scripts/run python examples/ecoflex_actuators/plot.py docs/measured_actuators.png
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes

mpl.use("Agg")
from matplotlib import pyplot as plt

HERE = Path(__file__).resolve().parent
COLOURS = {"c5-w7": "#0072b2", "c7-w7": "#d55e00", "c5-w10": "#009e73"}
NAMES = {"c5-w7": "5 chambers, walls of 7 mm", "c7-w7": "7 chambers, walls of 7 mm",
         "c5-w10": "5 chambers, walls of 10 mm"}  # fmt: skip


def band(axes: Axes, table: pd.DataFrame, colour: str, label: str) -> None:
    """A prediction: median and 90 % interval."""
    pressure = table["pressure_kPa"]
    axes.fill_between(pressure, table["low_deg"], table["high_deg"], color=colour, alpha=0.2, lw=0)
    axes.plot(pressure, table["chord_angle_deg"], color=colour, label=label)


def dots(axes: Axes, table: pd.DataFrame, column: str, label: str) -> None:
    """A measurement."""
    axes.plot(
        table["pressure_kPa"], table[column], "o", ms=3, mfc="none", color="black", label=label
    )


def main() -> None:
    """Read both tables and draw."""
    readings = pd.read_csv(HERE / "predicted.csv")
    third = pd.read_csv(HERE / "prediction_c5-w10.csv", comment="#")
    later = pd.read_csv(HERE / "bending_c5-w10.csv")
    figure, panels = plt.subplots(1, 3, figsize=(12.5, 4.0), layout="constrained", sharey=True)
    for axes, specimen, other in zip(panels, ("c7-w7", "c5-w7"), ("c5-w7", "c7-w7"), strict=False):
        own = readings[readings["specimen"] == specimen]
        band(axes, own, COLOURS[specimen], f"predicted from {other} and the coupon, 90 %")
        dots(axes, own, "measured_deg", "measured")
        axes.set_title(NAMES[specimen])
    band(panels[2], third, COLOURS["c5-w10"], "predicted from both and the coupon, 90 %")
    panels[2].plot(third["pressure_kPa"], third["chord_angle_deg"], ".", color=COLOURS["c5-w10"])
    dots(panels[2], later[::4], "chord_angle_deg", "measured, looked at after the prediction")
    panels[2].set_title(NAMES["c5-w10"])
    panels[0].set_ylabel("Chord angle (°)")
    for axes in panels:
        axes.set_xlabel("Pressure (kPa)")
        axes.grid(alpha=0.3)
        axes.legend(frameon=False, loc="upper left", fontsize=9)
    figure.savefig(Path(sys.argv[1]), dpi=150)


if __name__ == "__main__":
    main()
