"""The triangle of a surface that is nearest to a point."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from vtkmodules.vtkCommonCore import mutable
from vtkmodules.vtkCommonDataModel import vtkStaticCellLocator

from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.solid import Floats, Ints


def locator(points: Floats, triangles: Ints) -> Any:
    """VTK's search tree of triangles."""
    found: Any = vtkStaticCellLocator()  # its hints lack the references that it fills
    found.SetDataSet(ClosedSurface(points, triangles).polydata())
    found.BuildLocator()
    return found


def nearest(points: Floats, triangles: Ints, at: Floats) -> tuple[Ints, Floats]:
    """(k,) rows of the triangles that are nearest to (k, 3) points, and (k,) distances (mm)."""
    tree = locator(points, triangles)
    close = np.zeros(3)
    cell: Any
    sub: Any
    far: Any
    cell, sub, far = mutable(0), mutable(0), mutable(0.0)
    found, away = np.empty(len(at), dtype=np.int64), np.empty(len(at))
    for i, point in enumerate(np.asarray(at, dtype=float)):
        tree.FindClosestPoint(point, close, cell, sub, far)
        found[i], away[i] = int(cell), math.sqrt(float(far))
    return found, away
