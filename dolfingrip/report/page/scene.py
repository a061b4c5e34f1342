"""A 3D scene of a page: parts with their places at each step, packed for the viewer.

Places are in mm, z points upwards. A finger hangs from its clamp and bends to the right.

Numbers are packed as 16 bits, differences, byte planes, deflate, base64; ``web/src/packed.js``
unpacks them. A surface of 15,000 triangles in 11 states takes 0.5 MB.
"""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from dolfingrip.channels import FIELDS
from dolfingrip.charts.theme import colour_map
from dolfingrip.report.page.content import plain
from dolfingrip.report.scene import View, split_at_creases
from dolfingrip.report.skin import Skin

LEVELS: Final = 65535
"""Steps of a quantised number: 90 mm are told to 0.7 µm."""


COARSE: Final = 51
"""Steps between the values of a field that is shown by colours, which then packs well."""


def quantised(
    values: npt.NDArray[np.float64], low: npt.ArrayLike, high: npt.ArrayLike, step: int = 1
) -> npt.NDArray[np.uint16]:
    """Return values as 16-bit steps between two ends, which they do not leave.

    Args:
        values: shape (…, axes), or any with ends that are numbers.
        low, high: the ends.
        step: distance of the steps that are taken; it divides :data:`LEVELS`.
    """
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    span = np.where(high > low, high - low, 1.0)
    return (np.round(np.clip((values - low) / span, 0, 1) * (LEVELS // step)) * step).astype("<u2")


def pack_numbers(numbers: npt.NDArray[Any], stride: int = 1) -> dict[str, Any]:
    """Pack unsigned integers.

    Each row becomes its difference from the row before (a step of time), and each number of it the
    difference from the one ``stride`` before (the vertex before). Low bytes come before high ones,
    as they repeat less.

    Args:
        numbers: shape (rows, columns), of 16 or 32 bits.
        stride: 3 for coordinates, whose axes stand side by side.
    """
    rows, columns = numbers.shape
    kind = np.dtype("<u2" if numbers.dtype.itemsize <= 2 else "<u4")
    unsigned = numbers.astype(kind)
    left = unsigned.copy()
    left[1:] -= unsigned[:-1]
    along = left.copy()
    along[:, stride:] -= left[:, :-stride]
    flat = along.ravel()
    planes = b"".join(
        ((flat >> (8 * plane)) & 255).astype(np.uint8).tobytes() for plane in range(kind.itemsize)
    )
    return {
        "bytes": kind.itemsize,
        "rows": rows,
        "columns": columns,
        "stride": stride,
        "data": base64.b64encode(zlib.compress(planes, 9)).decode("ascii"),
    }


def pack_indices(indices: npt.NDArray[np.int64], count: int) -> dict[str, Any]:
    """Pack the corners of triangles or the ends of segments, shape (items, corners).

    Args:
        indices: numbers of vertices.
        count: number of vertices.
    """
    kind = "<u2" if count <= LEVELS else "<u4"
    corners = indices.shape[1]
    return pack_numbers(np.ascontiguousarray(indices).reshape(1, -1).astype(kind), corners)


Floats = npt.NDArray[np.float64]

UPRIGHT: Final = np.array([-1.0, 1.0, -1.0])
"""Turns a finger, whose clamp is at the lowest z, by half a turn about y."""

FINGER_VIEW: Final = View()
GRIPPER_VIEW: Final = View(azimuth_deg=35.0, elevation_deg=14.0, up=1.0)


@dataclass(frozen=True, slots=True)
class ScenePart:
    """A surface of a scene.

    Attributes:
        name: said beside the pointer.
        skin: its triangles and lines, on the points of the frames.
        frames: places in mm, shape (1 + steps, points, 3): unloaded, then each step; shape
            (1, points, 3) if it never moves.
        colour: of a part without field, as Matplotlib knows it; "" if it has the field's colours.
        fields: values at each step, shape (steps, points), by the names of fields; without the
            displacement it is the distance from the unloaded place.
        mirrored: whether its mirror image in y = 0 is drawn, too.
        section: whether it is the section y = 0, drawn in place of the mirror image.
        cut: whether it can be cut open at y = 0, without its half y < 0.
    """

    name: str
    skin: Skin
    frames: Floats
    colour: str = ""
    fields: Mapping[str, Floats] = field(default_factory=dict)
    mirrored: bool = False
    section: bool = False
    cut: bool = False


@dataclass(frozen=True, slots=True)
class Load:
    """The steps that the slider of a scene goes through.

    Attributes:
        label: with its unit.
        unit: as printed.
        values: shape (steps,).
        branches: name of the branch of each step, if there are several; "" else.
        rows: row of the result that each step is, shape (steps,).
    """

    label: str
    unit: str
    values: Floats
    branches: Sequence[str]
    rows: npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Scene:
    """Parts at the steps of a load.

    Attributes:
        title: of the result.
        alt: what is seen, in words.
        kind: the experiment's name; scenes of one kind are shown side by side at first.
        towards: direction from the model to the eye.
        solved: whether its steps were solved; else they are interpolated between solutions.
        axes: 1 or -1 for each axis of the model, which the scene shows along or against its own.
    """

    title: str
    alt: str
    kind: str
    parts: Sequence[ScenePart]
    load: Load
    towards: Floats
    solved: bool = True
    axes: Floats = field(default_factory=UPRIGHT.copy)

    def packed(self) -> dict[str, Any]:
        """The scene as ``web/src/packed.js`` reads it."""
        names = dict.fromkeys(name for part in self.parts for name in part.fields)
        ends = {}
        for name in names:
            arrays = [part.fields[name] for part in self.parts if name in part.fields]
            ends[name] = [f(float(getattr(v, f.__name__)()) for v in arrays) for f in (min, max)]
        steps = len(self.load.values)
        values = self.load.values
        scene: dict[str, Any] = plain(
            {
                "title": self.title,
                "alt": self.alt,
                "kind": self.kind,
                "steps": steps,
                "solved": self.solved,
                "view": self.towards,
                "axes": self.axes,
                "fields": ends,
                "control": {
                    "label": self.load.label,
                    "unit": self.load.unit,
                    "values": values,
                    "branches": list(self.load.branches),
                    "rows": self.load.rows,
                    "monotone": bool((np.diff(values) > 0).all()),
                },
            }
        )
        return {**scene, "parts": [_packed(part, ends) for part in self.parts]}


def towards(view: View) -> Floats:
    """Return the direction to the eye of a view of the pictures.

    Args:
        view: of a picture.

    Returns:
        (3,) unit vector in the coordinates of a scene.
    """
    direction: Floats = view.axes[2]
    return direction * UPRIGHT if view.up < 0 else direction


def shown_fields() -> dict[str, dict[str, Any]]:
    """Title, unit and lowest value of each field, and its colours from low to high.

    Returns:
        By the fields' names; colours are 256 times red, green, blue.
    """
    ramp = np.linspace(0, 1, 256)
    return {
        name: {
            "label": field.title, "unit": field.unit, "least": field.least,
            "rgb": np.round(255 * colour_map(name)(ramp)[:, :3]).astype(int).ravel().tolist(),
        }
        for name, field in FIELDS.items()
    }  # fmt: skip


def _packed(part: ScenePart, ends: Mapping[str, list[float]]) -> dict[str, Any]:
    skin = part.skin
    source, triangles = split_at_creases(skin)
    first = np.full(len(skin.points), 0, dtype=np.int64)
    first[source[::-1]] = np.arange(len(source))[::-1]  # lines need one of the points at a crease
    frames = part.frames[:, source]
    low, high = frames.min(axis=(0, 1)), frames.max(axis=(0, 1))
    steps = quantised(frames, low, high)
    count = len(source)
    packed: dict[str, Any] = plain(
        {
            "name": part.name,
            "colour": list(to_rgb(part.colour)) if part.colour else None,
            "mirrored": part.mirrored,
            "section": part.section,
            "cut": part.cut,
            "vertices": count,
            "frames": len(frames),
        }
    )
    packed["low"], packed["high"] = low.tolist(), high.tolist()
    packed["triangles"] = pack_indices(triangles, count)
    packed["lines"] = pack_indices(first[skin.edges], count)
    packed["creases"] = pack_indices(first[skin.creases], count)
    packed["positions"] = pack_numbers(steps.reshape(len(frames), -1), 3)
    packed["fields"] = {
        name: pack_numbers(quantised(values[:, source], ends[name][0], ends[name][1], COARSE))
        for name, values in part.fields.items()
    }
    return packed
