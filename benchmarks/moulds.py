"""The moulds of the shipped cast examples: closed, thick enough, and full with the part in them.

    scripts/run python -m benchmarks.moulds

writes ``benchmarks/moulds.csv``: for each example the thinnest wall of its mould's parts, by how
much the parts and the silicone differ from the box that they fill, and how many of 4,000 random
points of that box lie in more than one part. Clearance is 0 here, so that the box is filled.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from dolfingrip import config
from dolfingrip.config import Config
from dolfingrip.files import table
from dolfingrip.meshes import closed_surface
from dolfingrip.report import printable
from dolfingrip.sections.geometry.boxes import BoxSolid
from dolfingrip.sections.tables import assignments

EXAMPLES = Path(__file__).parents[1] / "examples"
ACTUATOR = "ecoflex_actuators/c5-w7.toml"
CAST = (
    ("cast_block.toml",),
    ("pneunet_mould.toml",),
    (ACTUATOR,),
    (ACTUATOR, "cast.chambers=7"),
    (ACTUATOR, "cast.wall_mm=10"),
    (ACTUATOR, "cast.cup_mm=5"),
)
"""Files with the settings that their own text gives for further specimens."""
POINTS, SEED = 4000, 48


def row(name: str, design: Config) -> dict[str, object]:
    """Make one mould and check it."""
    shape = design.geometry.solid()
    assert isinstance(shape, BoxSolid)
    with TemporaryDirectory() as folder:
        made = printable.write_mould(design, Path(folder))
        parts = {file.stem: closed_surface.read(file) for file in made.parts}
    wall = design.mould.thickness_mm
    floor = min(x[0] for x, _, _ in shape.cavity)
    high, wide, long = (end for _, end in shape.body)
    low = np.array([floor, -wide - wall, -wall])
    top = np.array([high, wide + wall, long + wall])
    block = float(np.prod(top - low))
    outer = (2 * wide + 4 * wall) * (long + 4 * wall)
    plate_and_rim = outer * wall + (outer - block / (high - floor)) * 2 * wall
    around = [each for each in parts if each != "base_tray"]
    together = sum(parts[each].volume_mm3 for each in around) + made.body_mm3
    tray = (2 * wide + 2 * wall) * (long + 2 * wall) * (floor + wall)
    base = parts["base_tray"].volume_mm3 + made.base_mm3
    places = np.random.default_rng(SEED).uniform(low, top, (POINTS, 3))
    within = np.array([parts[each].distances_mm(places) < 0 for each in around]).sum(axis=0)
    return {
        "example": name,
        "least_wall_mm": f"{min(each.wall.mm for each in made.parts.values() if each.wall):.2f}",
        "voids": sum(each.voids for each in made.parts.values()),
        "box_error": f"{abs(together / (block + plate_and_rim) - 1):.1e}",
        "tray_error": f"{abs(base / tray - 1):.1e}",
        "in_two_parts": int((within > 1).sum()),
        "silicone_cm3": f"{(made.body_mm3 + made.base_mm3) / 1000:.2f}",
    }


def main() -> None:
    """Check the moulds of all examples and write the table."""
    rows = []
    for file, *texts in CAST:
        changes = {"mould.clearance_mm": 0.0, **assignments(texts)}
        rows.append(row(" ".join([file, *texts]), config.load(EXAMPLES / file, changes)))
        print(rows[-1], flush=True)
    table.write(Path(__file__).with_suffix(".csv"), rows)


if __name__ == "__main__":
    main()
