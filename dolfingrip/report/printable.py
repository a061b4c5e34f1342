"""A design as a closed solid in a file: STL of its mesh, or STEP of its boxes."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import morph, solid
from dolfingrip.files import whole
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.skin import Floats, Ints, extract_skin
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.geometry.boxes import Box, BoxSolid, CylinderSolid

STL: Final = (".stl",)
STEP: Final = (".step", ".stp")
FORMATS: Final = (*STL, *STEP)

_STL_HEAD, _STL_TRIANGLE = 84, 50
"""Bytes of a binary STL's head, and of each triangle."""

_ENDS = whole.ends_with(b"END-ISO-10303-21;")

SAME: Final = 1e-6
"""Relative difference of the boxes' volume from the mesh's, up to which both are one shape."""


def write(config: Config, file: Path) -> float:
    """Write the whole unloaded design; its volume in mm³.

    Coordinates are in mm: the clamp at z = 0, the tip at the largest z, the contact face at x = 0.

    Args:
        config: of the design; regions of several materials become one solid, and films are left
            out.
        file: its suffix says the format.

    Raises:
        ConfigError: one line, if the design cannot be meshed, is not closed, or has no STEP.
        WriteError: one line.
    """
    suffix = file.suffix.lower()
    if suffix not in FORMATS:
        raise ConfigError(f"{file}: allowed: {', '.join(FORMATS)}")
    if suffix in STEP:
        return _write_step(config, file)
    found = surface(config)
    write_stl(found.points, found.triangles, file)
    return found.volume_mm3


def write_stl(points: Floats, triangles: Ints, file: Path) -> None:
    """Write triangles as binary STL.

    Args:
        points: corners in mm, shape (n, 3).
        triangles: rows of ``points``, shape (m, 3), counter-clockwise seen from outside.
        file: target; an existing file is replaced.

    Raises:
        WriteError: one line.
    """
    import meshio

    size = _STL_HEAD + _STL_TRIANGLE * len(triangles)
    with whole.replacing(file, check=lambda written: written.stat().st_size == size) as (partial,):
        meshio.write(partial, meshio.Mesh(points, [("triangle", triangles)]), "stl", binary=True)


def surface(config: Config) -> ClosedSurface:
    """The closed surface of the whole design, from its mesh.

    Raises:
        ConfigError: one line, if it cannot be meshed or is not closed.
    """
    from dolfingrip.meshes.adoption.sound import check_watertight

    mesh = solid(config)
    skin = extract_skin(FieldMesh(mesh.points, mesh.cells, np.arange(len(mesh.points))))
    check_watertight(skin.points, skin.triangles)
    return ClosedSurface(skin.points, skin.triangles)


def _write_step(config: Config, file: Path) -> float:
    import gmsh

    from dolfingrip.meshes.gmsh_model import session
    from dolfingrip.meshes.solid_model import add_solid

    adapted = config.adapted()
    if adapted.mesh.file is not None:
        raise ConfigError(f"{file.suffix}: a mesh file has no boxes; allowed: {', '.join(STL)}")
    if adapted.form is not None:
        raise ConfigError(
            f"{file.suffix}: [form] bends this design's faces, which are no boxes' any more; "
            f"allowed: {', '.join(STL)}, or a design without [form]"
        )
    meshed = surface(config).volume_mm3
    with session(f"{file}"):
        tag = add_solid(morphed(adapted), half=False)
        volume = float(gmsh.model.occ.getMass(3, tag))
        if abs(volume - meshed) > SAME * meshed:  # its nodes are moved in ways that boxes are not
            raise ConfigError(
                f"{file.suffix}: this design is not made of boxes; allowed: {', '.join(STL)}"
            )
        with whole.replacing(file, check=_ENDS) as (partial,), _silent():
            gmsh.write(str(partial))
    return volume


def morphed(config: Config) -> BoxSolid | CylinderSolid:
    """Return the solid of a design; its boxes have the morph, which keeps planes x = const planes.

    Args:
        config: of the design.
    """
    moved = morph(config).moved

    def box(each: Box) -> Box:
        low, high = (float(x) for x in moved(np.array(each[0])))
        return (low, high), *each[1:]

    found = config.geometry.solid()
    if not isinstance(found, BoxSolid):
        return found
    return replace(
        found,
        body=box(found.body),
        cavity=[box(each) for each in found.cavity],
        gaps=[box(each) for each in found.gaps],
    )


@contextmanager
def _silent() -> Iterator[None]:
    """Drop what OpenCASCADE itself prints while it writes a STEP file."""
    sys.stdout.flush()
    kept, nowhere = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)
