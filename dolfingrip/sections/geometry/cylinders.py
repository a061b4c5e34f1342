"""Solids made of cylinders along z between blocks: what round bellows are meshed from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from dolfingrip.sections.geometry.boxes import Box, Interval


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder along z with its axis in the plane y = 0.

    Attributes:
        axis_mm: place x of the axis.
        radius_mm: radius.
        along_mm: extent along z.
    """

    axis_mm: float
    radius_mm: float
    along_mm: Interval


@dataclass(frozen=True, slots=True)
class CylinderSolid:
    """Blocks and cylinders, less the hollows inside.

    Attributes:
        blocks, cylinders: the solid, which overlap as they like.
        cavities: for each cavity its cylinders, which overlap as they like.
    """

    blocks: Sequence[Box]
    cylinders: Sequence[Cylinder]
    cavities: Sequence[Sequence[Cylinder]]
