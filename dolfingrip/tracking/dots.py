"""Dots of one colour in a frame: learnt in the first one, found in each.

A colour is a direction away from the picture's ordinary colour, without brightness, so that neither
shadows nor a coloured light count. Glare inside of a dot is filled. One that is partly hidden has
the middle of what is seen, which its share tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from scipy.sparse.csgraph import minimum_spanning_tree
from scipy.spatial.distance import cdist

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking.frames import Image
from dolfingrip.tracking.points import Unseen

NAMES: Final = {
    "red": (255, 0, 0), "orange": (255, 140, 0), "yellow": (255, 230, 0), "green": (0, 170, 0),
    "cyan": (0, 200, 220), "blue": (0, 60, 255), "magenta": (230, 0, 180), "black": (0, 0, 0),
    "white": (255, 255, 255),
}  # fmt: skip
"""Colours that can be asked for by name, in red, green and blue."""

Box = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of a frame (px)."""


@dataclass(frozen=True, slots=True)
class DotPolicy:
    """Sizes, forms and contrasts of what looks like a dot.

    Attributes:
        sectors: hues that are tried.
        contrasts: distances from the ordinary colour that are tried, in units of chroma.
        least_px: smallest area.
        most_part: largest area, as a part of the frame.
        round: smallest area by that of the convex hull, and of this by that of a circle of its
            perimeter.
        alike: largest factor between the areas of dots.
        least_share: of a dot's colour that a pixel within it has.
        part_seen: share of a dot's area below which it is partly hidden.
        least_seen: share below which it is lost.
    """

    sectors: int = 12
    contrasts: tuple[float, ...] = (9.0, 15.0, 25.0, 42.0)
    least_px: float = 9.0
    most_part: float = 0.003
    round: float = 0.7
    alike: float = 2.2
    part_seen: float = 0.85
    least_share: float = 0.35
    least_seen: float = 0.4


POLICY: Final = DotPolicy()


@dataclass(frozen=True, slots=True)
class Colour:
    """The colour of dots.

    Attributes:
        light: (3,) factors of blue, green and red that make the picture's ordinary colour grey.
        ordinary: (3,) that of the picture, in brightness and chroma.
        direction: (3,) to that of the dots; its length is their distance.
        area_px: of a dot.
    """

    light: np.ndarray
    ordinary: np.ndarray
    direction: np.ndarray
    area_px: float

    def share(self, lab: np.ndarray) -> np.ndarray:
        """How far pixels are of this colour, 0 to 1: (h, w) from (h, w, 3)."""
        size = float(np.linalg.norm(self.direction))
        along, aside = _parts(lab, self.ordinary, self.direction / size)
        return np.asarray(np.clip((along - np.maximum(aside - 0.5 * size, 0)) / size, 0, 1))


@dataclass(frozen=True, slots=True)
class Dot:
    """A dot in a frame.

    Attributes:
        centre_px: (2,).
        area_px: that is seen.
        seen: share of its area that is seen, at most 1.
    """

    centre_px: np.ndarray
    area_px: float
    seen: float


def in_chroma(image: Image, light: np.ndarray) -> np.ndarray:
    """Brightness and chroma of a picture, (h, w, 3) of 8 bits, as in a light without colour.

    Args:
        image: in blue, green and red.
        light: (3,) factors of these.
    """
    import cv2

    table = np.round(np.arange(256)[:, None] * light).astype(np.uint8)[:, None]
    return np.asarray(cv2.cvtColor(cv2.LUT(image, table), cv2.COLOR_BGR2YCrCb))


def _parts(
    lab: np.ndarray, ordinary: np.ndarray, unit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """How far pixels are from the ordinary colour along a direction, and beside it in hue."""
    import cv2

    # of black and white brightness counts alone
    rows = np.array([unit, [0.0, unit[2], -unit[1]]])
    matrix = np.column_stack([rows, -rows @ ordinary]).astype(np.float32)
    along, aside = cv2.split(cv2.transform(lab.astype(np.float32), matrix))
    return along, np.abs(aside)


def find(image: Image, colour: Colour, box: Box | None = None) -> list[Dot]:
    """Find all dots of a colour in a frame, or in a part of it.

    Args:
        image: in blue, green and red.
        colour: of the dots.
        box: the part.
    """
    import cv2

    left, top, right, bottom = box or (0, 0, image.shape[1], image.shape[0])
    share = colour.share(in_chroma(image[top:bottom, left:right], colour.light))
    mask = (share > POLICY.least_share).astype(np.uint8)
    dots = []
    for outline in _outlines(mask, 0.3 * colour.area_px, 4 * colour.area_px):
        hull = cv2.convexHull(outline)
        x, y, width, height = cv2.boundingRect(hull)
        margin = 3
        x0, y0 = max(x - margin, 0), max(y - margin, 0)
        part = share[y0 : y + height + margin, x0 : x + width + margin]
        inside = np.zeros(part.shape, np.uint8)
        cv2.fillConvexPoly(inside, hull - [x0, y0], 1)
        near = cv2.dilate(inside, np.ones((5, 5), np.uint8))
        # a codec takes colour from a dot that moves, and blur does
        full = float(np.percentile(part[inside > 0], 80))
        weight = np.clip((part / full - 0.1) / 0.8, 0, 1) * near
        weight[cv2.erode(inside, np.ones((3, 3), np.uint8)) > 0] = 1.0  # glare
        area = float(weight.sum())
        rows, columns = np.indices(part.shape)
        centre = np.array([(weight * columns).sum(), (weight * rows).sum()]) / area + [x0, y0]
        seen = min(area / colour.area_px, 1.0)
        odd = area > POLICY.alike * colour.area_px or max(width, height) > 4 * min(width, height)
        if seen < POLICY.least_seen or (odd and seen >= POLICY.part_seen):
            continue
        dots.append(Dot(centre + np.array([left, top]), area, seen))
    return dots


def _outlines(mask: np.ndarray, least: float, most: float) -> Iterator[np.ndarray]:
    """Outer contours of connected parts of a mask, of some areas (px)."""
    import cv2

    outlines, tree = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    for outline, (*_, hole_of) in zip(outlines, tree[0] if outlines else (), strict=True):
        if hole_of >= 0:  # a part within a hole of another, as of the sheet's frame, is none
            continue
        # through the outermost pixels' middles
        if least <= cv2.contourArea(outline) + 0.5 * len(outline) + 1 <= most:
            yield outline


def learn(
    image: Image, name: str | None, count: int | None, groups: int, points: np.ndarray | None
) -> tuple[Colour, np.ndarray]:
    """Find which dots a frame has, and their colour.

    Args:
        image: the first frame.
        name: name of the colour or ``#rrggbb``; None: any.
        count: number of dots; None: any from three on.
        groups: number of fingers.
        points: (n, 2) places of the dots, where they are given, each of one; None: they are sought.

    Returns:
        The colour, and the dots' places (n, 2) in px.

    Raises:
        ConfigError: one line with what was seen.
    """
    import cv2

    count = len(points) if points is not None else count
    usual = np.maximum(np.median(image.reshape(-1, 3), axis=0), 1.0)
    light = usual.min() / usual  # in a coloured light black would look like a colour
    lab = cv2.GaussianBlur(in_chroma(image, light), (3, 3), 0)
    ordinary = np.median(lab.reshape(-1, 3), axis=0)
    best: tuple[float, Colour, list[np.ndarray]] | None = None
    most: list[np.ndarray] = []
    for direction in _directions(name, ordinary, lab, points):
        along, aside = _parts(lab, ordinary, direction)
        for contrast in POLICY.contrasts:
            mask = (along - np.maximum(aside - contrast, 0) > contrast).astype(np.uint8)
            blobs = [blob for blob in _round(mask, along) if points is None or _is_at(blob, points)]
            for group in _alike(blobs, count, groups):
                most = max(most, group, key=len)
                if len(group) < min(count or 3 * groups, 3 * groups):
                    continue
                score = _score(group, count, groups) * (1 if points is not None else contrast**0.5)
                if best is None or score > best[0]:
                    amount = float(np.median([blob[3] for blob in group]))
                    area = float(np.median([blob[2] for blob in group]))
                    best = score, Colour(light, ordinary, direction * amount, area), group
    if best is None or (count is not None and len(best[2]) != count):
        what = f"{len(most)} dots of one colour are seen" if most else "no dot is seen"
        wanted = "at least 3" if count is None else str(count)
        raise Unseen(
            f"{what} in the first frame, of {wanted}; allowed: round dots of one size and of a "
            f"colour that nothing beside them has; --colour {'|'.join(NAMES)}, --dots NUMBER or "
            '--points "X,Y X,Y …" (px), one in each, tells which',
            np.array([blob[:2] for blob in most]).reshape(-1, 2),
        )
    colour, places = best[1], np.array([blob[:2] for blob in best[2]])
    if not colour.direction[0]:  # as seen, and not as tried
        at = np.round(places).astype(int)
        away = np.median(lab[at[:, 1], at[:, 0]] - ordinary, axis=0)
        colour = replace(colour, direction=away * [0, 1, 1])
    # the contrast by which they were found makes them smaller than they are
    mask = (colour.share(lab) > POLICY.least_share).astype(np.uint8)
    sizes = [
        cv2.contourArea(outline) + 0.5 * len(outline) + 1
        for outline in _outlines(mask, POLICY.least_px, POLICY.most_part * mask.size)
        if any(cv2.pointPolygonTest(outline, at.tolist(), False) >= 0 for at in places)
    ]
    colour = replace(colour, area_px=float(np.median(sizes or [colour.area_px])))
    dots = find(image, colour)
    if not dots:
        return colour, places
    away = cdist(places, [dot.centre_px for dot in dots])
    there = away.min(axis=1) < 0.5 * np.sqrt(colour.area_px)
    nearest = [dots[i] for i in away.argmin(axis=1)[there]]
    places[there] = np.array([dot.centre_px for dot in nearest]).reshape(-1, 2)
    areas = [dot.area_px for dot in nearest] or [colour.area_px]
    return replace(colour, area_px=float(np.median(areas))), places


def _directions(
    name: str | None, ordinary: np.ndarray, lab: np.ndarray, points: np.ndarray | None
) -> Iterator[np.ndarray]:
    """Unit vectors of brightness and chroma along which dots may differ from the picture."""
    import cv2

    if points is not None and name is None:
        u, v = np.round(np.median(points[:1], axis=0)).astype(int)
        near = lab[max(v - 1, 0) : v + 2, max(u - 1, 0) : u + 2].reshape(-1, 3)
        unlike = np.median(near, axis=0) - ordinary
        away = unlike * [0, 1, 1]
        if np.linalg.norm(away) < POLICY.contrasts[0]:
            away = np.array([np.sign(unlike[0]) or 1.0, 0.0, 0.0])
        yield away / np.linalg.norm(away)
        return
    if name in ("black", "white"):
        yield np.array([-1.0 if name == "black" else 1.0, 0.0, 0.0])
        return
    hues = np.linspace(0, 2 * np.pi, POLICY.sectors, endpoint=False)
    if name is not None:
        try:
            rgb = NAMES[name] if name in NAMES else tuple(bytes.fromhex(name.removeprefix("#")))
            pure = cv2.cvtColor(np.array([[rgb[::-1]]], np.uint8), cv2.COLOR_BGR2YCrCb)[0, 0]
        except (ValueError, cv2.error):
            raise ConfigError(f"--colour {name}: allowed: {', '.join(NAMES)} or #rrggbb") from None
        hue = np.arctan2(float(pure[2]) - 128, float(pure[1]) - 128)
        hues = hue + np.radians([-20, -10, 0, 10, 20])
    for hue in hues:
        yield np.array([0.0, np.cos(hue), np.sin(hue)])


def _is_at(blob: np.ndarray, points: np.ndarray) -> bool:
    return bool(np.linalg.norm(points - blob[:2], axis=1).min() < 0.8 * np.sqrt(blob[2]))


def _round(mask: np.ndarray, along: np.ndarray) -> list[np.ndarray]:
    """Round parts of a mask: u, v, area and distance from the ordinary colour."""
    import cv2

    blobs = []
    for outline in _outlines(mask, POLICY.least_px, POLICY.most_part * mask.size):
        around = cv2.convexHull(outline)  # glare at the edge of a dot makes a notch
        area, hull = cv2.contourArea(outline), cv2.contourArea(around)
        round_ = 4 * np.pi * hull / max(cv2.arcLength(around, True), 1) ** 2
        (u, v), sides, _ = cv2.minAreaRect(outline)
        if area < POLICY.round * hull or round_ < POLICY.round or max(sides) > 2 * min(sides):
            continue
        away = along[int(v) - 1 : int(v) + 2, int(u) - 1 : int(u) + 2]
        moments = cv2.moments(outline)
        centre = np.array([moments["m10"], moments["m01"]]) / moments["m00"]
        blobs.append(np.array([*centre, area + 0.5 * len(outline), np.median(away)]))
    return blobs


def _alike(
    blobs: Sequence[np.ndarray], count: int | None, groups: int
) -> Iterator[list[np.ndarray]]:
    """Groups of blobs of about one size and contrast."""
    for first in blobs:
        group = [
            blob for blob in blobs
            if first[2] <= blob[2] <= POLICY.alike * first[2]
            and 0.5 < blob[3] / max(first[3], 1) < 2
        ]  # fmt: skip
        group = _without_strays(group, groups, count)
        yield group


def _without_strays(group: list[np.ndarray], groups: int, count: int | None) -> list[np.ndarray]:
    """Without those that are far from all others, or of which there are too many."""
    while len(group) > (count or 3 * groups):
        away = cdist([blob[:2] for blob in group], [blob[:2] for blob in group])
        np.fill_diagonal(away, np.inf)
        nearest = away.min(axis=1)
        if count is None and nearest.max() < 2.5 * np.median(nearest):
            break
        group = [blob for i, blob in enumerate(group) if i != int(nearest.argmax())]
    return group


def _score(group: Sequence[np.ndarray], count: int | None, groups: int) -> float:
    """How much a group looks like dots along a finger: many, of one size, evenly spaced."""
    table = np.array(group)
    tree = minimum_spanning_tree(cdist(table[:, :2], table[:, :2]))
    steps = np.sort(tree.data)[: len(group) - groups]
    uneven = float(np.std(steps) / np.mean(steps)) if len(steps) else 1.0
    sizes = float(np.std(table[:, 2]) / np.mean(table[:, 2]))
    number = min(len(group), 15) if count is None else (10.0 if len(group) == count else 0.01)
    return float(number * np.exp(-((sizes / 0.25) ** 2) - (uneven / 0.5) ** 2))
