"""The connector through which air enters a cavity: a bore, and a tube or barbs around it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import gmsh
import numpy as np

from dolfingrip.meshes.gmsh_model import Solids, fused, less
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, BoxSolid, CylinderSolid, Interval
from dolfingrip.sections.making import Inlet

BARBS: Final = 3
"""Barbs along a connector, which take this part of its length:"""
BARBED: Final = 0.75


@dataclass(frozen=True, slots=True)
class _End:
    """The end of a cavity at the clamp.

    Attributes:
        x_mm: extent along x.
        width_mm: extent along y, about the symmetry plane.
        z_mm: where the cavity begins.
        reaches_mm: where it ends.
    """

    x_mm: Interval
    width_mm: float
    z_mm: float
    reaches_mm: float


def _ends(shape: BoxSolid | CylinderSolid) -> list[_End]:
    """The end of each cavity at the clamp, where it is widest."""
    if isinstance(shape, CylinderSolid):
        first = [min(parts, key=lambda part: part.along_mm[0]) for parts in shape.cavities]
        half = [cylinder.radius_mm / 2**0.5 for cylinder in first]  # of the square in the circle
        return [
            _End((c.axis_mm - h, c.axis_mm + h), 2 * h, *c.along_mm)
            for c, h in zip(first, half, strict=True)
        ]
    start = min(z[0] for _, _, z in shape.cavity)
    widest = [box for box in shape.cavity if box[2][0] < start + TOLERANCE_MM]
    x, y, z = max(widest, key=lambda box: (box[0][1] - box[0][0]) * (box[1][1] - box[1][0]))
    return [_End(x, y[1] - y[0], *z)]


def with_inlets(body: Solids, shape: BoxSolid | CylinderSolid, inlet: Inlet) -> Solids:
    """Add a connector to each cavity of a finger in the current Gmsh model.

    Args:
        body: the whole finger, which is used up.
        shape: what it is made of; no cavity is open at the clamp.
        inlet: place, bore and connector.

    Raises:
        ConfigError: one line, if the bore would miss the cavity or cut into its walls.
    """
    if isinstance(shape, BoxSolid):
        side_mm = shape.body[1][1]
    else:
        side_mm = max(y[1] for _, y, _ in shape.blocks)
    for end in _ends(shape):
        x, z = _axis(end, inlet)
        if inlet.place == "clamp":
            base, outward, path = np.array([x, 0.0, 0.0]), np.array([0.0, 0.0, -1.0]), []
        else:
            base, outward = np.array([x, side_mm, z]), np.array([0.0, 1.0, 0.0])
            path = [np.array([x, 0.0, z])]
        into = end.z_mm + min(inlet.bore_mm, end.reaches_mm - end.z_mm) / 2
        path = [base + inlet.length_mm * outward, *path, np.array([x, 0.0, into])]
        body = less(fused(body, _connector(base, outward, inlet)), _bore(path, inlet.bore_mm / 2))
    return body


def _axis(end: _End, inlet: Inlet) -> tuple[float, float]:
    """Place x of a bore's axis, and z of its part in a side."""
    widest = min(end.x_mm[1] - end.x_mm[0], end.width_mm)
    if inlet.bore_mm > widest:
        raise ConfigError(
            f"inlet.bore_mm = {inlet.bore_mm:g}: wider than the cavity at the clamp; allowed: "
            f"above 0 and up to {widest:.4g} mm"
        )
    x = sum(end.x_mm) / 2 if inlet.x_mm is None else inlet.x_mm
    low, high = end.x_mm[0] + inlet.bore_mm / 2, end.x_mm[1] - inlet.bore_mm / 2
    if not low - TOLERANCE_MM <= x <= high + TOLERANCE_MM:
        raise ConfigError(
            f"inlet.x_mm = {x:g}: beside the cavity; allowed: {low:.4g} to {high:.4g} mm"
        )
    z = end.z_mm / 2 if inlet.z_mm is None else inlet.z_mm
    least = inlet.bore_mm / 2 + inlet.wall_mm + (inlet.barb_mm if inlet.kind == "barb" else 0.0)
    if inlet.place == "side" and not least <= z <= end.z_mm - inlet.bore_mm / 2:
        key = "bore_mm" if inlet.z_mm is None else "z_mm"
        value = getattr(inlet, key)
        raise ConfigError(
            f"inlet.{key} = {value:g}: the connector does not fit between clamp and cavity there, "
            f"{end.z_mm:.4g} mm; allowed: a bore with its axis between {least:.4g} mm and "
            f"{end.z_mm - inlet.bore_mm / 2:.4g} mm from the clamp"
        )
    return x, z


def _connector(base: np.ndarray, outward: np.ndarray, inlet: Inlet) -> Solids:
    """A tube on a face, with barbs that become thinner outwards."""
    radius = inlet.bore_mm / 2 + inlet.wall_mm
    made = [(3, gmsh.model.occ.addCylinder(*base, *(inlet.length_mm * outward), radius))]
    if inlet.kind == "barb":
        pitch = BARBED * inlet.length_mm / BARBS
        for number in range(BARBS):
            start = base + (inlet.length_mm - (number + 1) * pitch) * outward
            wide = radius + inlet.barb_mm
            made.append((3, gmsh.model.occ.addCone(*start, *(pitch * outward), wide, radius)))
    return made


def _bore(path: list[np.ndarray], radius: float) -> Solids:
    """A round hollow along straight lines, with a ball at each corner."""
    made = [
        (3, gmsh.model.occ.addCylinder(*start, *(stop - start), radius))
        for start, stop in pairwise(path)
    ]
    return made + [(3, gmsh.model.occ.addSphere(*corner, radius)) for corner in path[1:-1]]
