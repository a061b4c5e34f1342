"""Element sizes for a wanted number of elements."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from dolfingrip.meshes.solid import MeshError


@dataclass(frozen=True, slots=True)
class TargetPolicy:
    """How a size for a wanted number of elements is sought.

    Attributes:
        tolerance: largest relative difference from the target.
        tries: meshes, and bisections, at most.
        slopes: range of d log(count) / d log(size): -2 in a thin wall, -3 in a thick solid.
        largest_step: longest step of log(size).
        close: bracket of log(size) below which the position of the change of size is bisected
            instead.
    """

    tolerance: float = 0.01
    tries: int = 20
    slopes: tuple[float, float] = (-3.5, -1.0)
    largest_step: float = 1.5
    close: float = 0.02


POLICY: Final = TargetPolicy()


def meet(target: int, mesh: Callable[[float, float, float], int]) -> None:
    """Mesh until the number of elements is within 1 % of the target.

    The bellows are alike, so the count jumps by more than 1 % if the number of elements on an edge
    changes in all of them at once. The search therefore has two stages. The first is a secant
    method in log(size) and log(count), between the nearest sizes that gave too many and too few
    elements. The second takes these two sizes and bisects the place along the finger where the
    smaller one ends and the larger one begins.

    Args:
        target: wanted number of elements.
        mesh: makes a mesh with sizes scaled by its first argument up to a part of the length, its
            third argument, and by its second argument beyond; returns the number of elements.

    Raises:
        MeshError: if the target is missed.
    """
    tried: list[int] = []

    def miss(near: float, far: float, share: float) -> float:
        tried.append(mesh(math.exp(near), math.exp(far), share))
        return math.log(tried[-1] / target)

    def met() -> bool:
        return abs(tried[-1] - target) <= POLICY.tolerance * target

    found = _bracket(miss)
    if found is not None:
        fine, coarse = found
        low, high = 0.0, 1.0
        for _ in range(POLICY.tries):
            if met():
                return
            share = (low + high) / 2
            if miss(fine, coarse, share) < 0:
                low = share
            else:
                high = share
    if not met():
        nearest = min(tried, key=lambda count: abs(count - target))
        raise MeshError(
            f"mesh.target_elements = {target}: cannot be met within {POLICY.tolerance:.0%} "
            f"with these dimensions and sizes; nearest allowed: {nearest}"
        )


def _bracket(miss: Callable[[float, float, float], float]) -> tuple[float, float] | None:
    """Close log scales with too many and too few elements; None if met or not found."""
    within = math.log1p(POLICY.tolerance) * 0.99
    fine = coarse = None
    scale, slope = 0.0, -2.1  # walls thinner than the elements
    value = miss(scale, scale, 1.0)
    for _ in range(POLICY.tries):
        if abs(value) <= within:
            return None
        if value > 0:
            fine = scale
        else:
            coarse = scale
        step = min(max(-value / slope, -POLICY.largest_step), POLICY.largest_step)
        new = scale + step
        if fine is not None and coarse is not None:
            if abs(coarse - fine) <= POLICY.close:
                return fine, coarse
            # a secant that hardly moves an end is no better than this end
            if not fine + within / 4 <= new <= coarse - within / 4:
                new = (fine + coarse) / 2
        before, scale = (scale, value), new
        value = miss(scale, scale, 1.0)
        slope = (value - before[1]) / (scale - before[0])
        slope = min(max(slope, POLICY.slopes[0]), POLICY.slopes[1])
    return None
