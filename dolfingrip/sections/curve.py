"""Section of the configuration for a curve that the finger's back or its tip shall follow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from dolfingrip.sections.section import Numbers, Refusal, Role, Section


class Polyline:
    """Straight pieces between points of a plane.

    Args:
        points: (n, 2) mm, two or more, neighbours apart.
    """

    def __init__(self, points: np.ndarray) -> None:
        self.points = np.asarray(points, dtype=float)
        self._steps = np.diff(self.points, axis=0)
        self._lengths = np.linalg.norm(self._steps, axis=1)
        self._along = np.concatenate([[0.0], np.cumsum(self._lengths)])

    @property
    def length_mm(self) -> float:
        """Length of all pieces."""
        return float(self._along[-1])

    def at(self, shares: np.ndarray) -> np.ndarray:
        """Points (k, 2) at parts (k,) of the length, from 0 to 1."""
        places = shares * self.length_mm
        return np.stack([np.interp(places, self._along, each) for each in self.points.T], axis=1)

    def rates(self, shares: np.ndarray) -> np.ndarray:
        """Change (k, 2) of points with their parts of the length (mm)."""
        piece = np.searchsorted(self._along, shares * self.length_mm, "right") - 1
        piece = np.clip(piece, 0, len(self._steps) - 1)
        return np.asarray(self.length_mm * self._steps[piece] / self._lengths[piece, None])

    def nearest(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The nearest point (k, 2) to each of some points (k, 2), and its change with it (k, 2, 2).

        It moves along its piece, and stays at a corner or an end.
        """
        away = points[:, None] - self.points[:-1]
        share = np.clip(np.einsum("kpi,pi->kp", away, self._steps) / self._lengths**2, 0.0, 1.0)
        feet = self.points[:-1] + share[..., None] * self._steps
        best = np.linalg.norm(points[:, None] - feet, axis=2).argmin(axis=1)
        rows = np.arange(len(points))
        inside = (share[rows, best] > 0) & (share[rows, best] < 1)
        along = self._steps[best] / self._lengths[best, None] * inside[:, None]
        return feet[rows, best], along[:, :, None] * along[:, None]

    def crossing(self) -> np.ndarray | None:
        """A point (2,) where two pieces meet that do not follow each other, or where one goes back.

        None if there is none.
        """
        start, step = self.points[:-1], self._steps
        back = (_cross(step[:-1], step[1:]) == 0) & ((step[:-1] * step[1:]).sum(axis=1) < 0)
        if back.any():
            return np.asarray(start[1:][back][0])
        i, j = np.triu_indices(len(step), 2)
        apart = start[j] - start[i]
        across = _cross(step[i], step[j])
        with np.errstate(divide="ignore", invalid="ignore"):
            on_i, on_j = _cross(apart, step[j]) / across, _cross(apart, step[i]) / across
            meet = (on_i >= 0) & (on_i <= 1) & (on_j >= 0) & (on_j <= 1)
        found = np.flatnonzero(meet)
        return start[i[found[0]]] + on_i[found[0]] * step[i[found[0]]] if len(found) else None


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


class CurveTarget(Section):
    """A curve in the plane of bending, from the clamp; the back's middle line is compared with it.

    The finger's back begins at x = z = 0, goes along z and bends towards −x. With pressures it is
    the way of the back's tip, which is compared with the place at the present pressure.
    """

    role: ClassVar = Role.INSTRUMENT
    felt_by: ClassVar = ("finger",)
    later: ClassVar = {"pressure_kPa": None}

    x_mm: Numbers = Field(description="of its points, from the clamp on")
    z_mm: Numbers = Field(description="of its points")
    ends: Literal["free", "fixed"] = Field(
        "free",
        description="free: each place of the line counts by the nearest point of the curve; fixed: "
        "by the point at the same part of the deformed length, so that both ends meet",
    )
    pressure_kPa: Numbers | None = Field(
        None, description="rising, one for each point: the tip's way; places between are linear"
    )
    places: int = Field(60, ge=2, le=1000, description="number of places of the line that count")

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if len(self.x_mm) < 2:
            yield Refusal("x_mm", "allowed: two points or more", f"{len(self.x_mm)} numbers")
        for key in ("z_mm", "pressure_kPa"):
            given = getattr(self, key)
            if given is not None and len(given) != len(self.x_mm):
                words = f"allowed: as many as x_mm has, {len(self.x_mm)}"
                yield Refusal(key, words, f"{len(given)} numbers")
        if self.pressure_kPa is not None:
            if not (np.diff(self.pressure_kPa) > 0).all():
                yield Refusal("pressure_kPa", "allowed: rising", list(self.pressure_kPa))
            return
        if not np.hypot(np.diff(self.x_mm), np.diff(self.z_mm)).all():
            yield Refusal(
                "x_mm", "allowed: neighbouring points that differ", "the same point twice"
            )
