"""Edges between a finger and what is behind it, to a fraction of a pixel along normals."""

from __future__ import annotations

from typing import Final

import numpy as np

STEP_PX: Final = 0.5
STRANGE: Final = 0.4
"""Difference from the finger's colour, by that of the background, which tells no more against it:
an edge may be lit or shaded, or be of another part."""
LEAST: Final = 12.0
"""Difference of colours (of 255) that makes an edge."""
DEEP_PX: Final = (1.5, 5.0)
"""Distances from an edge between which colours are those of its two sides. Inside, the one that is
most unlike the background counts: a narrow strip may be lit otherwise, and motion blurs edges."""
NEAR_PX: Final = 2.5
"""Distance from an edge up to which a pixel may be of both sides."""

Floats = np.ndarray


def sampled(image: Floats, places_px: Floats) -> Floats:
    """Colours (…, 3) of a picture between its pixels.

    Args:
        image: (height, width, 3) of 8 bits or 32-bit floats.
        places_px: (…, 2).
    """
    import cv2

    maps = places_px.astype(np.float32).reshape(-1, 1, 2)
    seen = cv2.remap(image, maps, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(seen, dtype=float).reshape(*places_px.shape[:-1], 3)


def offsets(
    image: Floats, behind: Floats, inner: Floats, at_px: Floats, normals: Floats, reach_px: float
) -> tuple[Floats, Floats]:
    """Find the edge on each normal: pixels beyond it look like the background, and before it not.

    Args:
        image: the frame.
        behind: what is behind the finger, of the same size.
        inner: (n, 3) colour of the finger at each normal.
        at_px: (n, 2) where the edges are expected.
        normals: (n, 2) unit vectors out of the finger.
        reach_px: farthest place of an edge from there.

    Returns:
        Distance (n,) of each edge from where it is expected, NaN where there is none, and the
        colour (n, 3) of the finger beside it.
    """
    reach = reach_px + DEEP_PX[1]
    away = np.arange(-reach, reach + STEP_PX / 2, STEP_PX)
    places = at_px[:, None] + away[:, None] * normals[:, None]
    colours, ground = sampled(image, places), sampled(behind, places)
    contrast = ((inner[:, None] - ground) ** 2).sum(axis=2)
    as_finger = np.minimum(
        ((colours - inner[:, None]) ** 2).sum(axis=2), STRANGE**2 * np.maximum(contrast, LEAST**2)
    )
    as_ground = ((colours - ground) ** 2).sum(axis=2)
    total = np.cumsum(as_finger, axis=1) + as_ground.sum(axis=1)[:, None]
    total -= np.cumsum(as_ground, axis=1)
    total[:, np.abs(away) > reach_px] = np.inf
    edge = away[total.argmin(axis=1)] + STEP_PX / 2
    depth = np.linspace(*DEEP_PX, 8)
    layers = sampled(image, at_px[:, None] + (edge[:, None] - depth)[..., None] * normals[:, None])
    rows = np.arange(len(edge))
    beyond = ground[rows, np.abs(away - edge[:, None]).argmin(axis=1)]
    unlike = ((layers - beyond[:, None]) ** 2).sum(axis=2).argmax(axis=1)
    inside = layers[rows, unlike]
    across = inside[:, None] - ground
    size = np.maximum((across**2).sum(axis=2), 1.0)
    share = np.clip(((colours - ground) * across).sum(axis=2) / size, 0.0, 1.0)
    near = np.abs(away - edge[:, None]) < NEAR_PX
    place = edge - NEAR_PX + STEP_PX * (share * near).sum(axis=1) + _cut(away, edge)
    beside = np.sqrt((size * near).sum(axis=1) / near.sum(axis=1))
    misfit = total.min(axis=1) / (len(away) * np.maximum(beside, 1.0) ** 2)
    sides = [
        sampled(
            behind, at_px[:, None] + (edge[:, None] + sign * depth)[..., None] * normals[:, None]
        )
        for sign in (-1, 1)
    ]  # an edge that is there without the finger is of something in front of it
    standing = np.linalg.norm(np.median(sides[0], 1) - np.median(sides[1], 1), axis=1)
    good = (
        (beside > LEAST)
        & (standing < STRANGE * beside)
        & (misfit < STRANGE**2)
        & (np.abs(edge) < reach_px - STEP_PX)
    )
    return np.where(good, place, np.nan), np.median(layers[:, len(depth) // 3 :], axis=1)


def _cut(away: Floats, edge: Floats) -> Floats:
    """Distance from where an edge may begin to the first sample that counts, for each edge."""
    first = away[np.argmax(np.abs(away - edge[:, None]) < NEAR_PX, axis=1)]
    return np.asarray(first - STEP_PX / 2 - (edge - NEAR_PX))


def surrounded(image: Floats, outline_px: Floats, depth_px: float) -> float:
    """Share of an outline (n, 2) on whose two sides a picture has different colours.

    Args:
        image: the frame.
        outline_px: closed, in order.
        depth_px: distance from it at which colours are compared.
    """
    along = np.roll(outline_px, -4, axis=0) - np.roll(outline_px, 4, axis=0)
    across = np.column_stack([along[:, 1], -along[:, 0]])
    across = depth_px * across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-9)
    sides = [sampled(image, outline_px + sign * across) for sign in (-1, 1)]
    return float((np.linalg.norm(sides[0] - sides[1], axis=1) > LEAST).mean())
