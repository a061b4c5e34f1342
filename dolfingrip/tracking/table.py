"""The two files of a tracked finger in the format of measured data, and its errors beside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import tomlkit

from dolfingrip.channels import PRESSURE, TIME
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import measurement
from dolfingrip.files import table, whole
from dolfingrip.tracking.body import Body

MOST_ROWS: Final = 400
"""Rows of a table at most; frames between are left out, as a motion is far slower than a video."""


def write(
    fingers: Mapping[str, Body],
    frames: Sequence[str],
    time_s: np.ndarray,
    control: Mapping[str, np.ndarray],
    sentences: Sequence[str],
    out: Path,
    config: Config,
) -> list[Path]:
    """Write a CSV and a TOML for each finger, and all its readings with their errors by frame.

    Args:
        fingers: readings by the name of the table.
        frames: names of the frames.
        time_s: (frames,) by the video's clock; NaN of pictures.
        control: (frames,) by column, as the pressure; NaN where the log has none.
        sentences: sentences on what was found, which the TOML has as comments.
        out: folder.
        config: that the set-up differs from.

    Returns:
        The CSV files, which ``diagnose`` reads.

    Raises:
        ConfigError: one line, if ``diagnose`` could not read them.
    """
    written = []
    timed = {TIME.name: time_s} if np.isfinite(time_s).all() else {}
    for name, body in fingers.items():
        columns = {column: body.readings[column] for column in body.compared}
        rows = _rows({**timed, **control}, columns)
        csv = out / f"{name}.csv"
        head = list(rows[0]) if rows else [*timed, *control, *columns]
        whole.write_together({
            csv: table.lines([dict(zip(head, head, strict=True)), *rows], head),
            csv.with_suffix(".toml"): tomlkit.dumps(_setup(body, columns, sentences)),
        })  # fmt: skip
        errors = {f"noise_{column}": values for column, values in body.noise.items()}
        errors |= {f"common_{column}": values for column, values in body.common.items()}
        every = {**timed, **control, **body.readings, **errors}
        by_frame = [
            {"frame": frame, **{column: _text(values[i]) for column, values in every.items()}}
            for i, frame in enumerate(frames)
        ]
        table.write(out / f"{name}_frames.csv", by_frame)
        if PRESSURE.name in control:
            measurement.read([csv], config)
        written.append(csv)
    return written


def _rows(
    control: Mapping[str, np.ndarray], columns: Mapping[str, np.ndarray]
) -> list[dict[str, str]]:
    """The frames that have a control and any reading, as many as a table takes."""
    there = np.isfinite(np.array(list(control.values()))).all(axis=0)
    there &= np.isfinite(np.array(list(columns.values()))).any(axis=0)
    kept = np.flatnonzero(there)
    kept = kept[:: -(-len(kept) // MOST_ROWS) or 1]
    every = {**control, **columns}
    return [{name: _text(values[i]) for name, values in every.items()} for i in kept]


def _text(value: float) -> str:
    return f"{value + 0.0:.6g}" if np.isfinite(value) else ""


def _setup(body: Body, columns: Mapping[str, Any], sentences: Sequence[str]) -> Any:
    document = tomlkit.document()
    for text in (
        *sentences,
        *(f"{name}: {what}" for name, what in body.defined.items() if name in columns),
    ):
        document.add(tomlkit.comment(" ".join(text.split())))
    document.add("experiment", "bending")
    camera = tomlkit.table()
    if body.from_clamp:
        markers = [[round(float(x), 3), round(float(z), 3)] for x, z in body.rest_mm]
        camera.add("markers", markers)
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
