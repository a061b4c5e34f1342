"""The two files of a tracked finger in the format of measured data, and its errors beside."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import tomlkit

from dolfingrip.channels import TIME
from dolfingrip.config import Config
from dolfingrip.diagnosis.data import measurement
from dolfingrip.files import whole
from dolfingrip.tracking.body import Body
from dolfingrip.tracking.errors import SharedErrors, rms, shared
from dolfingrip.tracking.track import Tracked

MOST_ROWS: Final = 400
"""Rows of a table at most; frames between are left out."""

# part of a control's range from which on it steps between two frames
STEP: Final = 0.01


def write(tracked: Tracked, out: Path, config: Config, stem: str) -> list[Path]:
    """Write a CSV and a TOML for each finger, and all its readings with their errors by frame.

    Args:
        tracked: what was found.
        out: folder.
        config: that the set-up differs from.
        stem: name of the table of a single finger.

    Returns:
        The CSV files, which ``diagnose`` reads.

    Raises:
        ConfigError: one line, if ``diagnose`` could not read them.
    """
    written, points = [], tracked.watched.points
    timed = {TIME.name: points.time_s} if np.isfinite(points.time_s).all() else {}
    control = pd.DataFrame({**timed, **tracked.control}, index=range(len(points.names)))
    for i, body in enumerate(tracked.bodies, 1):
        errors_of_all = shared(body, tracked.camera, tracked.clock)
        name = f"{stem}_{i}" if len(tracked.bodies) > 1 else stem
        columns = pd.DataFrame({column: body.readings[column] for column in body.compared})
        rows = pd.concat([control, columns], axis=1).iloc[_kept(control, columns)]
        csv = out / f"{name}.csv"
        whole.write_together({
            csv: _text(rows),
            csv.with_suffix(".toml"): tomlkit.dumps(_setup(body, errors_of_all, tracked.told)),
        })  # fmt: skip
        errors = {f"noise_{column}": values for column, values in body.noise.items()}
        errors |= {f"common_{column}": values for column, values in body.common.items()}
        by_frame = control.assign(**body.readings, **errors)
        by_frame.insert(0, "frame", points.names)
        whole.write(out / f"{name}_frames.csv", _text(by_frame))
        measurement.read([csv], config)
        written.append(csv)
    return written


def _kept(control: pd.DataFrame, columns: pd.DataFrame) -> np.ndarray:
    """Numbers of frames that have a control and any reading, as many as a table takes.

    Half of them stand at equal times, the others at both sides of steps of a control: it is linear
    between two rows, so what is left out of a step would be a ramp, and its end a lag.
    """
    kept = np.flatnonzero(np.isfinite(control).all(axis=1) & np.isfinite(columns).any(axis=1))
    if len(kept) > MOST_ROWS:
        values = control.to_numpy(dtype=float)[kept]
        values = values / np.where(np.ptp(values, axis=0) > 0, np.ptp(values, axis=0), 1.0)
        change = np.abs(np.diff(values, axis=0)).max(axis=1)
        steps = change.argsort()[-MOST_ROWS // 4 :]
        steps = steps[change[steps] > STEP]
        equal = np.arange(0, len(kept), -(-2 * len(kept) // MOST_ROWS))
        kept = kept[np.unique([*equal, *steps, *steps + 1])]
    return kept


def _text(rows: pd.DataFrame) -> str:
    """Lines of a CSV file with a head; 0 has no sign, and what is not finite is left empty."""
    numbers = rows.select_dtypes("number").replace([np.inf, -np.inf], np.nan) + 0.0
    return rows.assign(**numbers).to_csv(index=False, float_format="%.6g", lineterminator="\n")


def _setup(body: Body, errors: SharedErrors, sentences: Sequence[str]) -> Any:
    document = tomlkit.document()
    defined = [f"{name}: {what}" for name, what in body.defined.items() if name in body.compared]
    for text in (*sentences, *defined):
        document.add(tomlkit.comment(" ".join(text.split())))
    document.add("experiment", "bending")
    camera = errors.camera.model_dump(mode="json", exclude_defaults=True)
    if camera:
        document.add("camera", camera)
    noise = {name: _digits(rms(body.single[name])) for name in body.compared}
    left = {name: _digits(errors.left[name]) for name in body.compared}
    if errors.fades_mm is not None:
        left["correlation_length_mm"] = _digits(errors.fades_mm)
    drifting = tomlkit.item(left)
    drifting.comment("what all frames share beside the camera's errors below")
    document.add("noise", {**noise, "correlated": drifting})
    document.add("nuisance", {key: _digits(std) for key, std in errors.stds.items()})
    return document


def _digits(std: float) -> float:
    return float(f"{max(std, 1e-4):.3g}")
