"""The scale: by the sheet, lengths, tags, or the first point's distance from the clamp."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
import pandas as pd

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import plane
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.plane import Calibration, Length
from dolfingrip.tracking.points import Watched

MOVED_PX: Final = 0.5
"""Motion of the sheet's corners from which on the camera moved."""
FRONT_STD_MM: Final = (0.7, 4.0)
"""Standard deviation of the points' distance from the plane where it is told, and where not."""


def calibrate(watched: Watched, request: TrackAsked, width_mm: float) -> Calibration:
    """Find the camera by the sheet, by lengths, by tags, or by the first point's distance.

    Args:
        watched: what was seen.
        request: what is told.
        width_mm: of the finger, as far as nothing is told of the points' distance from the sheet.

    Raises:
        ConfigError: one line, where nothing tells the scale.
    """
    has_distance = request.in_front_mm is not None
    spread = FRONT_STD_MM[0] if has_distance else FRONT_STD_MM[1]
    size = watched.size_px
    if watched.corners and max(len(mm) for mm, _ in watched.corners) >= plane.POLICY.least_corners:
        front = request.in_front_mm if request.in_front_mm is not None else width_mm
        sheet_mm, seen_px, moved = _mean_corners(watched.corners)
        calibration = plane.of_sheet(size, sheet_mm, seen_px, (front, spread))
        if moved > MOVED_PX:
            calibration.doubts.append(
                f"the camera moved: the sheet's corners by {moved:.1f} px; put it on a stand"
            )
        return calibration
    if watched.in_space:
        return plane.of_space(size)
    lengths, by = list(request.scales or watched.lengths), "two points"
    if not request.scales and watched.lengths:
        by = "the file's own"
    front = request.in_front_mm or 0.0
    corners = watched.points.corners_px
    if not lengths and corners is not None and request.tag_mm is not None:
        front, spread, by = 0.0, 0.1, "tags"
        for square in np.nanmedian(corners[:10], axis=0):
            for i in range(4):
                ends = square[[i, (i + 1) % 4]]
                lengths.append(Length(ends, request.tag_mm, 0.01 * request.tag_mm))
    if not lengths and request.clamp_px is not None and request.first_mm is not None:
        front, spread, by = 0.0, 0.1, "clamp and first point"
        ends = np.array([request.clamp_px, watched.points.px[0, watched.fingers[0][0]]])
        lengths.append(Length(ends, request.first_mm, 0.3))
    if not lengths:
        seen = max((len(mm) for mm, _ in watched.corners), default=0)
        what = (
            f"{seen} corners of the printed sheet are seen" if seen else "no printed sheet is seen"
        )
        raise ConfigError(
            f"{what}, and no scale is told; allowed: a sheet of `dolfingrip track --sheet a4 -o "
            'sheet.pdf` behind the finger, --scale "X,Y X,Y = LENGTH mm", tags with --tag-side, or '
            "--clamp with --first"
        )
    calibration = plane.of_lengths(size, lengths, (front, spread), by)
    calibration.doubts.append(
        f"no sheet tells the camera's tilt; {2 * plane.POLICY.tilt_deg:.0f}° are within the errors"
    )
    return calibration


def _mean_corners(
    corners: Sequence[tuple[np.ndarray, np.ndarray]],
) -> tuple[np.ndarray, np.ndarray, float]:
    """Places on the sheet, mean places in the picture, and the largest standard deviation (px)."""
    rows = pd.DataFrame(np.concatenate([np.hstack(pair) for pair in corners]))
    seen = rows.groupby([0, 1], sort=False)
    places, spreads = seen.median(), seen.std(ddof=0).max(axis=1)
    often = 2 * seen.size() > len(corners)
    often |= not often.any()
    sheet_mm = np.array(places.index[often].to_list())
    return sheet_mm, places[often].to_numpy(), float(spreads[often].median())
