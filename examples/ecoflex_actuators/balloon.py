"""Draws c5-w7 as it balloons: ``measured_actuators_balloon.png``.

    scripts/run python examples/ecoflex_actuators/balloon.py PICTURE.png [FOLDER]

FOLDER holds a simulation, as ``dolfingrip bend --config c5-w7.toml --out FOLDER`` writes it; it is
made in ``out/`` where none is given.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.experiments import run
from dolfingrip.report.render import draw

HERE = Path(__file__).resolve().parent
OUT = Path("out") / "ecoflex_actuators" / "c5-w7"

ANGLES_DEG = (3.0, 11.0, 40.0, 64.0)
"""Chord angles of the readings that are drawn."""


def main() -> None:
    """Simulate where needed, and draw."""
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else OUT
    if not (folder / "result.csv").exists():
        run("bending", configuration.load(HERE / "c5-w7.toml"), out=folder)
    rows = pd.read_csv(folder / "result.csv")
    places = [(rows["chord_angle_deg"] - angle).abs().idxmin() for angle in ANGLES_DEG]
    pressures = [float(rows["pressure_kPa"][place]) for place in places]
    pictures = draw(
        folder / "fields.pvd", pressures, colour_by="stretch", shown="half", height_in=3.0
    )
    pictures.save_strip(Path(sys.argv[1]))


if __name__ == "__main__":
    main()
