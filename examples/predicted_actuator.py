"""An actuator that was predicted before its measurement was looked at.

Two cast actuators of Ecoflex 30 with walls of 7 mm were measured, and a third with walls of 10 mm.
Laws were fitted to the first two. The committed prediction of the third has a median and a 90 %
interval for each of eight pressures. Chambers balloon: the angle rises steeply where the pressure
in the chambers passes the most that their walls can bear, so a small error of the pressure is a
large one of the angle. A prediction is therefore judged by both:

    the share of readings within the interval (0.9 is meant)
    the ballooning pressure, where the measured curve is steepest

    scripts/run python examples/predicted_actuator.py
"""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

FOLDER = Path(__file__).with_name("ecoflex_actuators")
SMOOTHED_kPa = 2.0
"""Length over which the slope of the measured curve is taken."""


class Found(NamedTuple):
    """Prediction and measurement.

    Attributes:
        table: pressure (kPa), median and interval, and the measured angle (deg).
        within: number of measured angles in their interval.
        ballooning_kPa: predicted; then measured.
    """

    table: pd.DataFrame
    within: int
    ballooning_kPa: tuple[float, float]


def steepest_kPa(measured: pd.DataFrame) -> float:
    """Pressure at which the angle rises most."""
    pressure, angle = measured["pressure_kPa"], measured["chord_angle_deg"]
    grid = np.arange(pressure.min(), pressure.max() - SMOOTHED_kPa, SMOOTHED_kPa / 10)
    rise = np.interp(grid + SMOOTHED_kPa, pressure, angle) - np.interp(grid, pressure, angle)
    return float(grid[np.argmax(rise)] + SMOOTHED_kPa / 2)


def main() -> Found:
    """Read both and compare."""
    table = pd.read_csv(FOLDER / "prediction_c5-w10.csv", comment="#")
    measured = pd.read_csv(FOLDER / "bending_c5-w10.csv")
    table["measured_deg"] = np.interp(
        table["pressure_kPa"], measured["pressure_kPa"], measured["chord_angle_deg"]
    )
    inside = table["measured_deg"].between(table["low_deg"], table["high_deg"])
    told = tomllib.loads((FOLDER / "prediction_c5-w10.toml").read_text(encoding="utf-8"))
    predicted = float(told["ballooning_pressure_kPa"])
    return Found(table, int(inside.sum()), (predicted, steepest_kPa(measured)))


if __name__ == "__main__":
    found = main()
    print(found.table.round(1).to_string(index=False))
    print(f"{found.within} of {len(found.table)} readings in the 90 % interval")
    print("ballooning at {:.1f} kPa predicted, {:.1f} kPa measured".format(*found.ballooning_kPa))
