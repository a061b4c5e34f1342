"""Regions of a finger: cells of other materials, and surfaces with films."""

from __future__ import annotations

import numpy as np

from dolfingrip.config import Config
from dolfingrip.meshes import sheets
from dolfingrip.meshes.solid import MeshError, SolidMesh, faces

REST = "rest"
"""Name of the part that has no material of its own."""


def parts_of(config: Config, mesh: SolidMesh) -> dict[str, np.ndarray]:
    """Rows of the mesh's cells for each part; empty if all cells have one material.

    Args:
        config: materials and films.
        mesh: with the regions that they name.

    Raises:
        MeshError: one line, if the mesh has no such region, or two regions share cells.
    """
    owners = {name: f"material.{name}" for name in config.material.own}
    owners |= {film.region: f"film.{name}.region" for name, film in config.film.layers.items()}
    found: dict[str, np.ndarray] = {}
    taken = np.zeros(len(mesh.cells), dtype=bool)
    for region, key in owners.items():
        rows = _region(mesh, region, key)
        if taken[rows].any():
            raise MeshError(f'{key} = "{region}": shares elements with another region of its own')
        taken[rows] = True
        found[region] = rows
    if found and not taken.all():
        found[REST] = np.flatnonzero(~taken)
    return found


def sheets_of(config: Config, mesh: SolidMesh) -> dict[str, np.ndarray]:
    """Rows of the mesh's faces for each membrane.

    Raises:
        MeshError: one line, if the mesh has no such surface.
    """
    found = {}
    for name, film in config.film.membranes.items():
        key = f"film.{name}"
        try:
            if film.group is not None:
                found[name] = sheets.of_group(mesh, film.group)
            elif film.between is not None:
                one, other = (_region(mesh, region, key) for region in film.between)
                found[name] = sheets.interface(mesh, one, other)
            else:
                cells = np.arange(len(mesh.cells))
                if film.region:
                    cells = _region(mesh, film.region, key)
                found[name] = sheets.on_plane(mesh, cells, highest=film.face == "front")
            if film.fibre_deg:
                _check_fibres(mesh, found[name], np.array(film.fibre_axis))
        except MeshError as error:
            said = str(error)
            raise MeshError(said if said.startswith(key) else f"{key}: {said}") from None
    return found


STEEPEST = 0.02
"""Sine of the angle between a face's normal and the fibres' axis below which it tells no angle."""


def _check_fibres(mesh: SolidMesh, rows: np.ndarray, axis: np.ndarray) -> None:
    """Refuse faces across the axis that fibres' angles are counted from.

    Raises:
        MeshError: one line, if there is such a face.
    """
    corners = mesh.points[faces(mesh.cells)[rows, :3]]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(axis)
    across = np.linalg.norm(np.cross(normals, axis), axis=1) < STEEPEST * lengths
    if across.any():
        shown = [float(each) for each in axis]
        raise MeshError(
            f"fibre_axis = {shown}: {int(across.sum())} of {len(rows)} faces are normal to it, "
            "where fibre_deg has no meaning; allowed: an axis that no face is normal to"
        )


def _region(mesh: SolidMesh, region: str, key: str) -> np.ndarray:
    if region not in mesh.regions:
        allowed = ", ".join(mesh.regions) or "none in this mesh"
        raise MeshError(f'{key} = "{region}": no such region; allowed: {allowed}')
    return mesh.regions[region]
