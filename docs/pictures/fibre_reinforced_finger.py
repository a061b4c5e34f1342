"""The fibre-reinforced finger of the examples at rest and at 20 kPa, cut open.

    scripts/run python examples/fibre_reinforced_finger.py
    scripts/run python docs/pictures/fibre_reinforced_finger.py

draws ``docs/fibre_reinforced_finger.png``.
"""

from __future__ import annotations

from pathlib import Path

from dolfingrip.report.render import draw

PICTURE = Path(__file__).resolve().parents[1] / "fibre_reinforced_finger.png"

if __name__ == "__main__":
    fields = Path("out/fibre_reinforced_finger/bend/fields.pvd")
    draw(fields, [0, 20], colour_by="stretch", shown="half", height_in=3.0).save_strip(PICTURE)
