"""What two examples of designs reach: the way of a tip, and the pressure on a sausage.

    scripts/run dolfingrip design examples/path_design.toml --out out/path_design
    scripts/run dolfingrip design examples/wrap_design.toml --out out/wrap_design
    scripts/run python docs/pictures/path_and_wrap.py [out/path_design out/wrap_design]

draws ``docs/path_and_wrap.png``.
"""

from __future__ import annotations

import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib.pyplot as plt
import numpy as np

from dolfingrip import config
from dolfingrip.channels import CONTACT, OBSTACLE, PRESSURE, marker
from dolfingrip.charts import theme
from dolfingrip.config import Config, changed
from dolfingrip.design.gradient.read import read
from dolfingrip.experiments import run
from dolfingrip.experiments.request import Place, Request
from dolfingrip.experiments.simulate import compute
from dolfingrip.report.fields import list_steps, read_steps

ROOT = Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs" / "path_and_wrap.png"
FORCE_N = 2.0


def ends(example: str, folder: Path) -> tuple[Config, Config]:
    """The configurations at which an example begins and ends."""
    return read(ROOT / "examples" / example).nominal.base, config.load(folder / "design.toml")


def way(finger: Config) -> np.ndarray:
    """Places (n, 2) of the tip at the pressures of its way."""
    assert finger.curve is not None
    assert finger.curve.pressure_kPa is not None
    names = tuple(marker(1, axis).name for axis in "xz")
    places = tuple(Place(PRESSURE.name, each) for each in finger.curve.pressure_kPa)
    asked = changed(finger, {"camera.markers": 1})
    found = compute(Request.of("bending", asked, columns=names, places=places)).columns
    return np.stack([found[name] for name in names], axis=1)


def pressed(finger: Config) -> tuple[np.ndarray, np.ndarray, float]:
    """Places (n, 2), y and z, on the contact face, pressures (kPa) there, and their spread."""
    names = (PRESSURE.name, OBSTACLE[-1].name)
    place = (Place(OBSTACLE[0].name, FORCE_N),)
    found = compute(Request.of("bending", finger, columns=names, places=place)).columns
    highest = float(found[PRESSURE.name][0])
    step = {"max_pressure_kPa": highest, "step_kPa": highest}
    with TemporaryDirectory() as folder:
        run("bending", finger.changed(experiment=step), out=folder)
        mesh, _, fields = read_steps(list_steps(Path(folder) / "fields.pvd")[-1:])
    pressure = fields["contact"][0]
    near = (pressure > 0) & (mesh.points[:, 0] < 3)
    return mesh.points[near][:, 1:], pressure[near], float(found[OBSTACLE[-1].name][0])


def draw(path: Path, wrap: Path) -> None:
    """Draw both."""
    with theme.figure_theme():
        figure, panels = plt.subplots(1, 3, figsize=(9.5, 3.6), layout="constrained")
        start, design = ends("path_design.toml", path)
        assert design.curve is not None
        axes = panels[0]
        axes.plot(design.curve.x_mm, design.curve.z_mm, "o", ms=12, mfc="none", color=theme.INK,
                  label="asked for")  # fmt: skip
        for finger, name, colour in ((start, "start", theme.PALE), (design, "design", theme.BLUE)):
            axes.plot(*way(finger).T, "o-", color=colour, label=name)
        axes.set(xlabel="x (mm)", ylabel="z (mm)", title="The tip at three pressures")
        axes.invert_yaxis()
        axes.legend()
        found = [pressed(each) for each in ends("wrap_design.toml", wrap)]
        top = max(pressure.max() for _, pressure, _ in found)
        for (places, pressure, spread), name, axes in zip(
            found, ("start", "design"), panels[1:], strict=True
        ):
            for side in (1, -1):
                drawn = axes.scatter(side * places[:, 0], places[:, 1], c=pressure, vmin=0,
                                     vmax=top, cmap="viridis", s=60)  # fmt: skip
            title = f"{name}: standard deviation {spread:.2f} of the mean"
            axes.set(xlabel="y (mm)", ylabel="z (mm)", title=title, xlim=(-10, 10), ylim=(62, 38))
        figure.colorbar(drawn, ax=panels[1:], label=CONTACT.label)
        figure.savefig(PICTURE, dpi=150)


if __name__ == "__main__":
    given = [Path(each) for each in sys.argv[1:]] or [
        Path("out/path_design"),
        Path("out/wrap_design"),
    ]
    draw(*given)
    print(f"wrote {PICTURE}")
