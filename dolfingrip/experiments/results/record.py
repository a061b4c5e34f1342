"""``run.json``: everything that is needed to repeat a run and to judge it."""

from __future__ import annotations

import json
import os
import platform
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import basix
import dolfinx
import petsc4py

import dolfingrip
from dolfingrip.config import Config
from dolfingrip.files import whole

PACKAGES = ("fenics-ffcx", "fenics-ufl", "ipctk", "meshio", "numpy", "scipy")


def versions() -> dict[str, str]:
    """Versions of the software that a run depends on."""
    import gmsh  # slow to load; a mesh of hexahedra does not need it

    found = {
        "dolfingrip": dolfingrip.__version__,
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "basix": basix.__version__,
        "petsc4py": petsc4py.__version__,
        "gmsh": gmsh.GMSH_API_VERSION,
    }
    for name in PACKAGES:
        try:
            found[name.removeprefix("fenics-")] = metadata.version(name)
        except metadata.PackageNotFoundError:  # a Debian package without metadata
            found[name.removeprefix("fenics-")] = "unknown"
    return found


def machine() -> dict[str, Any]:
    """The operating system and the number of processors."""
    return {"system": platform.platform(), "processors": os.cpu_count()}


def write(path: Path, config: Config, facts: dict[str, Any]) -> None:
    """Write ``run.json``.

    Args:
        path: of the file.
        config: resolved configuration; ``dolfingrip … --config run.json`` repeats the run.
        facts: facts about the run, JSON-serialisable.

    Raises:
        WriteError: one line.
    """
    content = {
        "command": sys.argv[1:],
        "config": config.model_dump(mode="json", exclude_none=True),
        **facts,
        "versions": versions(),
        "machine": machine(),
    }
    whole.write(path, json.dumps(content, indent=2) + "\n")
