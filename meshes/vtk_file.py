"""Files that VTK reads: as data, and without VTK's own messages."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from dolfingrip.files import xml

_OF_XML: Final = (".vtu", ".pvtu")


def read(path: Path) -> Any:
    """Read a file by VTK.

    Args:
        path: the file, whose ending tells its format.

    Returns:
        A data set of pyvista; of a damaged file, one with less than the file has, or nothing.

    Raises:
        XmlError: one line, where XML declares a document type.
        Exception: any of pyvista's, where it has no reader for the file.
    """
    import pyvista as pv
    from vtkmodules.vtkCommonCore import vtkObject

    if path.suffix.lower() in _OF_XML:
        with path.open("rb") as file:
            xml.check_beginning(file)
    shown = vtkObject.GetGlobalWarningDisplay()
    vtkObject.GlobalWarningDisplayOff()
    try:
        return pv.read(path)
    finally:
        vtkObject.SetGlobalWarningDisplay(shown)
