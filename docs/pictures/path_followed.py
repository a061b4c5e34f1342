"""The way of a tip that a design follows.

    scripts/run dolfingrip design examples/path_design.toml --out out/path_design
    scripts/run python docs/pictures/path_followed.py [out/path_design]

draws ``docs/path_followed.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from dolfingrip import config
from dolfingrip.channels import PRESSURE, marker
from dolfingrip.charts import theme
from dolfingrip.config import Config, changed
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import compute

ROOT = Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs" / "path_followed.png"


def way(finger: Config, pressures_kPa: tuple[float, ...]) -> np.ndarray:
    """Places (n, 2) of the tip at some pressures."""
    names = tuple(marker(1, axis).name for axis in "xz")
    places = tuple(Place(PRESSURE.name, each) for each in pressures_kPa)
    asked = changed(finger, {"camera.markers": 1})
    found = compute(Request.of("bending", asked, columns=names, places=places)).columns
    return np.stack([found[name] for name in names], axis=1)


def draw(folder: Path) -> None:
    """Draw the places that are asked for, and those of start and design."""
    start = read(ROOT / "examples" / "path_design.toml").nominal.base
    design = config.load(folder / "design.toml")
    target = start.curve
    assert target is not None
    assert target.pressure_kPa is not None
    with theme.figure_theme():
        figure, axes = plt.subplots(figsize=(4.6, 3.8), layout="constrained")
        asked = {"ms": 12, "mfc": "none", "color": theme.INK, "label": "asked for"}
        axes.plot(target.x_mm, target.z_mm, "o", **asked)
        for x, z, pressure in zip(target.x_mm, target.z_mm, target.pressure_kPa, strict=True):
            axes.annotate(f"{pressure:g} kPa", (x + 2, z), va="center")
        for finger, name, colour in ((start, "start", "0.6"), (design, "design", theme.BLUE)):
            axes.plot(*way(finger, target.pressure_kPa).T, "o-", color=colour, label=name)
        axes.set(xlabel="x (mm)", ylabel="z (mm)")
        axes.invert_yaxis()
        axes.legend()
        figure.savefig(PICTURE, dpi=150)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out/path_design"))
    print(f"wrote {PICTURE}")
