"""A fibre-reinforced finger: a half-round tube, a thread wound both ways, a sheet on the flat back.

``half_round_finger.step`` is a half cylinder of radius R = 10 mm on a base of b = 3 mm, with a
hollow of radius a = 7.5 mm that is 60 mm long. Threads at ±85° to the axis keep the section's
outline, a sheet on the back keeps its length, so the finger can only bend about the sheet:
what lies at the height h above it is stretched by λ = 1 + κh.

Two balances with the pressure are closed forms in the curvature κ. The silicone is of Neo-Hooke's
law, incompressible, and keeps its width:

    p S = ∫ μ (λ − λ⁻³) h dA over the wall.

S is the first moment about the sheet of the area that the pressure acts on. It acts on the chamber,
∫ h dA over the hollow. But it also presses the wall against the threads, and as the wall keeps its
volume, it works on all that the threads enclose, ∫ h dA over hollow and wall. The first balance
leaves that out. The second one leaves out that the flat base bulges and the wall is widened. The
finger bends more than by the first one, and less than by the second one.

Fingers of this kind are those of Polygerinos et al., Modeling of soft fiber-reinforced bending
actuators, IEEE Trans. Robot. 31, 2015. The silicone is Elastosil M4601 with C10 = 0.12 MPa, as the
Soft Robotics Toolkit has it in its finite-element tutorial of fibre-reinforced actuators
(softroboticstoolkit.com/book/fr-modeling).

    scripts/run python examples/fibre_reinforced_finger.py
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from dolfingrip import config
from dolfingrip.config import NO_CHANGE, Change
from dolfingrip.experiments import run
from dolfingrip.meshes import files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest

PART = Path(__file__).with_name("half_round_finger.step")
R_MM, A_MM, B_MM, CHAMBER_MM = 10.0, 7.5, 3.0, 60.0
MU_MPA = 2 * 0.12
REINFORCED = {
    "material.mu_MPa": MU_MPA,
    "material.nu": 0.499,
    "solver.element": "P2-P1",
    "film.sheet.Et_N_per_mm": 1000,
    "film.thread.group": "skin",
    "film.thread.Et_N_per_mm": 0,
    "film.thread.fibre_Et_N_per_mm": [300, 300],
    "film.thread.fibre_deg": [85, -85],
}


class Found(NamedTuple):
    """Angles of the tip at the highest pressure.

    Attributes:
        angle_deg: by finite elements.
        of_chamber_deg: by the balance with the pressure on the chamber.
        of_outline_deg: by that on all that the threads enclose.
    """

    angle_deg: float
    of_chamber_deg: float
    of_outline_deg: float


def closed_forms_deg(pressure_kPa: float) -> tuple[float, float]:
    """The angles of both balances, with the pressure on the chamber and on the whole outline."""
    h, step = np.linspace(0, R_MM + B_MM, 4001, retstep=True)
    above = np.maximum(h - B_MM, 0)

    def width(radius_mm: float) -> np.ndarray:
        return 2 * np.sqrt(np.maximum(radius_mm**2 - above**2, 0))

    outline = width(R_MM)
    hollow = np.where(h > B_MM, width(A_MM), 0)
    wall = outline - hollow

    def angle(area: np.ndarray) -> float:
        work = pressure_kPa * 1e-3 * (area * h).sum() * step

        def off(curvature: float) -> float:
            stretch = 1 + curvature * h
            moment = MU_MPA * (wall * (stretch - stretch**-3.0) * h).sum() * step
            return float(moment - work)

        return math.degrees(float(brentq(off, 0, 1)) * CHAMBER_MM)

    return angle(hollow), angle(outline)


def main(
    out: Path, overrides: Change = NO_CHANGE, pressure_kPa: float = 20.0, size_mm: float = 4.0
) -> Found:
    """Adopt the part, wind it, and bend it.

    Args:
        out: folder of the mesh.
        overrides: of the configuration.
        pressure_kPa: highest pressure.
        size_mm: of the elements.
    """
    out.mkdir(parents=True, exist_ok=True)
    part = adopt(PART, Asked(), MeshRequest(size_mm=size_mm, order=2))
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
            "contact.self_contact": False,
            "experiment.max_pressure_kPa": pressure_kPa,
            "experiment.step_kPa": pressure_kPa / 2,
            **REINFORCED,
            **overrides,
        }
    )
    result = run("bending", finger, out=out / "bend")
    return Found(float(result.column("angle_deg")[-1]), *closed_forms_deg(pressure_kPa))


if __name__ == "__main__":
    found = main(Path("out/fibre_reinforced_finger"))
    print(f"the tip turns by {found.angle_deg:.1f}° at 20 kPa")
    print(f"closed forms: {found.of_chamber_deg:.1f}° and {found.of_outline_deg:.1f}°")
