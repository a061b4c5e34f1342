"""A design as a closed solid in a file: STL or 3MF of its mesh, STEP of its boxes; its mould."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final
from zipfile import ZIP_DEFLATED, ZipFile

import gmsh
import numpy as np

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.undeformed import morph, solid
from dolfingrip.files import whole
from dolfingrip.meshes.adoption.facets import outward, triangulated
from dolfingrip.meshes.adoption.sound import SizePolicy, Thinnest, check_watertight, place, thinnest
from dolfingrip.meshes.adoption.surface import Faces
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.dimensions import own
from dolfingrip.meshes.gmsh_model import Solids, session, volume_mm3
from dolfingrip.meshes.inlet import with_inlets
from dolfingrip.meshes.mould import add_mould
from dolfingrip.meshes.solid_model import add_finger, add_solid
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.skin import Floats, Ints, extract_skin
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.geometry.boxes import Box, BoxSolid, CylinderSolid
from dolfingrip.sections.geometry.index import GEOMETRIES
from dolfingrip.sections.making import LEAST_WALL_MM

STL: Final = (".stl",)
STEP: Final = (".step", ".stp")
MF3: Final = (".3mf",)
FORMATS: Final = (*STL, *MF3, *STEP)

_STL_HEAD, _STL_TRIANGLE = 84, 50
"""Bytes of a binary STL's head, and of each triangle."""

_ENDS = whole.ends_with(b"END-ISO-10303-21;")

_OPTIONS: Final = {"Mesh.MeshSizeFromCurvature": 32.0, "Mesh.MeshSizeMin": 0.3}
"""Triangles around a full turn of a round face, and the size (mm) of the smallest ones."""

_EVERY_WALL: Final = SizePolicy(thin=0.0)


@dataclass(frozen=True, slots=True)
class Printed:
    """A solid that was written.

    Attributes:
        volume_mm3: its volume.
        voids: hollows in it that have no opening.
        wall: its thinnest wall; None where that was not measured.
    """

    volume_mm3: float
    voids: int
    wall: Thinnest | None = None

    def summary(self) -> str:
        """Say what a user has to know before it is printed."""
        text = f"closed, {self.volume_mm3 / 1000:.4g} cm³"
        if self.wall is not None:
            text += f", every wall at least {self.wall.mm:.3g} mm"
        if self.voids:
            text += f", {self.voids} sealed void{'s' * (self.voids > 1)}: [inlet] lets air in"
        return text


@dataclass(frozen=True, slots=True)
class Mouldings:
    """A mould that was written, and the silicone that fills it.

    Attributes:
        parts: each part's file, and what it is.
        body_mm3: between the halves and the cores.
        base_mm3: in the tray, with the layer in it that does not stretch.
    """

    parts: dict[Path, Printed]
    body_mm3: float
    base_mm3: float


def write(config: Config, file: Path) -> Printed:
    """Write the whole unloaded design, with the air inlet that is asked for.

    Coordinates are in mm: the clamp at z = 0, the tip at the largest z, the contact face at x = 0.

    Args:
        config: of the design; regions of several materials become one solid, and films are left
            out.
        file: its suffix says the format.

    Raises:
        ConfigError: one line, if the design cannot be meshed, is not closed, has no STEP, or no
            place for its inlet.
        WriteError: one line.
    """
    suffix = file.suffix.lower()
    if suffix not in FORMATS:
        raise ConfigError(f"{file}: allowed: {', '.join(FORMATS)}")
    write_skin = write_3mf if suffix in MF3 else write_stl
    if suffix not in STEP and config.inlet is None:
        shell = surface(config)
        write_skin(shell.points, shell.triangles, file)
        return Printed(
            shell.volume_mm3,
            _voids(Faces(shell.points, shell.triangles, np.zeros(len(shell.triangles), np.int64))),
        )
    shape, adapted = _drawn(config, suffix if config.inlet is None else "inlet"), config.adapted()
    with session(f"{file}", _OPTIONS):
        if own(adapted.geometry) is None:
            body: Solids = [(3, add_solid(shape, half=False))]
        else:  # a morph keeps planes x = const planes
            body = [(3, add_finger(adapted.geometry, False, morph(adapted).points))]
        if config.inlet is not None:
            body = with_inlets(body, shape, config.inlet)
            gmsh.model.occ.synchronize()
        skin = _skin(body)
        volume, voids = volume_mm3(body), _voids(skin)
        if suffix not in STEP:
            write_skin(skin.points, skin.triangles, file)
        else:
            gmsh.model.mesh.clear()
            with whole.replacing(file, check=_ENDS) as (partial,), _silent():
                gmsh.write(str(partial))
    return Printed(volume, voids, None if config.inlet is None else thinnest(skin, _EVERY_WALL))


def write_mould(config: Config, folder: Path) -> Mouldings:
    """Write the parts of a cast design's mould as STL, in the design's coordinates.

    Args:
        config: of the design.
        folder: of the files.

    Raises:
        ConfigError: one line, if the design is not cast, or a part would have a wall that is too
            thin to be printed; nothing is written then.
        WriteError: one line.
    """
    if not config.geometry.cast:
        kinds = ", ".join(name for name, kind in GEOMETRIES.items() if kind.cast)
        raise ConfigError(
            f'finger.kind = "{config.finger.kind}": not cast; allowed with --mould: {kinds}'
        )
    shape = _drawn(config, "--mould")
    assert isinstance(shape, BoxSolid)  # cast kinds are made of boxes
    skins, parts = {}, {}
    with session(f"{folder}", _OPTIONS):
        made = add_mould(shape, config.mould)
        for name, solids in made.parts.items():
            skin, file = _skin(solids), folder / f"{name}.stl"
            wall = thinnest(skin, _EVERY_WALL)
            if wall.mm < LEAST_WALL_MM:
                raise ConfigError(
                    f"--mould: {file.name} would have a wall of {wall.mm:.3g} mm near "
                    f"{place(wall.at_mm)}; allowed: at least {LEAST_WALL_MM} mm, by wider gaps or "
                    "chambers, or a smaller mould.draft_deg"
                )
            skins[file], parts[file] = skin, Printed(volume_mm3(solids), _voids(skin), wall)
        volumes = volume_mm3(made.body), volume_mm3(made.base)
    for file, skin in skins.items():
        write_stl(skin.points, skin.triangles, file)
    return Mouldings(parts, *volumes)


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


_TYPES: Final = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_PARTS: Final = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="rel0"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
_MODEL: Final = """<?xml version="1.0" encoding="UTF-8"?>
<model unit="millimeter" xml:lang="en-US"
 xmlns="http://schemas.microsoft.com/3dmanufacturing/core/2015/02">
<resources><object id="1" type="model"><mesh>
<vertices>{vertices}</vertices>
<triangles>{triangles}</triangles>
</mesh></object></resources>
<build><item objectid="1"/></build>
</model>
"""


def write_3mf(points: Floats, triangles: Ints, file: Path) -> None:
    """Write triangles as a 3MF file of one object.

    Source: 3MF Core Specification 1.3, chapters 2 to 4.

    Args:
        points: corners in mm, shape (n, 3).
        triangles: rows of ``points``, shape (m, 3), counter-clockwise seen from outside.
        file: target; an existing file is replaced.

    Raises:
        WriteError: one line.
    """
    vertices = "\n".join(f'<vertex x="{x:.7g}" y="{y:.7g}" z="{z:.7g}"/>' for x, y, z in points)
    rows = "\n".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in triangles)
    with whole.stream(file) as memory, ZipFile(memory, "w", ZIP_DEFLATED) as packed:
        packed.writestr("[Content_Types].xml", _TYPES)
        packed.writestr("_rels/.rels", _PARTS)
        packed.writestr("3D/3dmodel.model", _MODEL.format(vertices=vertices, triangles=rows))


def surface(config: Config) -> ClosedSurface:
    """The closed surface of the whole design, from its mesh.

    Raises:
        ConfigError: one line, if it cannot be meshed or is not closed.
    """
    mesh = solid(config)
    skin = extract_skin(FieldMesh(mesh.points, mesh.cells, np.arange(len(mesh.points))))
    check_watertight(skin.points, skin.triangles)
    return ClosedSurface(skin.points, skin.triangles)


def _drawn(config: Config, wanted: str) -> BoxSolid | CylinderSolid:
    """The solid of a design as OpenCASCADE draws it, with no channel through the clamped face.

    Raises:
        ConfigError: one line, naming what is ``wanted``, if it is not made of boxes.
    """
    adapted = config.adapted()
    without = ", ".join((*STL, *MF3)) + (" without [inlet]" if config.inlet else "")
    if adapted.mesh.file is not None:
        raise ConfigError(f"{wanted}: a mesh file has no boxes; allowed: {without}")
    if adapted.form is not None:
        raise ConfigError(
            f"{wanted}: [form] bends this design's faces, which are no boxes' any more; "
            f"allowed: {without}, or a design without [form]"
        )
    if wanted in ("inlet", "--mould") and own(adapted.geometry) is not None:
        table = adapted.geometry_table
        raise ConfigError(f"{wanted}: allowed: without [{table}.override] and [{table}.along]")
    shape = morphed(adapted)
    if isinstance(shape, CylinderSolid) and (adapted.morph.xi1 or adapted.morph.xi2):
        raise ConfigError(f"{wanted}: [morph] flattens this design's cylinders; allowed: {without}")
    if config.inlet is None:
        return shape
    return morphed(adapted.changed(**{adapted.geometry_table: adapted.geometry.sealed}))


def _skin(solids: Solids) -> Faces:
    """The surface of a solid of the current Gmsh model, in triangles seen from outside."""
    gmsh.model.mesh.clear()
    gmsh.model.setVisibility(gmsh.model.getEntities(), 0)
    gmsh.model.setVisibility(solids, 1, recursive=True)
    gmsh.option.setNumber("Mesh.MeshOnlyVisible", 1)
    gmsh.model.mesh.generate(2)
    faces = triangulated([tag for _, tag in gmsh.model.getBoundary(solids, oriented=False)])
    check_watertight(faces.points, faces.triangles)
    return outward(faces)


def _voids(skin: Faces) -> int:
    """The number of hollows without an opening, each a piece of the surface of its own."""
    return int(skin.components().max())


def morphed(config: Config) -> BoxSolid | CylinderSolid:
    """Return the solid of a design; its boxes have the morph, which keeps planes x = const planes.

    Args:
        config: of the design.
    """
    moved = morph(config).moved

    def box(bounds: Box) -> Box:
        low, high = (float(x) for x in moved(np.array(bounds[0])))
        return (low, high), *bounds[1:]

    solid = config.geometry.solid()
    if not isinstance(solid, BoxSolid):
        return solid
    return replace(
        solid,
        body=box(solid.body),
        cavity=[box(hollow) for hollow in solid.cavity],
        gaps=[box(gap) for gap in solid.gaps],
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
