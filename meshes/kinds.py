"""The kinds of geometry that are made from dimensions: each as a solid of boxes."""

from __future__ import annotations

from dolfingrip.meshes import cast, finger, pneunet
from dolfingrip.meshes.boxes import BoxSolid
from dolfingrip.sections.cast import Cast
from dolfingrip.sections.pneunet import Pneunet
from dolfingrip.sections.specimen import Finger

Dimensions = Finger | Cast | Pneunet
"""A table of dimensions."""


def box_solid(dimensions: Dimensions) -> BoxSolid:
    """The solid of these dimensions."""
    if isinstance(dimensions, Cast):
        return cast.box_solid(dimensions)
    if isinstance(dimensions, Pneunet):
        return pneunet.box_solid(dimensions)
    return finger.box_solid(dimensions)


def refuse_slivers(dimensions: Dimensions) -> None:
    """Refuse dimensions that leave next to nothing between two faces.

    Raises:
        MeshError: one line.
    """
    if isinstance(dimensions, Finger):
        finger.refuse_slivers(dimensions)
    else:
        box_solid(dimensions).refuse_slivers(type(dimensions).__name__.lower())
