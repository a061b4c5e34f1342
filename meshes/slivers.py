"""Refuses dimensions that leave almost nothing between two faces."""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import MeshError
from dolfingrip.sections.geometry.boxes import THINNEST_MM, TOLERANCE_MM, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry


def refuse_slivers(geometry: Geometry) -> None:
    """Refuse dimensions that leave faces closer than :data:`THINNEST_MM`.

    Raises:
        MeshError: one line naming the dimension, or where the faces are.
    """
    distances = geometry.distances_mm()
    for key, distance in distances.items():
        if distance < THINNEST_MM:
            raise MeshError(
                f"{geometry.table()}.{key} = {getattr(geometry, key)}: leaves {distance:.3g} mm "
                f"between two faces; allowed: at least {THINNEST_MM} mm"
            )
    solid = geometry.alike().solid()
    if not distances and isinstance(solid, BoxSolid):
        _refuse_near_planes(solid, geometry.table())


def _refuse_near_planes(solid: BoxSolid, table: str) -> None:
    for axis, letter in enumerate("xyz"):
        planes = np.unique(solid.planes(axis))
        apart = np.diff(planes)
        near = (apart > TOLERANCE_MM) & (apart < THINNEST_MM * (1 - 1e-9))
        if near.any():
            at = int(near.argmax())
            raise MeshError(
                f"{table}: leaves {apart[at]:.3g} mm between two faces at {letter} = "
                f"{planes[at]:.4g} mm; allowed: at least {THINNEST_MM} mm"
            )
