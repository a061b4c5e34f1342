"""Files of programs that track points: Kinovea, Tracker, DeepLabCut, Motive, and C3D.

Layouts are those that the programs write: Kinovea's KVA and text export, Tracker's TRK and data
file, DeepLabCut's CSV and HDF5, Motive's CSV. A table of another program has a name and an axis in
each header, as in ``tip_x [mm]``.
"""

from __future__ import annotations

import io
import pickle
import re
import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from dolfingrip.files import xml
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.units import UNITS_MM

MOST_BYTES: Final = 200_000_000
_WORDS: Final = {"millimeters": "mm", "centimeters": "cm", "meters": "m", "inches": "in"}
MM: Final = UNITS_MM | {word: UNITS_MM[unit] for word, unit in _WORDS.items()}
"""Millimetres in a unit."""
_AXIS: Final = re.compile(r"(?:pixel)?([xyz]|likelihood)")
_NAMED_AXIS: Final = re.compile(r"(.+?)[ _.:-]+([xyz])\W*(\w*)\W*", re.IGNORECASE)
_TIME: Final = re.compile(r"t|time\W*(s|sec|seconds|ms|)\W*", re.IGNORECASE)


@dataclass(frozen=True)
class PointTable:
    """Points over frames, as another program has them.

    Attributes:
        columns: by (name of a point, ``x``, ``y``, ``z`` or ``likelihood``), one row a frame; the
            index counts frames.
        time_s: (frames,); None: the file does not tell it.
        unit: ``px``, or one of :data:`MM`; "": the file does not tell it.
        upwards: whether y points upwards.
        px_per_mm: of pixels that the program has calibrated; None: it has not.
    """

    columns: pd.DataFrame
    time_s: np.ndarray | None
    unit: str
    upwards: bool = False
    px_per_mm: float | None = None


def read(file: Path) -> PointTable:
    """Read a file by its ending.

    Args:
        file: of one of :data:`READERS`.

    Raises:
        ConfigError: one line, where it has none of the layouts.
    """
    try:
        if (size := file.stat().st_size) > MOST_BYTES:
            raise ValueError(f"{size / 1e6:.0f} MB, and up to {MOST_BYTES / 1e6:.0f} MB are read")
        table = READERS[file.suffix.lower()](file)
        if not len(table.columns.columns):
            raise ValueError("no point has a name and an x")
    except ImportError:  # the command's edge says what to install
        raise
    except Exception as error:  # any error of a parser on a file of another layout
        raise ConfigError(
            f"{file}: points cannot be read ({error or 'another layout'}); allowed: files of "
            "Kinovea (.kva, .txt), Tracker (.trk, data file), DeepLabCut (.csv, .h5), Motive "
            "(.csv), C3D, or a CSV with headers such as tip_x [mm]"
        ) from None
    return table


def _pivot(records: list[Any]) -> pd.DataFrame:
    """Columns from records of name, frame, x and y."""
    long = pd.DataFrame(records, columns=["name", "frame", "x", "y"])
    return long.pivot(index="frame", columns="name", values=["x", "y"]).swaplevel(axis=1)


def _text(file: Path) -> PointTable:
    text = file.read_text(encoding="utf-8-sig")
    if text.startswith("#Kinovea"):
        return _kinovea_text(text)
    lines = [line for line in text.splitlines() if line.strip(" \t,;")]
    separator = max("\t;,", key=lambda sign: sum(line.count(sign) > 1 for line in lines))
    cells = [[cell.strip(' "') for cell in line.split(separator)] for line in lines]
    first = next(i for i, row in enumerate(cells) if re.fullmatch(r"[-+\d.,eE]+", row[0]))
    head, axes = cells[: first - 1], cells[first - 1]
    body = [[cell.replace(",", ".") for cell in row[: len(axes)]] for row in cells[first:]]
    data = pd.DataFrame(body, columns=range(len(axes))).apply(pd.to_numeric, errors="coerce")
    units, of_pixels = {""}, "pixelx" in axes
    head = [row for row in head if len(row) > 1]
    if head and head[0][0] == "Format Version":  # Motive: rows of types, names and more
        units = {head[0][head[0].index("Length Units") + 1].lower()}
        kinds, labels = head[1:3]
        names = [[n if "Marker" in kind else "" for kind, n in zip(kinds, labels, strict=True)]]
    else:  # a row that says the same of all columns names none of them
        names = [pd.Series(row).replace("", None).ffill().fillna("").to_list() for row in head]
        names = [row for row in names if len({*row[1:]} - {""}) > 1 or len(names) == 1]
    columns = {}
    for i, axis in enumerate(axes):
        name = " ".join(row[i] for row in names if i < len(row))
        if name and _AXIS.fullmatch(axis.lower()) and of_pixels == axis.startswith("pixel"):
            columns[name, axis.lower().removeprefix("pixel")] = data[i]
        elif not names and (named := _NAMED_AXIS.fullmatch(axis)):
            columns[named[1], named[2].lower()] = data[i]
            units.add(named[3].lower())
    timed = {i: match for i, axis in enumerate(axes) if (match := _TIME.fullmatch(axis))}
    time_s = None
    for i, match in timed.items():
        time_s = data[i].to_numpy(dtype=float) * (1e-3 if match[1] == "ms" else 1.0)
    unit = "px" if of_pixels or axes[0] == "coords" else max(units)
    return PointTable(pd.DataFrame(columns), time_s, unit, upwards=unit != "px")


def _kinovea_text(text: str) -> PointTable:
    """Blocks of ``T X Y``; the unit of the time is that of the program's settings."""
    records: list[Any] = []
    for number, block in enumerate(re.split(r"\n\s*\n", text.replace("\r", ""))):
        name = re.search(r"^# (.+)$", block, re.MULTILINE)
        for line in block.splitlines():
            if not line.startswith("#") and len(row := line.replace(",", ".").split()) == 3:
                at = sum(float(part) * 60.0**-i for i, part in enumerate(row[0].split(":")))
                records.append((name[1] if name else f"{number}", at, float(row[1]), float(row[2])))
    columns = _pivot(records)
    steps = np.diff(columns.index)
    columns.index = np.r_[0, np.cumsum(np.round(steps / steps.min()))]
    return PointTable(columns, None, "", upwards=True)


def _xml(file: Path) -> PointTable:
    root = xml.parse(file.read_bytes())
    return _kinovea(root) if root.tag == "KinoveaVideoAnalysis" else _tracker(root)


def _kinovea(root: Any) -> PointTable:
    """Tracks in the unit of the calibration; in pixels of the picture where there is none."""
    units = {points.get("UserUnitLength", "px") for points in root.iter("TrackPointList")}
    unit = units.pop() if len(units) == 1 else "px"
    step = float(root.findtext("AverageTimeStampsPerFrame"))
    rate_hz = root.findtext("CaptureFramerate") or root.findtext("UserFramerate")
    records: list[Any] = []
    for number, track in enumerate(root.iter("Track")):
        label = track.find("MainLabel")
        name = track.get("name") or (label.get("Text") if label is not None else f"{number}")
        for point in track.iter("TrackPoint"):
            x, y, stamp = map(float, point.text.split(";")[:3])
            if unit != "px":
                x, y = (float(point.get(f"User{axis}Invariant")) for axis in "XY")
            records.append((name, round(stamp / step), x, y))
    columns = _pivot(records)
    time_s = None if rate_hz is None else columns.index.to_numpy() / float(rate_hz)
    return PointTable(columns, time_s, unit, upwards=unit != "px")


def _tracker(root: Any) -> PointTable:
    """Point masses in pixels of the picture, with the scale of the axes."""

    def values(within: Any, name: str) -> Any:
        return within.iterfind(f".//property[@name='{name}']")

    records: list[Any] = []
    for mass in root.iter("object"):
        if mass.get("class", "").endswith("tracker.PointMass"):
            frames = next(values(mass, "framedata"))
            for frame in frames.iterfind("property"):
                x, y = (float(next(values(frame, axis)).text) for axis in "xy")
                number = int(frame.get("name").strip("[]"))
                records.append((next(values(mass, "name")).text, number, x, y))
    columns = _pivot(records)
    clip = next(values(root, "clipcontrol"), root)
    step_ms = next(values(clip, "delta_t"), None)
    scale = float(next(iter(values(root, "xscale"))).text)  # 1: nothing was calibrated
    unit = next(values(root, "length_unit"), None)
    px_per_mm = scale / MM["m" if unit is None else unit.text] if scale != 1 else None
    time_s = None if step_ms is None else columns.index.to_numpy() * float(step_ms.text) / 1e3
    return PointTable(columns, time_s, "px", px_per_mm=px_per_mm)


class _Plain(pickle.Unpickler):
    """Reads lists of texts, and makes no objects."""

    def find_class(self, module: str, name: str) -> Any:
        raise pickle.UnpicklingError(f"{module}.{name} in a list of names")


def _hdf5(file: Path) -> PointTable:
    """A table of pandas, whose names of columns are a pickled list."""
    import h5py

    with h5py.File(file) as opened:
        group = next(iter(opened.values()))
        names = _Plain(io.BytesIO(bytes(group.attrs["non_index_axes"]))).load()[0][1]
        values = group["table"]["values_block_0"]
    columns = {(" ".join(name[1:-1]), name[-1]): values[:, i] for i, name in enumerate(names)}
    return PointTable(pd.DataFrame(columns), None, "px")


def _c3d(file: Path) -> PointTable:
    import c3d

    with file.open("rb") as stream, warnings.catch_warnings(action="ignore"):
        reader = c3d.Reader(stream)
        frames = np.array([points for _, points, _ in reader.read_frames()])
        unit = reader.get("POINT:UNITS")
        names = [label.strip() for label in reader.point_labels]
    places = np.where(frames[:, :, 3:4] < 0, np.nan, frames[:, :, :3])  # a negative residual: lost
    columns = {
        (name, axis): places[:, i, j]
        for i, name in enumerate(names)
        for j, axis in enumerate("xyz")
    }
    time_s = np.arange(len(frames)) / reader.point_rate
    return PointTable(pd.DataFrame(columns), time_s, unit.string_value.strip() if unit else "")


READERS: Final[Mapping[str, Callable[[Path], PointTable]]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt"), _text),
    **dict.fromkeys((".kva", ".xml", ".trk"), _xml),
    **dict.fromkeys((".h5", ".hdf5"), _hdf5),
    ".c3d": _c3d,
}
"""Readers by the ending of a file."""
