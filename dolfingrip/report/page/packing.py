"""Numbers packed for a page: 16 bits, differences, byte planes, deflate, base64.

``web/src/packed.js`` unpacks them. A surface of 15,000 triangles in 11 states takes 0.5 MB.

>>> packed = pack_numbers(np.array([[5, 6, 8], [5, 7, 9]], dtype="<u2"))
>>> unpack_numbers(packed)
array([[5, 6, 8],
       [5, 7, 9]], dtype=uint16)
"""

from __future__ import annotations

import base64
import zlib
from typing import Any, Final

import numpy as np
import numpy.typing as npt

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
    whole = numbers.astype(kind)
    left = whole.copy()
    left[1:] -= whole[:-1]
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


def unpack_numbers(packed: dict[str, Any]) -> npt.NDArray[Any]:
    """Return the numbers, shape (rows, columns), that :func:`pack_numbers` packed."""
    size, shape, stride = packed["bytes"], (packed["rows"], packed["columns"]), packed["stride"]
    raw = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), dtype=np.uint8)
    kind = np.dtype(f"<u{size}")
    found = np.zeros(shape[0] * shape[1], dtype=kind)
    for plane, part in enumerate(raw.reshape(size, -1)):
        found |= part.astype(kind) << (8 * plane)
    found = found.reshape(shape)
    for start in range(stride):
        found[:, start::stride] = np.cumsum(found[:, start::stride], axis=1, dtype=kind)
    return np.cumsum(found, axis=0, dtype=kind)


def pack_indices(indices: npt.NDArray[np.int64], count: int) -> dict[str, Any]:
    """Pack the corners of triangles or the ends of segments, shape (items, corners).

    Args:
        indices: numbers of vertices.
        count: number of vertices.
    """
    kind = "<u2" if count <= LEVELS else "<u4"
    corners = indices.shape[1]
    return pack_numbers(np.ascontiguousarray(indices).reshape(1, -1).astype(kind), corners)
