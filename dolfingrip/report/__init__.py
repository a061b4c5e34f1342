"""Pictures, curves and tables of results; nothing here computes mechanics."""

import os
import sys

# Pictures with no X server; naming EGL keeps VTK from trying one first, and from complaining.
os.environ.setdefault("PYVISTA_OFF_SCREEN", "true")
if sys.platform == "linux":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
