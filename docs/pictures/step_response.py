"""The finger after its pressure rises to 100 kPa in 50 ms.

    scripts/run python docs/pictures/step_response.py

draws ``docs/step_response.png``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.experiments import Result, run

PICTURE = Path(__file__).resolve().parents[1] / "step_response.png"
COARSE = {"mesh.size_mm": 12.0, "mesh.edge_size_mm": 3.0, "contact.self_contact": False,
          "experiment.max_pressure_kPa": 100.0, "experiment.step_kPa": 100.0}  # fmt: skip
RISE_S, END_S, EVERY_S = 0.05, 0.5, 0.01


def moving() -> Result:
    """The finger in time."""
    times = np.arange(0, END_S + EVERY_S / 2, EVERY_S)
    pressures = 100 * np.minimum(times / RISE_S, 1.0)
    protocol = {"time_s": times.tolist(), "pressure_kPa": pressures.tolist()}
    asked = config.load(None, {**COARSE, "solver.time_error_mm": 0.1, "experiment.dynamic": True})
    return run("bending", asked.changed(protocol=protocol))


def draw(time_s: np.ndarray, angle_deg: np.ndarray, still_deg: float) -> None:
    """Draw the angle over time."""
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(7.2, 2.9), layout="constrained")
        axes.plot(time_s, angle_deg, color=theme.BLUE, label="in motion")
        axes.axhline(still_deg, color=theme.INK, linewidth=1, label="at rest at 100 kPa")
        axes.axvspan(0, RISE_S, color=theme.PALE, label="the pressure rises")
        axes.set(xlabel="Time (s)", ylabel="Tip angle (°)", xlim=(0, END_S))
        axes.legend(loc="lower right", ncols=3)
        figure.savefig(PICTURE, dpi=200)


if __name__ == "__main__":
    still = run("bending", config.load(None, COARSE)).column("angle_deg")[-1]
    found = moving()
    draw(found.column("time_s"), found.column("angle_deg"), still)
    print(f"wrote {PICTURE}")
