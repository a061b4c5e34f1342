"""Formats of files, and the triangles that they hold."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final
from xml.etree.ElementTree import Element

import numpy as np

from dolfingrip.files import package, xml
from dolfingrip.meshes import vtk_file
from dolfingrip.meshes.solid import Floats, Ints, MeshError
from dolfingrip.sections.units import UNITS_MM

CAD: Final = (".step", ".stp", ".brep", ".iges", ".igs")
SURFACES: Final = (".stl", ".obj", ".ply", ".3mf")
MESHES: Final = (".msh", ".inp", ".vtk", ".vtu")

MERGED: Final = 1e-6
"""Distance, relative to the extent, up to which corners of triangles are one point."""

MOST_PLACED: Final = 10_000
"""Objects that a 3MF file may place."""

TURN: Final = 24
"""Triangles around a full turn of a curved face of CAD."""

_UNITS: Final = {
    "micron": "um", "millimeter": "mm", "centimeter": "cm", "inch": "in", "foot": "ft",
    "meter": "m",
}  # fmt: skip
_CORE: Final = "{http://schemas.microsoft.com/3dmanufacturing/core/2015/02}"
_PATH: Final = "{http://schemas.microsoft.com/3dmanufacturing/production/2015/06}path"
_FIRST: Final = "/3dmodel"
"""End of the type of the relation from a package to the model that is built."""


def triangles_of(path: Path, scale: float) -> tuple[Floats, Ints]:
    """Points (n, 3) in mm and triangles (m, 3) of a file, where equal points are one.

    Args:
        path: STL, OBJ, PLY, 3MF, a CAD file, or a mesh of triangles.
        scale: mm for each unit of length of the file.

    Raises:
        MeshError: one line, if there are none.
    """
    import pyvista as pv

    readers: dict[str, Callable[[Path], Any]] = {".3mf": _of_3mf}
    readers |= dict.fromkeys(CAD, _of_cad)
    try:
        raw = readers.get(path.suffix.lower(), vtk_file.read)(path)
    except MeshError:
        raise
    except (package.PackageError, xml.XmlError) as error:
        raise MeshError(str(error)) from None
    except Exception as error:  # any error of the parser on a broken file
        raise MeshError(f"not readable: {error}; allowed: triangles") from None
    if not isinstance(raw, pv.PolyData):
        raw = raw.extract_surface() if isinstance(raw, pv.UnstructuredGrid) else pv.PolyData()
    if not raw.n_cells:
        raise MeshError("no triangles; allowed: a closed surface of triangles")
    merged = raw.triangulate().clean(
        tolerance=MERGED, lines_to_points=False, polys_to_lines=False, strips_to_polys=False
    )
    triangles = np.asarray(merged.regular_faces, dtype=np.int64)
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    return np.asarray(merged.points, dtype=float) * scale, triangles


def require_bearable(path: Path) -> None:
    """Raise if OpenCASCADE dies of a file, which a process of its own finds out.

    Args:
        path: a CAD file.

    Raises:
        MeshError: one line with the signal.
    """
    tried = (
        "import gmsh, sys; gmsh.initialize(readConfigFiles=False, interruptible=False); "
        "gmsh.option.setNumber('Geometry.OCCImportLabels', 1); "
        "gmsh.model.occ.importShapes(sys.argv[1], highestDimOnly=True)"
    )
    ended = subprocess.run(
        [sys.executable, "-P", "-c", tried, str(path.resolve())],
        stdin=subprocess.DEVNULL, capture_output=True, cwd="/", check=False,
    )  # fmt: skip
    if ended.returncode < 0:  # any error of Gmsh's comes again here, with its sentence
        name = signal.Signals(-ended.returncode).name
        raise MeshError(f"damaged: OpenCASCADE ends by {name} when it reads it")


def _of_cad(path: Path) -> object:
    """Triangles on the faces of a CAD file, in mm."""
    import gmsh
    import pyvista as pv

    from dolfingrip.meshes.gmsh_model import import_shapes, numbered_nodes, session

    require_bearable(path)
    with session(f"{path}"):
        gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", TURN)
        import_shapes(path)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        points, row = numbered_nodes()
        corners = row[gmsh.model.mesh.getElementsByType(2)[1].astype(np.int64)]
        return pv.PolyData.from_regular_faces(points, corners.reshape(-1, 3))


def _of_3mf(path: Path) -> object:
    """All objects that a 3MF file builds, placed, in mm.

    Slicers put each object into a model of its own in the archive, which the first one names.

    Source: 3MF Core Specification 1.3, chapters 3 and 4; 3MF Production Extension 1.1, chapter 4.
    """
    import pyvista as pv

    with package.opened(path) as packed:
        names = [file for file in packed.namelist() if file.lower().endswith((".model", ".rels"))]
        models = {f"/{file}": xml.parse(packed.read(file)) for file in names}
    of_package = models.get("/_rels/.rels", ())
    first = [link.get("Target", "") for link in of_package if link.get("Type", "").endswith(_FIRST)]
    places = [f"/{target.lstrip('/')}" for target in first]
    start = next(file for file in (*places, *models) if file in models and file.endswith(".model"))
    objects = {(n, o.get("id")): o for n, m in models.items() for o in m.iter(f"{_CORE}object")}
    points: list[Floats] = [np.empty((0, 3))]
    triangles: list[Any] = [np.empty((0, 3), dtype=int)]
    placed = 0

    def add(of: str, element: Element, turn: Floats, moved: Floats) -> None:
        nonlocal placed
        placed += 1  # objects of objects may be more than a machine can hold
        if placed > MOST_PLACED:
            raise MeshError(f"more than {MOST_PLACED} objects; allowed: so many")
        its_turn, its_move = _transform(element)
        turn, moved = its_turn @ turn, its_move * units_mm[of] @ turn + moved
        of = element.get(_PATH, of)
        model = objects.get((of, element.get("objectid")))
        if model is None:
            raise MeshError(f"no object {element.get('objectid')} in {of}; allowed: one that is")
        for mesh in model.iter(f"{_CORE}mesh"):
            corners = [[float(v.get(k, "")) for k in "xyz"] for v in mesh.iter(f"{_CORE}vertex")]
            rows = [
                [int(t.get(k, "")) for k in ("v1", "v2", "v3")]
                for t in mesh.iter(f"{_CORE}triangle")
            ]
            triangles.append(np.array(rows) + sum(map(len, points)))
            points.append(np.array(corners) * units_mm[of] @ turn + moved)
        for part in model.iter(f"{_CORE}component"):
            add(of, part, turn, moved)

    units_mm = {
        name: UNITS_MM[_UNITS[model.get("unit", "millimeter")]] for name, model in models.items()
    }
    for item in models[start].iter(f"{_CORE}item"):
        add(start, item, np.eye(3), np.zeros(3))
    return pv.PolyData.from_regular_faces(np.vstack(points), np.vstack(triangles))


def _transform(element: Element) -> tuple[Floats, Floats]:
    """Matrix (3, 3) and vector (3,) that rows of points are turned and then moved by."""
    numbers = element.get("transform")
    if numbers is None:
        return np.eye(3), np.zeros(3)
    matrix = np.array(numbers.split(), dtype=float).reshape(4, 3)
    return matrix[:3], matrix[3]
