"""A finger with a barbed inlet, cut open, and the mould of a pneu-net, taken apart.

    scripts/run python docs/pictures/making.py

draws ``docs/making.png``.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np
import pyvista as pv

from dolfingrip import config
from dolfingrip.charts import theme
from dolfingrip.report import printable
from dolfingrip.report.scene import Image, View, aim, shot, stage

HERE = Path(__file__).resolve().parent
PICTURE = HERE.parent / "making.png"
EXAMPLE = HERE.parents[1] / "examples" / "pneunet_mould.toml"
APART_MM = {
    "half_1": (14.0, -34.0, 0.0),
    "half_2": (14.0, 34.0, 0.0),
    "core_plate": (0.0, 0.0, 0.0),
    "base_tray": (-34.0, 0.0, 0.0),
}
COLOURS = {
    "half_1": theme.BLUE, "half_2": theme.BLUE, "core_plate": theme.ORANGE, "base_tray": theme.GREEN
}  # fmt: skip


def pictured(parts: list[tuple[pv.PolyData, str]], view: View, turn: str) -> Image:
    """A picture of parts in colours; ``turn`` is the axis that points up."""
    for part, _ in parts:
        if turn == "x":  # the plate lies below
            part.points = np.asarray(part.points)[:, [2, 1, 0]] * [1, -1, 1]
    right, up, towards = view.axes
    seen = np.concatenate([np.asarray(part.points) for part, _ in parts])
    low, high = (f([seen @ right, seen @ up], axis=1) for f in (np.min, np.max))
    wide, tall = high - low + 4.0
    with stage(int(900 * wide / tall), 900) as plotter:
        for part, colour in parts:
            plotter.add_mesh(part, color=colour, ambient=0.35)
            lines = part.extract_feature_edges(30)
            plotter.add_mesh(lines, color=theme.INK, line_width=1.6)
        middle = (low + high) / 2
        focus = middle[0] * right + middle[1] * up + np.mean(seen @ towards) * towards
        aim(plotter, focus, view, far=3 * float(np.ptp(seen, axis=0).max()), height_mm=tall)
        return shot(plotter)


def finger(folder: Path) -> Image:
    """The reference finger with a barbed inlet, of which half is shown."""
    wanted = config.load(None, {"inlet.kind": "barb"})
    printable.write(wanted, folder / "finger.stl")
    half = pv.read(folder / "finger.stl").clip_closed_surface(normal="y", origin=(0, 0, 0))
    return pictured([(half, theme.PALE)], View(azimuth_deg=-32.0, elevation_deg=12.0), "z")


def mould(folder: Path) -> Image:
    """The mould of the example, its parts moved apart."""
    printable.write_mould(config.load(EXAMPLE), folder)
    parts = []
    for name, by in APART_MM.items():
        part = pv.read(folder / f"{name}.stl")
        part.translate(by, inplace=True)
        parts.append((part, COLOURS[name]))
    return pictured(parts, View(azimuth_deg=40.0, elevation_deg=28.0, up=1.0), "x")


if __name__ == "__main__":
    with TemporaryDirectory() as made:
        images = [finger(Path(made)), mould(Path(made))]
    with theme.figure_theme():
        widths = [image.shape[1] / image.shape[0] for image in images]
        figure, panels = plt.subplots(
            1, 2, figsize=(7.2, 3.4), width_ratios=widths, layout="constrained"
        )
        for axes, image in zip(panels, images, strict=True):
            axes.imshow(image)
            axes.axis("off")
        figure.savefig(PICTURE, dpi=200, bbox_inches="tight", pad_inches=0.03)
    print(f"wrote {PICTURE}")
