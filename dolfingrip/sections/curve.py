"""Section of the configuration for a curve that the finger's back or its tip shall follow."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from dolfingrip.sections.section import Numbers, Refusal, Role, Section


class Polyline:
    """Straight pieces between points of a plane.

    Args:
        points: (n, 2) mm, neighbours apart; one alone is a place.
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

    @property
    def shares(self) -> np.ndarray:
        """Parts (n,) of the length at which its points are, from 0 to 1."""
        return self._along / (self.length_mm or 1.0)

    def between(self, other: Polyline, share: float) -> Polyline:
        """The line at a part of the way to another: each place goes to that at its part of length.

        Args:
            other: where all of the way leads to.
            share: of the way, 0 to 1.
        """
        shares = np.union1d(self.shares, other.shares)
        return Polyline((1 - share) * self.at(shares) + share * other.at(shares))

    def at(self, shares: np.ndarray) -> np.ndarray:
        """Points (k, 2) at parts (k,) of the length, from 0 to 1."""
        places = shares * self.length_mm
        return np.stack([np.interp(places, self._along, coord) for coord in self.points.T], axis=1)

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
        hits = np.flatnonzero(meet)
        return start[i[hits[0]]] + on_i[hits[0]] * step[i[hits[0]]] if len(hits) else None


def _cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    return np.asarray(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])


class CurveTarget(Section):
    """A curve in the plane of bending, from the clamp; the back's middle line is compared with it.

    The finger's back begins at x = z = 0, goes along z and bends towards −x. Points of one pressure
    are the curve at that pressure. Where each point has a pressure of its own, they are the way of
    the back's tip, which is compared with the place at the present pressure.
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
        None,
        description="one for each point, not falling: several points of one pressure are the curve "
        "there, and points with a pressure each are the tip's way; linear between pressures",
    )
    places: int = Field(60, ge=2, le=1000, description="number of places of the line that count")

    @property
    def lines(self) -> list[np.ndarray]:
        """Points (k, 2) of the curve at each pressure, or of the tip's way."""
        points = np.stack([self.x_mm, self.z_mm], axis=1)
        return [points] if self.of_tip else np.split(points, self._cuts)

    @property
    def of_tip(self) -> bool:
        """True if it is the way of the tip."""
        return self.pressure_kPa is not None and len(self._cuts) == len(self.x_mm) - 1

    @property
    def _cuts(self) -> np.ndarray:
        """Numbers of the points at which a higher pressure begins."""
        return np.flatnonzero(np.diff(self.pressure_kPa or np.zeros(len(self.x_mm)))) + 1

    def targets(self) -> Callable[[float], Polyline]:
        """Return the function from a pressure (kPa) to the curve there, or to the tip's place."""
        points = np.stack([self.x_mm, self.z_mm], axis=1)
        lines = [Polyline(piece) for piece in np.split(points, self._cuts)]
        if self.pressure_kPa is None:
            return lambda pressure_kPa: lines[0]
        pressures = np.unique(self.pressure_kPa)

        def at(pressure_kPa: float) -> Polyline:
            place = float(np.interp(pressure_kPa, pressures, np.arange(len(lines))))
            first = min(int(place), len(lines) - 1)
            share = place - first
            return lines[first].between(lines[first + 1], share) if share else lines[first]

        return at

    def refusals(self) -> Iterator[Refusal]:
        """Yield what the keys do not allow one another."""
        if len(self.x_mm) < 2:
            yield Refusal("x_mm", "allowed: two points or more", f"{len(self.x_mm)} numbers")
        for key in ("z_mm", "pressure_kPa"):
            if getattr(self, key) is not None:
                yield from self.as_many(key, "x_mm")
        if self.pressure_kPa is not None:
            if (np.diff(self.pressure_kPa) < 0).any():
                yield Refusal("pressure_kPa", "allowed: rising", list(self.pressure_kPa))
            if min(map(len, self.lines)) < 2:
                words = "allowed: one point of each, the tip's way, or two and more of each"
                yield Refusal("pressure_kPa", words, list(self.pressure_kPa))
            if self.of_tip:
                return
        if any(not np.hypot(*np.diff(line, axis=0).T).all() for line in self.lines):
            yield Refusal(
                "x_mm", "allowed: neighbouring points that differ", "the same point twice"
            )
