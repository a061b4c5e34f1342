"""The tip of a beam of silicone after it is let go, as it was measured.

    scripts/run python docs/pictures/released_beam.py

draws ``docs/released_beam.png``.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import pandas as pd

from dolfingrip.charts import theme

DOCS = Path(__file__).resolve().parents[1]
PICTURE = DOCS / "released_beam.png"
DATA = DOCS.parent / "examples" / "released_beam" / "ring_down.csv"
COLOURS = {0: theme.BLUE, 52: theme.ORANGE, 101: theme.GREEN}
"""Colours by the mass on the tip (g)."""

if __name__ == "__main__":
    table = pd.read_csv(DATA)
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(5.6, 3.6), layout="constrained")
        for mass_g, colour in COLOURS.items():
            name = next(name for name in table["specimen"] if name.startswith(f"{mass_g} g "))
            rows = table[table["specimen"] == name]
            axes.plot(
                rows["time_s"], rows["tip_x_mm"], color=colour, label=f"{mass_g} g on the tip"
            )
        axes.set(xlabel="Time (s)", ylabel="Tip, measured (mm)", xlim=(0, 2.5))
        axes.legend()
        figure.savefig(PICTURE, dpi=150)
    print(f"wrote {PICTURE}")
