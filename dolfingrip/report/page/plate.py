"""The force sensor of a run, as it stands in a scene."""

from __future__ import annotations

from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation

from dolfingrip.report.page.finger import Fields, block
from dolfingrip.report.page.runs import Run
from dolfingrip.report.page.scene import Part

THICK_MM: Final = 3.0
AROUND_MM: Final = 3.0


def plate(run: Run, fields: Fields) -> Part:
    """Return a slab whose face is the gap of the first reading away from the finger's tip.

    Args:
        run: with the gap.
        fields: of the finger.
    """
    config = run.result.config.plate
    turn = Rotation.from_euler("y", config.tilt_deg, degrees=True)
    normal = turn.apply(np.asarray(config.normal, dtype=float))
    normal /= np.linalg.norm(normal)
    rest = fields.mesh.points
    low, high = rest.min(axis=0), rest.max(axis=0)
    near = (
        rest[rest[:, 2] > high[2] - config.contact_length_mm]
        + fields.displacements[0][rest[:, 2] > high[2] - config.contact_length_mm]
    )
    gaps = run.column("plate_gap_mm")
    gap = float(gaps[0]) if gaps is not None else config.gap_mm
    place = float((near @ normal).min()) - gap
    tip = np.array([low[0], 0.0, high[2]])
    centre = tip - (tip @ normal - place) * normal
    across = np.array([0.0, 1.0, 0.0])
    if abs(normal[1]) > 0.9:
        across = np.array([0.0, 0.0, 1.0])
    along = np.cross(normal, across)
    along /= np.linalg.norm(along)
    across = np.cross(along, normal)
    wide = float(np.abs([low[1], high[1]]).max()) + AROUND_MM
    length = config.contact_length_mm
    corner = np.array([THICK_MM, wide, length])
    axes = np.array([normal, across, along])
    return block("force sensor", -corner, corner * [0, 1, 1], axes, centre)
