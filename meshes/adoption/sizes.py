"""The size of a part's elements, from its walls."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.meshes.adoption.roles import Roles
from dolfingrip.meshes.adoption.sound import SizePolicy, Thinnest, place, thinnest
from dolfingrip.meshes.groups import SKIN
from dolfingrip.meshes.solid import MeshError


@dataclass(frozen=True, slots=True)
class MeshRequest:
    """Size and order of elements that are asked for.

    Attributes:
        size_mm: size of elements; from the walls where None.
        order: order of the elements; 2 where None and a face is curved, else 1.
        cap_mm: thickness of a cap; from the walls where None.
        tell: is told of the mesh before it is made.
        policy: how sizes follow from walls.
    """

    size_mm: float | None = None
    order: int | None = None
    cap_mm: float | None = None
    tell: Callable[[str], None] | None = None
    policy: SizePolicy = field(default_factory=SizePolicy)


@dataclass(frozen=True, slots=True)
class WallSizes:
    """Walls and gaps of a part, and what follows from them.

    Attributes:
        wall: the thinnest wall.
        gap: the narrowest gap between outer sides.
        size_mm: size of elements.
        cap_mm: thickness of a cap.
        reach_mm: how far a cap reaches into the wall around it.
    """

    wall: Thinnest
    gap: Thinnest
    size_mm: float
    cap_mm: float
    reach_mm: float


def measured(roles: Roles, wanted: MeshRequest) -> WallSizes:
    """Measure walls and gaps, and find the size of elements.

    Args:
        roles: part with its faces' roles, in mm.
        wanted: size and order of elements that are asked for.

    Returns:
        Walls, gaps and the size of elements (mm).

    Raises:
        MeshError: one line, if a wall is too thin for its mesh.
    """
    surface, policy = roles.surface, wanted.policy
    wall = thinnest(surface, policy)
    gap = thinnest(surface, policy, outside=True, among=roles.groups == SKIN)
    at = place(roles.rotation.T @ wall.at_mm + roles.origin_mm)
    volume = surface.volumes.sum() / (2 if roles.half else 1)

    def number(size_mm: float) -> float:
        return float(volume / (policy.filled * size_mm**3))

    most = float(f"{policy.most_by_wall * wall.mm:.3g}")  # as a refusal tells it
    if wanted.size_mm is not None:
        size = wanted.size_mm
        if size > most:
            raise MeshError(
                f"--size-mm {size:g}: too large for a wall of {wall.mm:.3g} mm at {at}; "
                f"allowed: above 0 and up to {most:g} mm"
            )
    else:
        width = np.ptp(surface.points[surface.triangles].reshape(-1, 3), axis=0)[:2].min()
        size = min(policy.by_wall * wall.mm, width / policy.across)
        if number(size) > policy.most:
            size = min(most, width / policy.across)
        if number(size) > policy.most:
            raise MeshError(
                f"a wall of {wall.mm:.3g} mm at {at} is too thin for its mesh, which would have "
                f"{number(size):.1e} elements; allowed: up to {policy.most:.0e}, "
                "or --size-mm with as many as you like"
            )
    if wanted.tell is not None:
        wanted.tell(
            f"about {round(number(size), -2):,.0f} tetrahedra of {size:.3g} mm, as the thinnest "
            f"wall has {wall.mm:.3g} mm, at {at}"
        )
    cap = policy.cap_walls * wall.mm if wanted.cap_mm is None else wanted.cap_mm
    return WallSizes(wall, gap, size, cap, policy.into_wall * wall.mm)
