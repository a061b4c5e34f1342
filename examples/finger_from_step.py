"""A finger from a CAD file: a half-round tube of silicone with paper on its flat side.

``half_round_finger.step`` was drawn in a CAD kernel: a half cylinder of radius 10 mm on a base of 3
mm, 70 mm long, with a hollow of radius 7.5 mm and a tube of 3 mm that leads out of the clamped end.
The package finds out what is cavity, clamp and tip. The cavity's volume is known in closed form,

    V = π/2 (7.5 mm)² 60 mm + π (1.5 mm)² 5 mm = 5337 mm³,

which the mesh has to have. A uniform tube would only stretch. The paper, a membrane of stiffness
Et = 100 N/mm on the back, does not, and so the tube bends towards it.

    scripts/run python examples/finger_from_step.py
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import run
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest

PART = Path(__file__).with_name("half_round_finger.step")
CAVITY_mm3 = math.pi / 2 * 7.5**2 * 60 + math.pi * 1.5**2 * 5
SILICONE = {"material.mu_MPa": 0.15, "film.paper.Et_N_per_mm": 100}


class Found(NamedTuple):
    """Results of the example.

    Attributes:
        cavity_mm3: volume of the meshed cavity, both halves.
        angle_deg: of the tip at the highest pressure.
    """

    cavity_mm3: float
    angle_deg: float


def main(out: Path, overrides: Change = NO_CHANGE, size_mm: float = 4.0, order: int = 2) -> Found:
    """Adopt the part, write its mesh, and bend it.

    Args:
        out: folder of the mesh.
        overrides: of the configuration.
        size_mm, order: of the elements.
    """
    out.mkdir(parents=True, exist_ok=True)
    part = adopt(PART, Asked(), MeshRequest(size_mm=size_mm, order=order))
    files.write(out / "finger.msh", part.mesh)
    depth, width, length = part.size_mm
    finger = config.load(
        overrides={
            "finger.kind": "adopted",
            "mesh.file": str(out / "finger.msh"),
            "adopted.length_mm": length,
            "adopted.width_mm": width,
            "adopted.depth_mm": depth,
            "adopted.wall_mm": part.measured.wall.mm,
            "morph.d_mm": depth / 2,
            "plate.contact_length_mm": 10,
            "contact.self_contact": False,
            "experiment.max_pressure_kPa": 30,
            **SILICONE,
            **overrides,
        }
    )
    copies = 2 if part.roles.half else 1
    result = run("bending", finger)
    return Found(copies * part.quality.cavity_mm3, float(result.column("angle_deg")[-1]))


if __name__ == "__main__":
    found = main(Path("out/finger_from_step"))
    print(f"cavity {found.cavity_mm3:.0f} mm³, in closed form {CAVITY_mm3:.0f} mm³")
    print(f"the tip turns by {found.angle_deg:.1f}° at 30 kPa")
