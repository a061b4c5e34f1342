"""Options of a tracking: all that a person tells of a video or of pictures."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking.family import Family
from dolfingrip.tracking.plane import Length


@dataclass(frozen=True, kw_only=True)
class TrackAsked:
    """Options that a person tells of a video.

    Attributes:
        colour, count, points_px: of the dots; see :func:`~dolfingrip.tracking.dots.learn`.
        tags: family of tags; None: dots.
        tag_mm: side of a tag.
        family: shapes of a finger without marks; None: dots or tags.
        fingers: number of them.
        scales: known lengths.
        clamp_px: where the clamp holds the back.
        first_mm: distance from there to the first point.
        in_front_mm: distance of the points in front of the sheet or of the scale.
        side: to which the finger bends.
        light_px: where a light is.
        knock: whether a knock shows in both.
        shift_s: time of the log at the first frame.
        states: of the pictures in their order, by the column of a control.
        labels: names of another program's points that are a finger's; none: all.
        clamp_label: the point of them that is where the clamp holds the back.
        unit: of them, ``px`` or a length.
        frame_rate: of them (Hz).
        name: of the table, of a single finger.
    """

    colour: str | None = None
    count: int | None = None
    points_px: np.ndarray | None = None
    tags: str | None = None
    tag_mm: float | None = None
    family: Family | None = None
    fingers: int = 1
    scales: Sequence[Length] = ()
    clamp_px: np.ndarray | None = None
    first_mm: float | None = None
    in_front_mm: float | None = None
    side: str | None = None
    light_px: np.ndarray | None = None
    knock: bool = False
    shift_s: float | None = None
    states: Mapping[str, np.ndarray] = field(default_factory=dict)
    labels: Sequence[str] = ()
    clamp_label: str | None = None
    unit: str | None = None
    frame_rate: float | None = None
    name: str = "track"


def states_of(text: str, names: Sequence[str]) -> list[dict[str, str]]:
    """Read the states of pictures from their names.

    Args:
        text: as ``{pressure_kPa}.jpg``; what stands in braces is a column, and a number in a name.
        names: of the pictures.

    Raises:
        ConfigError: one line, if a name has another form.
    """
    parts = re.split(r"(\{\w+\})", text)
    pattern = "".join(
        rf"(?P<{part[1:-1]}>[+-]?\d+(?:[.,]\d+)?)" if part.startswith("{") else re.escape(part)
        for part in parts
    )
    states = []
    for name in names:
        match = re.fullmatch(pattern, name)
        if match is None or not match.groupdict():
            raise ConfigError(
                f"--states {text}: {name} has another form; allowed: as 40.jpg of "
                "{pressure_kPa}.jpg"
            )
        states.append({key: value.replace(",", ".") for key, value in match.groupdict().items()})
    return states
