"""Surfaces of a solid as faces of its cells: a region's plane, regions' interfaces, a group.

A surface is an array of rows of :func:`dolfingrip.meshes.solid.faces`, so it knows the cells on
one of its sides.
"""

from __future__ import annotations

import numpy as np

from dolfingrip.meshes.solid import ON_PLANE, Ints, MeshError, SolidMesh, faces, labels, match


def face_rows(mesh: SolidMesh, cells: Ints) -> Ints:
    """Rows of all faces of these cells, shape (len(cells) · faces,)."""
    count = len(mesh.shape.faces)
    rows: Ints = (cells[:, None] * count + np.arange(count)).ravel()
    return rows


def on_plane(mesh: SolidMesh, cells: Ints, *, highest: bool) -> Ints:
    """Faces of cells in the lowest or highest plane x = const that they reach.

    Args:
        mesh: mesh of the finger.
        cells: rows of the mesh's cells.
        highest: the front, towards +x, instead of the back.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if no face lies in that plane.
    """
    rows = face_rows(mesh, cells)
    corners = mesh.shape.facet_corners
    x = mesh.points[faces(mesh.cells)[rows, :corners], 0]
    level = x.max() if highest else x.min()
    tolerance = ON_PLANE * float(np.ptp(mesh.points, axis=0).max())
    found: Ints = rows[(np.abs(x - level) <= tolerance).all(axis=1)]
    if not len(found):
        raise MeshError(f"no face of an element lies in the plane x = {level:.4g} mm")
    return found


def interface(mesh: SolidMesh, one: Ints, other: Ints) -> Ints:
    """Faces that some cells share with others.

    Args:
        mesh: mesh of the finger.
        one: rows of cells.
        other: rows of other cells.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if they share none.
    """
    every, corners = faces(mesh.cells), mesh.shape.facet_corners
    here, there = face_rows(mesh, np.setdiff1d(one, other)), face_rows(mesh, other)
    label = labels(np.concatenate([every[here, :corners], every[there, :corners]]))
    found: Ints = here[np.isin(label[: len(here)], label[len(here) :])]
    if not len(found):
        raise MeshError("the two regions have no face in common")
    return found


def of_group(mesh: SolidMesh, name: str) -> Ints:
    """Faces of a surface group.

    Args:
        mesh: mesh of the finger.
        name: name of a surface group.

    Returns:
        Rows of :func:`~dolfingrip.meshes.solid.faces`, shape (k,).

    Raises:
        MeshError: if there is no such group.
    """
    if name not in mesh.facets:
        raise MeshError(f"no such group; allowed: {', '.join(mesh.facets)}")
    return match(mesh.facets[name], mesh.cells)
