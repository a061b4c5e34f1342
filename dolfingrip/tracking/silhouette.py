"""A finger without marks: its back is read from the edge of its silhouette.

The configuration's own finger only starts the search, and tells which point of the back is where
along it, and which part of the width is outermost as the camera sees it. The line that is written
is fitted to edges; nothing but smoothness keeps it near a simulated one. Where the picture has no
edge, as behind a cable, the line is as uncertain as smoothness leaves it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import edges
from dolfingrip.tracking.body import DRAWS
from dolfingrip.tracking.family import Family
from dolfingrip.tracking.frames import Image
from dolfingrip.tracking.plane import Calibration
from dolfingrip.tracking.points import TrackedPoints

Floats = np.ndarray


@dataclass(frozen=True, slots=True)
class SilhouettePolicy:
    """How an outline is searched for, and how sure its edges are.

    Attributes:
        directions: of a finger at rest that are tried where no sheet tells it.
        surrounded: least share of a finger's outline with two colours.
        seen: least share of the back's edge below which a frame is lost.
        edge_px: standard deviation of an edge, whose neighbours err alike.
        common_px: of all edges of a frame and a light.
        tip_mm: of the tip's face from the simulated one.
        place_mm: of the clamp from where it was told, across and along the finger.
        made: of a finger's length at rest from the configuration's, by that.
        stretch: of the back's stretch from the simulated one.
        wave: of the second difference of the turn's splines (rad).
        along: standard deviation of a point along the back, by its shift against equal stretch.
        outline_px: distance between two points of the outline that is drawn.
    """

    directions: int = 24
    surrounded: float = 0.6
    seen: float = 0.35
    edge_px: float = 0.5
    common_px: float = 0.15
    tip_mm: float = 0.15
    place_mm: tuple[float, float] = (1.5, 1.0)
    made: float = 0.003
    stretch: float = 0.03
    wave: float = 0.1
    along: float = 0.5
    outline_px: int = 3


POLICY: Final = SilhouettePolicy()
FIRST_MM: Final = (4.0, 2.0, 1.0)
NEXT_MM: Final = (3.0, 1.0)
ANEW_MM: Final = (8.0, 4.0, 2.0, 1.0)
"""Farthest place of an edge from where it is expected, of each round."""
LEAST_PX: Final = 4.0
"""That place at least."""
DEEP_MM: Final = 4.0
"""Distance within an expected edge at which a finger has its colour."""
SMALL: Final = 0.01
"""Change of an unknown by which edges are differentiated."""
MARGIN_MM: Final = 1.5
"""Distance from the outline of a finger that was fitted at which the background is seen."""
STANDING: Final = 4
"""First unknowns, which all frames have in common: the clamp along x and z (mm), and how far along
these a point is seen that is 1 mm behind the middle, which a camera's tilt changes."""
FREE: Final = 5
"""Unknowns before those of the turn; the last one is the stretch."""


@dataclass(frozen=True)
class _Fit:
    """A line that was fitted: number of its shape, unknowns and their covariance."""

    shape: float
    unknowns: Floats
    covariance: Floats
    seen: Floats
    inner: Floats


class Silhouette:
    """Follows the silhouette of a finger.

    Args:
        family: shapes that start the search.
        camera: by what the first frame shows.
        image: the first frame, in which the finger rests.
        clamp_px: where the clamp holds the back; None: at the sheet's mark.
        side: to which it bends, ``left`` or ``right`` of the way from clamp to tip; None: as seen.
        count: number of points on the back, the last one at its tip.

    Attributes:
        outlines: of the frames, (n, 2) px: that of the simulated finger with the fitted back.
        shared_px: of the frames, (draws, points, 2) errors that all frames have in common.

    Raises:
        ConfigError: one line, where no outline of such a finger is seen.
    """

    radius_px = 0.0

    def __init__(
        self, family: Family, camera: Calibration, image: Image, clamp_px: Floats | None,
        side: str | None, count: int,
    ) -> None:  # fmt: skip
        self._family, self._camera = family, camera
        self._px_per_mm = 1 / camera.scale((np.array(camera.size_px) - 1) / 2)[0]
        self.outlines: list[Floats] = []
        self.shared_px: list[Floats] = []
        stations = family.stations_mm
        shares = np.arange(1, count + 1) / count
        self._at_mm = stations[0] + shares * (stations[-1] - stations[0])
        self._middle_mm = float(family.points_mm[:, 1].min() + family.points_mm[:, 1].max()) / 2
        self._samples = np.concatenate([family.back, family.tip])
        self._is_tip = np.arange(len(self._samples)) >= len(family.back)
        self._skin = np.arange(family.back.min())
        self._behind = image.copy()
        splines = family.waves.shape[1]
        self._mean = np.zeros(FREE + splines)
        bends = np.diff(np.eye(splines), 2, axis=0) / POLICY.wave
        self._smooth = np.zeros((FREE + splines,) * 2)
        self._smooth[FREE:, FREE:] = bends.T @ bends
        self._origin, self._axes = self._placed(image, clamp_px, side)
        # what the finger hides in all frames so far is guessed from around it
        self._hide(image, self._mean, DEEP_MM)
        start = _Fit(0.0, self._mean, np.empty(0), np.empty(0), np.full((1, 3), np.nan))
        tilt = np.radians(camera.axis_std_deg)
        std = np.r_[POLICY.place_mm, tilt, tilt, POLICY.made, np.full(splines, 0.3)]
        self._prior = np.diag(std**-2.0) + self._smooth
        self._last = self._fitted(image, start, FIRST_MM)
        if self._share(self._last) < POLICY.seen:
            raise _nothing(self._share(self._last))
        self._hide(image, self._last.unknowns, MARGIN_MM)
        self._mean[:STANDING] = self._last.unknowns[:STANDING]
        self._prior = np.diag(np.r_[np.zeros(FREE - 1), POLICY.stretch**-2, np.ones(splines)])
        self._prior += self._smooth
        standing = self._last.covariance[:STANDING, :STANDING]
        self._prior[:STANDING, :STANDING] = np.linalg.inv(standing)
        self._rest, self._turn = self._last, self._turned(self._last)
        self._speed = np.zeros_like(self._turn)

    def step(self, image: Image) -> tuple[Floats, Floats]:
        """Find the back in the next frame.

        Args:
            image: in blue, green and red.

        Returns:
            Places (n, 2) in px of the points, and the share of edges that is seen by each (n,).
        """
        start = self._like(self._turn + self._speed, self._last)
        fit = self._fitted(image, start, NEXT_MM)
        return self._taken(image, fit) if self._share(fit) > POLICY.seen else self.anew(image)

    def anew(self, image: Image) -> tuple[Floats, Floats]:
        """Find the back in a picture of another state; see :meth:`step`.

        Args:
            image: in blue, green and red.
        """
        shapes = np.arange(0, len(self._family.turn) - 0.99, 0.125)
        starts = [_Fit(shape, self._mean, np.empty(0), np.empty(0), self._rest.inner)
                  for shape in shapes.tolist()]  # fmt: skip
        scores = [self._likeness(image, start) for start in starts]
        fit = self._fitted(image, starts[int(np.argmax(scores))], ANEW_MM)
        if self._share(fit) > POLICY.seen:
            return self._taken(image, fit)
        self.outlines.append(np.zeros((0, 2)))
        self.shared_px.append(np.zeros((DRAWS, len(self._at_mm), 2)))
        self._speed[:] = 0.0
        return np.full((len(self._at_mm), 2), np.nan), np.zeros(len(self._at_mm))

    def completed(self, points: TrackedPoints) -> TrackedPoints:
        """Points of all frames, with the errors that these have in common.

        Args:
            points: as they were found.
        """
        return replace(points, shared_px=np.stack(self.shared_px, axis=1))

    def _taken(self, image: Image, fit: _Fit) -> tuple[Floats, Floats]:
        """Remember a fit, and what is behind the finger now; places and shares of its points."""
        turn = self._turned(fit)
        self._speed = turn - self._turn if self.outlines else np.zeros_like(turn)
        self._last, self._turn = fit, turn
        self.outlines.append(self._outline(fit.unknowns, fit.shape))
        if self._hidden.any():
            new = (self._hidden > 0) & (self._covered(self.outlines[-1], MARGIN_MM) == 0)
            self._behind[new] = image[new]
            self._hidden[new] = 0
        px, errors = self._points(fit)
        self.shared_px.append(errors)
        near = np.abs(self._family.points_mm[self._family.back[:, 0], 2] - self._at_mm[:, None])
        window = near < 0.6 * self._at_mm[0]
        seen = (window * fit.seen[~self._is_tip]).sum(axis=1) / window.sum(axis=1)
        return px, np.maximum(seen, 1e-3)

    def _placed(
        self, image: Image, clamp_px: Floats | None, side: str | None
    ) -> tuple[Floats, Floats]:
        """Where the clamp is in the plane, and the axes, by which an outline is there at rest."""
        origin = np.zeros(2)
        angles: Floats = np.zeros(1)
        if clamp_px is not None:
            origin = self._camera.plane_mm(np.asarray(clamp_px, dtype=float)[None])[0]
        if not self._camera.has_sheet:
            angles = np.linspace(0, 2 * np.pi, POLICY.directions, endpoint=False)
        best, most = np.eye(2), -1.0
        for angle in angles:
            z = np.array([-np.sin(angle), np.cos(angle)])
            for name, sign in (("left", -1.0), ("right", 1.0)):
                if side in (None, name):
                    # −x is to the left of the way from clamp to tip as it is seen, downwards
                    self._origin, self._axes = origin, np.array([sign * np.array([-z[1], z[0]]), z])
                    outline = self._outline(self._mean, 0.0)
                    score = edges.surrounded(image, outline, max(2 * self._px_per_mm, 4.0))
                    if score > most:
                        best, most = self._axes, score
        if most < POLICY.surrounded:
            raise _nothing(most)
        return origin, best

    def _pixels(self, body_mm: Floats) -> Floats:
        """Where points (…, 3) of the body are seen."""
        plane = self._origin + body_mm[..., [0, 2]] @ self._axes
        return self._camera.pixels(plane, body_mm[..., 1] - self._middle_mm)

    def _body(self, unknowns: Floats, shape: float, points: Floats) -> Floats:
        x, z, by_x, by_z, longer = unknowns[:FREE]
        body = self._family.places(shape, unknowns[FREE:], longer, points)
        deeper = body[..., 1] - self._middle_mm
        shift = np.stack([x + by_x * deeper, np.zeros_like(deeper), z + by_z * deeper], axis=-1)
        return np.asarray(body + shift)

    def _edge(self, unknowns: Floats, shape: float) -> tuple[Floats, Floats]:
        """Places (n, 2) of the back's and the tip's edges in the picture, and normals (n, 2)."""
        px = self._pixels(self._body(unknowns, shape, self._samples))
        middle = px[:, px.shape[1] // 2]
        along = np.gradient(middle[~self._is_tip], axis=0)
        across = np.gradient(middle[self._is_tip], axis=0)
        normals = np.concatenate([along, across])[:, ::-1] * np.array([1.0, -1.0])
        out = np.where(self._is_tip, along[-1] @ normals[-1], -(across[0] @ normals[0]))
        normals *= (np.sign(out) / np.linalg.norm(normals, axis=1))[:, None]
        outermost = np.einsum("njk,nk->nj", px, normals).argmax(axis=1)
        return px[np.arange(len(px)), outermost], normals

    def _fitted(self, image: Image, start: _Fit, reaches_mm: tuple[float, ...]) -> _Fit:
        """Fit a line to edges, which are looked for nearer and nearer to it."""
        unknowns: Floats = start.unknowns.copy()
        shape, inner, prior = start.shape, start.inner, self._prior
        sigma = np.where(
            self._is_tip, np.hypot(POLICY.edge_px, POLICY.tip_mm * self._px_per_mm), POLICY.edge_px
        )
        slopes: Floats | None = None
        for reach_mm in (*reaches_mm, reaches_mm[-1]):
            reach = max(reach_mm * self._px_per_mm, LEAST_PX)
            at, normals = self._edge(unknowns, shape)
            if not np.isfinite(inner).all():
                inner = edges.sampled(image, at - DEEP_MM * self._px_per_mm * normals)
            off, beside = edges.offsets(image, self._behind, inner, at, normals, reach)
            if slopes is None or reach_mm > 1:
                slopes = np.empty((len(at), len(unknowns)))
                for i in range(len(unknowns)):
                    moved = unknowns + SMALL * (np.arange(len(unknowns)) == i)
                    slopes[:, i] = ((self._edge(moved, shape)[0] - at) * normals).sum(axis=1)
                slopes /= SMALL
            seen = np.isfinite(off)
            begun, before = unknowns, np.nan_to_num(off)
            for _ in range(4):
                left = (before - slopes @ (unknowns - begun)) / sigma
                weight = seen / (1 + (left / 2) ** 2) / sigma**2
                precision = slopes.T @ (weight[:, None] * slopes) + prior
                pull = slopes.T @ (weight * left * sigma) + prior @ (self._mean - unknowns)
                unknowns = unknowns + np.linalg.solve(precision, pull)
        good = weight * sigma**2 > 0.3
        inner = np.where(good[:, None], beside, inner)
        return _Fit(shape, unknowns, np.linalg.inv(precision), good, inner)

    def _share(self, fit: _Fit) -> float:
        """Share of the back's edge that is seen."""
        return float(fit.seen[~self._is_tip].mean())

    def _turned(self, fit: _Fit) -> Floats:
        """Turn (stations,) of a line."""
        off = self._family.waves @ fit.unknowns[FREE:]
        return np.asarray(self._family.between(self._family.turn, fit.shape) + off)

    def _like(self, turn: Floats, before: _Fit) -> _Fit:
        """A line of some turn (stations,), by the shape that turns as much as a mean."""
        family = self._family
        means = np.maximum.accumulate(family.turn.mean(axis=1) * np.sign(family.turn[-1].mean()))
        mean = turn.mean() * np.sign(family.turn[-1].mean())
        shape = float(np.interp(mean, means, np.arange(len(means))))
        unknowns = before.unknowns.copy()
        left = turn - family.between(family.turn, shape)
        unknowns[FREE:] = np.linalg.lstsq(family.waves, left, rcond=None)[0]
        return _Fit(shape, unknowns, before.covariance, before.seen, before.inner)

    def _likeness(self, image: Image, fit: _Fit) -> float:
        """Share of edges within which a picture is the finger, and out of which it is not."""
        at, normals = self._edge(fit.unknowns, fit.shape)
        finger = []
        for sign in (-1, 1):
            places = at + sign * 1.2 * self._px_per_mm * normals
            colour, ground = edges.sampled(image, places), edges.sampled(self._behind, places)
            away = [np.linalg.norm(colour - other, axis=1) for other in (fit.inner, ground)]
            finger.append(away[0] < away[1])
        return float((finger[0] & ~finger[1]).mean())

    def _outline(self, unknowns: Floats, shape: float) -> Floats:
        """Outline (n, 2) px of the whole finger."""
        import cv2

        px = self._pixels(self._body(unknowns, shape, self._skin))
        corner = np.floor(px.min(axis=0)) - 2
        size = (np.ceil(px.max(axis=0)) - corner + 3).astype(int)
        mask = np.zeros(np.minimum(size[::-1], 4 * max(self._camera.size_px)), np.uint8)
        parts = np.round(px[self._family.triangles] - corner).astype(np.int32)
        sides = np.diff(parts, axis=1)
        towards = sides[:, 0, 0] * sides[:, 1, 1] < sides[:, 0, 1] * sides[:, 1, 0]
        for part in parts[towards == (self._axes[0, 0] * self._axes[1, 1] < 0)]:
            cv2.fillConvexPoly(mask, part, 1)
        outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
        longest = max(outlines, key=len)[:: POLICY.outline_px, 0]
        return np.asarray(longest + corner)

    def _hide(self, image: Image, unknowns: Floats, margin_mm: float) -> None:
        """Guess what is behind a finger at rest, and behind a margin around it."""
        import cv2

        self._hidden = self._covered(self._outline(unknowns, 0.0), margin_mm)
        self._behind = cv2.inpaint(image, self._hidden, 3, cv2.INPAINT_TELEA)

    def _covered(self, outline_px: Floats, margin_mm: float) -> Floats:
        """Where the finger may be in a frame, with a margin: (height, width) of 0 and 1."""
        import cv2

        mask = np.zeros(self._behind.shape[:2], np.uint8)
        cv2.fillPoly(mask, [np.round(outline_px).astype(np.int32)], 1)
        size = 2 * max(round(margin_mm * self._px_per_mm), 2) + 1
        return np.asarray(cv2.dilate(mask, np.ones((size, size), np.uint8)))

    def _points(self, fit: _Fit) -> tuple[Floats, Floats]:
        """Places (n, 2) px of the points, and errors (draws, n, 2) that frames have in common."""
        family = self._family
        generator = np.random.default_rng(73)
        spread = np.linalg.cholesky(fit.covariance)  # which changes little from frame to frame
        stretch = family.between(family.stretch, fit.shape)
        shift = np.cumsum(stretch / stretch.mean() - 1) * np.diff(family.stations_mm).mean()

        def places(unknowns: Floats, along: float = 0.0, out_mm: float = 0.0) -> Floats:
            turn = family.between(family.turn, fit.shape) + family.waves @ unknowns[FREE:]
            line = family.line(turn, stretch * (1 + unknowns[FREE - 1])) + unknowns[:2]
            line -= out_mm * np.column_stack([np.cos(turn), np.sin(turn)])
            at = self._at_mm - along * np.interp(self._at_mm, family.stations_mm, shift)
            x, z = (np.interp(at, family.stations_mm, values) for values in line.T)
            return self._pixels(np.stack([x, np.full_like(x, self._middle_mm), z], axis=-1))

        px = places(fit.unknowns)
        errors = []
        for _ in range(DRAWS):
            draw = fit.unknowns + spread @ generator.standard_normal(len(spread))
            along, out = generator.standard_normal(2)
            out_mm = out * POLICY.common_px / self._px_per_mm
            errors.append(places(draw, along * POLICY.along, out_mm) - px)
        return px, np.array(errors)


def _nothing(share: float) -> ConfigError:
    return ConfigError(
        f"no outline of the configuration's finger is seen at rest: {100 * share:.0f} % of it has "
        "two colours; allowed: a finger unlike what is behind it, at the sheet's mark or at "
        "--clamp X,Y; --config and --set tell its shape, and --side left|right to where it bends"
    )
