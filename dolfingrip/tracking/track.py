"""From frames to readings: one pass over the frames, then plane, body coordinates and clock.

frames → points → plane → body coordinates → clock → table
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from dolfingrip import clock as clocks
from dolfingrip.channels import ANGLE, PRESSURE, TIME, VOLUME
from dolfingrip.clock import Clock
from dolfingrip.config import Config
from dolfingrip.tracking import body as bodies
from dolfingrip.tracking import plane
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.body import Body
from dolfingrip.tracking.plane import Calibration
from dolfingrip.tracking.points import Watched
from dolfingrip.tracking.scale import calibrate

STILL: Final = 1.0
"""A finger of whose points none moves so far (px) may be something else."""


@dataclass(frozen=True)
class Tracked:
    """All that was found.

    Attributes:
        watched: in the frames.
        camera: and what is not known of it.
        bodies: the fingers.
        clock: None without a log.
        control: (frames,) by column.
        told: sentences for people.
        doubts: sentences on what may be wrong.
    """

    watched: Watched
    camera: Calibration
    bodies: list[Body]
    clock: Clock | None
    control: Mapping[str, np.ndarray]
    told: list[str]
    doubts: list[str]


def synchronise(
    watched: Watched, fingers: Sequence[Body], log: Mapping[str, np.ndarray], request: TrackAsked
) -> Clock:
    """Bring the log and the video together.

    Args:
        watched: what was seen.
        fingers: the fingers, whose motion may tell the shift.
        log: ``time_s``, ``pressure_kPa`` or ``volume_ml``, and ``event``, where something is told
            to show in both.
        request: what is told.

    Raises:
        ConfigError: one line, where nothing common is seen.
    """
    time_s, log_s = watched.points.time_s, log[TIME.name]
    step, log_step = float(np.median(np.diff(time_s))), float(np.median(np.diff(log_s)))
    if request.shift_s is not None:
        return Clock(request.shift_s, 1.0, step / np.sqrt(12), "what was told")
    if request.light_px is not None:
        seen = clocks.steps_up(time_s, watched.light)
        logged = clocks.steps_up(log_s, log["event"])
        return clocks.by_events(logged, seen, log_step, step, "a light")
    if request.knock:
        seen = clocks.knock(time_s, watched.points.px.reshape(len(time_s), -1))
        logged = clocks.knock(log_s, log["event"][:, None])
        return clocks.by_events(logged, seen, log_step, step, "a knock")
    motion = fingers[0].readings[ANGLE.name]
    control = log[PRESSURE.name if PRESSURE.name in log else VOLUME.name]
    return clocks.by_motion(log_s, control, time_s, motion)


def understand(
    watched: Watched, request: TrackAsked, log: Mapping[str, np.ndarray] | None, config: Config
) -> Tracked:
    """Turn what was seen into readings.

    Args:
        watched: what was seen.
        request: what is told.
        log: of the control; None: states of pictures are told.
        config: of the finger, which has its width.

    Raises:
        ConfigError: one line, where scale or clock are missing.
    """
    width = float(getattr(config.geometry, "width_mm", 20.0))
    if request.family is not None:
        width = request.family.width_mm / 2
    camera = calibrate(watched, request, width)
    fingers = []
    for numbers in watched.fingers:
        points = watched.points.part(numbers)
        fingers.append(bodies.read(points, camera, request.clamp_px, request.side))
    clock = None
    control = dict(request.states)
    if log is not None:
        clock = synchronise(watched, fingers, log, request)
        at, log_s = clock.of(watched.points.time_s), log[TIME.name]
        for name in log.keys() - {TIME.name, "event"}:
            control[name] = np.interp(at, log_s, log[name], left=np.nan, right=np.nan)
    sentences, doubts = _sentences(watched, camera, fingers, clock)
    return Tracked(watched, camera, fingers, clock, control, sentences, doubts)


def _sentences(
    watched: Watched, camera: Calibration, fingers: Sequence[Body], clock: Clock | None
) -> tuple[list[str], list[str]]:
    points = watched.points
    middle = np.nanmean(points.px.reshape(-1, 2), axis=0)
    scale, spread = camera.scale(middle)
    front = float(np.sqrt(camera.covariance[plane.FRONT, plane.FRONT]))
    sentences = [
        f"scale by {camera.by}: {scale:.4f} mm/{points.unit} ± {100 * spread:.2f} % at the points, "
        f"{camera.mean[plane.FRONT]:.1f} ± {front:.1f} mm in front of it",
        *watched.notes,
    ]
    doubts = [*camera.doubts, *watched.doubts]
    if camera.has_sheet:
        of_lens = {
            plane.K1: f"{camera.mean[plane.K1]:.3f}",
            plane.F: f"{np.exp(camera.mean[plane.F]):.0f} px",
        }
        k1, focal = (of_lens[i] if camera.determined(i) else "not determined" for i in of_lens)
        sentences.append(
            f"camera: {camera.tilt_deg:.1f}° from the sheet's normal, focal length {focal}, "
            f"distortion k1 {k1}, corners to {camera.residual_px:.2f} px"
        )
    for i, (numbers, finger) in enumerate(zip(watched.fingers, fingers, strict=True), 1):
        lost = np.isnan(points.px[:, numbers, 0])
        sentences.append(
            f"finger {i}: {len(numbers)} points, bends to the {finger.bends}; noise "
            f"{finger.frame_px:.2f} {points.unit} in a frame; {lost.sum()} of {lost.size} entries "
            "lost"
        )
        if lost.mean() > 0.2:
            doubts.append(f"finger {i}: {100 * lost.mean():.0f} % of its entries are lost")
        if ANGLE.name in finger.compared and points.corners_px is None:
            doubts.append(
                f"finger {i}: nothing tells where the clamp is (--clamp), so its angle alone is "
                "compared, as that of the tip's face; it is that of a line, which turns less"
            )
        way = points.px[:, numbers] - points.px[0, numbers]
        if np.nanmax(np.abs(way)) < STILL:
            doubts.append(f"finger {i}: none of its points moves by {STILL:g} {points.unit}")
        if abs(finger.askew_deg) > 3:
            doubts.append(f"finger {i}: at rest it is {finger.askew_deg:.1f}° askew to the sheet")
    if clock is not None:
        drift = f", {1e6 * (clock.rate - 1):.0f} ppm of drift" if clock.rate != 1 else ""
        sentences.append(
            f"clock by {clock.by}: first frame at {clock.shift_s:.3f} ± {clock.std_s:.3f} s of the "
            f"log{drift}"
        )
        doubts += [f"clock: {clock.doubt}"] if clock.doubt else []
    return sentences, doubts
