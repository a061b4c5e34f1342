"""The two files of a tracked finger in the format of measured data, and its errors beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomlkit

from dolfingrip.channels import CHORD_ANGLE, PRESSURE, TIME
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import measurement
from dolfingrip.files import table, whole
from dolfingrip.tracking.body import Body

MOST_ROWS: Final = 400
"""Rows of a table at most; frames between are left out, as a motion is far slower than a video."""


@dataclass(frozen=True)
class Specimen:
    """A finger as it goes into a table.

    Attributes:
        name: of the specimen.
        body: its readings.
        side_mm: y of its side with the points, for the chord's ends.
    """

    name: str
    body: Body
    side_mm: float


def write(
    specimens: Sequence[Specimen],
    frames: Sequence[str],
    time_s: np.ndarray,
    control: Mapping[str, np.ndarray],
    told: Sequence[str],
    out: Path,
    config: Config,
) -> list[Path]:
    """Write a CSV and a TOML for each finger, and ``errors.csv`` with the errors of every frame.

    Args:
        specimens: the fingers.
        frames: names of the frames.
        time_s: (frames,) by the video's clock; NaN of pictures.
        control: (frames,) by column, as the pressure; NaN where the log has none.
        told: sentences on what was found, which the TOML has as comments.
        out: folder.
        config: that the set-up differs from.

    Returns:
        The CSV files, which ``diagnose`` reads.

    Raises:
        ConfigError: one line, if ``diagnose`` could not read them.
    """
    written = []
    for specimen in specimens:
        body = specimen.body
        columns = {name: each for name, each in body.readings.items() if np.isfinite(each).any()}
        if not body.from_clamp:  # its ends have no places on the finger
            columns.pop(CHORD_ANGLE.name, None)
        rows = _rows(columns, time_s, control)
        csv = out / f"{specimen.name}.csv"
        names = [*control, *columns]
        if np.isfinite(time_s).all():
            names = [TIME.name, *names]
        text = [{name: _text(row[name]) for name in names} for row in rows]
        header = dict(zip(names, names, strict=True))
        whole.write_together({
            csv: table.lines([header, *text], names),
            csv.with_suffix(".toml"): tomlkit.dumps(_setup(specimen, columns, told)),
        })  # fmt: skip
        errors = [
            {
                "frame": frames[i],
                **{f"{name}": _text(each[i]) for name, each in columns.items()},
                **{f"noise_{name}": _text(body.noise[name][i]) for name in columns},
                **{f"common_{name}": _text(body.common[name][i]) for name in columns},
            }
            for i in range(len(frames))
        ]
        table.write(out / f"{specimen.name}_errors.csv", errors)
        if PRESSURE.name in control:
            measurement.read([csv], config)
        written.append(csv)
    return written


def _rows(
    columns: Mapping[str, np.ndarray], time_s: np.ndarray, control: Mapping[str, np.ndarray]
) -> list[dict[str, float]]:
    """The frames that have a control and any reading, as many as a table takes."""
    every = {TIME.name: time_s, **control, **columns}
    there = np.isfinite(np.array(list(control.values()))).all(axis=0)
    there &= np.isfinite(np.array(list(columns.values()))).any(axis=0)
    kept = np.flatnonzero(there)
    kept = kept[:: -(-len(kept) // MOST_ROWS) or 1]
    return [{name: float(each[i]) for name, each in every.items()} for i in kept]


def _text(value: float) -> str:
    return f"{value + 0.0:.6g}" if np.isfinite(value) else ""


def _setup(specimen: Specimen, columns: Mapping[str, Any], told: Sequence[str]) -> Any:
    body = specimen.body
    document = tomlkit.document()
    for text in (
        *told,
        *(f"{name}: {what}" for name, what in body.defined.items() if name in columns),
    ):
        document.add(tomlkit.comment(" ".join(text.split())))
    document.add("experiment", "bending")
    camera = tomlkit.table()
    if body.from_clamp:
        rest = [[round(float(x), 3), round(float(z), 3)] for x, z in body.rest_mm]
        camera.add("markers", rest)
        camera.add("chord", "points")
        for key, (x, z) in (("from_mm", rest[0]), ("to_mm", rest[-1])):
            camera.add(key, [x, specimen.side_mm, z])
        document.add("camera", camera)
    noise, drifting = tomlkit.table(), tomlkit.table()
    for name in columns:
        noise.add(name, _rms(body.noise[name]))
        drifting.add(name, _rms(body.common[name]))
    drifting.comment("what all frames have in common: scale, tilt, lens, zero")
    noise.add("correlated", drifting)
    document.add("noise", noise)
    return document


def _rms(values: np.ndarray) -> float:
    return float(f"{max(np.sqrt(np.nanmean(values**2)), 1e-4):.3g}")
