"""Scenes of the benchmark's videos by number, and what a person tells of each."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, Final

import numpy as np

from benchmarks.track.render import LENGTH_MM, Scene
from benchmarks.track.shapes import SMALL
from dolfingrip.config import load
from dolfingrip.tracking import family, plane, scale
from dolfingrip.tracking.asked import TrackAsked
from dolfingrip.tracking.family import Family
from dolfingrip.tracking.plane import Length

MARKED: Final = 30
"""Number of the first video of a finger without marks."""
COLOURS: Final = ((40, 40, 215), (190, 70, 30), (60, 165, 40), (30, 200, 230), (170, 40, 190))


def scene(number: int) -> Scene:
    """The settings of a video, by its number; the last ones have no marks."""
    rng = np.random.default_rng(7300 + number)
    sheet = number % 3 != 2
    size = [(1280, 720), (1920, 1080)][int(rng.integers(2))]
    rate = float(rng.choice([24, 25, 30, 50, 60]))
    focal = rng.uniform(0.75, 1.0)
    view_mm = 305.0 if sheet else rng.uniform(150, 230)
    fingers = 2 if rng.random() < 0.2 else 1
    marks = "tags" if rng.random() < 0.2 and fingers == 1 else "dots"
    lag = float(rng.choice([0.0, rng.uniform(0.05, 0.3)]))
    drawn = Scene(
        finger=str(rng.choice(["plain", "soft", "uneven"])), size_px=size, rate_hz=rate,
        seconds=48 / rate, tilt_deg=rng.uniform(0, 12), tilt_way_deg=rng.uniform(0, 360),
        distance_mm=view_mm * focal * size[0] / size[1], focal=focal, k1=rng.uniform(-0.1, 0.05),
        in_front_mm=rng.uniform(4, 20), sheet=sheet, marks=marks,
        count=4 if marks == "tags" else int(rng.integers(4, 9)),
        colour=COLOURS[int(rng.integers(len(COLOURS)))], radius_mm=rng.uniform(1.2, 1.8),
        blur=float(rng.choice([0.0, 0.5])), noise=rng.uniform(1, 5), uneven=rng.uniform(0, 0.4),
        cast=tuple(rng.uniform(0.8, 1.0, 3)), cable=bool(rng.random() < 0.3),
        decoys=int(rng.integers(0, 5)), fingers=fingers, bits_per_px=rng.uniform(0.25, 0.4),
        shift_s=rng.uniform(-2, 5), lag_s=lag, light=bool(number % 2), seed=number,
        k2=rng.normal(0, plane.POLICY.k2), event=rng.uniform(),
        centre=tuple(rng.normal(0, plane.POLICY.centre, 2)),
        turned_deg=tuple(rng.normal(0, plane.POLICY.plane_deg, 2)),
        extra={"tag_mm": 8.0, "target": (12.0 if sheet else 0.0, 97.0 if sheet else 40.0, 0.0)},
    )  # fmt: skip
    if number < MARKED:
        return drawn
    front = 10.5 + drawn.in_front_mm / 2  # the sheet is behind the finger's far side
    return replace(drawn, finger="uneven", marks="none", fingers=1, count=5, in_front_mm=front)


@cache
def simulated() -> Family:
    """Shapes of the finger as its configuration has it, without what a video hides."""
    return family.simulate(load(overrides=SMALL), lambda done, total: None)


def asked(own: Scene, truth: dict[str, np.ndarray]) -> TrackAsked:
    """Options that a person would give: lengths and places as they are measured."""
    rng = np.random.default_rng(own.seed + 10_000)
    told: dict[str, Any] = {
        "in_front_mm": own.in_front_mm + rng.normal(0, scale.FRONT_STD_MM[0]),
        "fingers": own.fingers,
        "light_px": truth["light_px"] if own.light else None,
    }
    if own.marks == "none":
        told |= {"family": simulated(), "count": own.count}
    elif own.marks == "tags":
        told["tags"] = "4x4"
    else:
        told["count"] = own.count * own.fingers
    if not own.sheet:
        ends = np.round(truth["scale_px"] + rng.normal(0, 0.5, (2, 2)))
        told["scales"] = [Length.pointed_at(ends, LENGTH_MM)]
        told["clamp_px"] = truth["clamp_px"]
        if own.marks == "none":
            told["clamp_px"] = np.round(told["clamp_px"] + rng.normal(0, 0.5, 2))
    return TrackAsked(**told)
