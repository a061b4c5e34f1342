"""Pictures, curves and tables of results; nothing here computes mechanics."""

from __future__ import annotations

import os
import sys
from typing import TYPE_CHECKING

from dolfingrip import loading

if TYPE_CHECKING:
    from dolfingrip.report import render

__all__ = ["render"]

# Pictures with no X server; naming EGL keeps VTK from trying one first, and from complaining.
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
if sys.platform == "linux":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

__getattr__, __dir__ = loading.lazily(__name__, {"render": "render"})
