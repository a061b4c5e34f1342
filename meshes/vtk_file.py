"""Files that VTK reads: as data, and without VTK's own messages; STL files of any kind."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.files import xml

_OF_XML: Final = (".vtu", ".pvtu")


def read(path: Path) -> Any:
    """Read a file by VTK, or triangles of an STL file.

    Args:
        path: the file, whose ending tells its format.

    Returns:
        A data set of pyvista; of a damaged file, one with less than the file has, or nothing.

    Raises:
        XmlError: one line, where XML declares a document type.
        Exception: any of pyvista's, where it has no reader for the file.
    """
    if path.suffix.lower() == ".stl":
        return _stl(path.read_bytes())
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkLogger, vtkObject

    if path.suffix.lower() in _OF_XML:
        with path.open("rb") as file:
            xml.check_beginning(file)
    shown, logged = vtkObject.GetGlobalWarningDisplay(), vtkLogger.GetCurrentVerbosityCutoff()
    vtkObject.GlobalWarningDisplayOff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return pv.read(path)
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)
        vtkLogger.SetStderrVerbosity(vtkLogger.ConvertToVerbosity(logged))


_TRIANGLE: Final = np.dtype([("normal", "<f4", 3), ("corners", "<f4", 9), ("rest", "<u2")])
"""A triangle of a binary STL file, which begins with 80 bytes of text and a number of triangles."""

_NUMBER: Final = rb"\s+([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)(?!\S)"
_VERTEX: Final = re.compile(rb"\bvertex" + 3 * _NUMBER, re.IGNORECASE)


def _stl(data: bytes) -> Any:
    """Triangles of an STL file; none of a binary one that ends before the last one.

    VTK takes a binary file for text where its header begins with "solid", and reads nothing where
    text follows the last triangle, as that of Gmsh does.
    """
    import pyvista as pv

    count, most = int.from_bytes(data[80:84], "little"), (len(data) - 84) // _TRIANGLE.itemsize
    if 0 < count <= most:  # of a text, these four letters are a number above 5e8
        numbers: Any = np.frombuffer(data, _TRIANGLE, count, 84)["corners"].astype(float).ravel()
    else:
        numbers = np.fromiter((x for v in _VERTEX.finditer(data) for x in v.groups()), float)
    corners = numbers[: len(numbers) // 9 * 9].reshape(-1, 3)
    rows: Any = np.arange(len(corners)).reshape(-1, 3)
    return pv.PolyData.from_regular_faces(corners, rows)
