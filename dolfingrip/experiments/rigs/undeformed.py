"""The reference (undeformed) configuration, on all ranks: a mesh and its regions.

The mesh is made from dimensions or read from a file. Regions are cells of other materials, and
surfaces with films.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config, ConfigError
from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.meshes import dimensions
from dolfingrip.meshes.bisection import divided
from dolfingrip.meshes.free_form import FreeForm, bent
from dolfingrip.meshes.groups import BODY, NEEDED, SYMMETRY
from dolfingrip.meshes.morph import MorphMap, morphed
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import (
    Floats,
    Ints,
    MeshError,
    SolidMesh,
    all_rows,
    assemble,
    faces,
    interface,
    mirrored,
    of_group,
    on_plane,
    second_order,
)
from dolfingrip.meshes.solid import side_by_side as copied
from dolfingrip.meshes.structured import structured_mesh
from dolfingrip.sections.geometry.geometry import Geometry

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
    parts: dict[str, np.ndarray] = {}
    taken = np.zeros(len(mesh.cells), dtype=bool)
    for region, key in owners.items():
        rows = _region(mesh, region, key)
        if taken[rows].any():
            raise MeshError(f'{key} = "{region}": shares elements with another region of its own')
        taken[rows] = True
        parts[region] = rows
    if parts and not taken.all():
        parts[REST] = np.flatnonzero(~taken)
    return parts


def sheets_of(config: Config, mesh: SolidMesh) -> dict[str, np.ndarray]:
    """Rows of the mesh's faces for each membrane.

    Raises:
        MeshError: one line, if the mesh has no such surface.
    """
    sheets = {}
    for name, film in config.film.membranes.items():
        key = f"film.{name}"
        try:
            if film.group is not None:
                sheets[name] = of_group(mesh, film.group)
            elif film.between is not None:
                one, other = (_region(mesh, region, key) for region in film.between)
                sheets[name] = interface(mesh, one, other)
            else:
                cells = np.arange(len(mesh.cells))
                if film.region:
                    cells = _region(mesh, film.region, key)
                sheets[name] = on_plane(mesh, cells, highest=film.face == "front")
            if film.fibre_deg:
                _check_fibres(mesh, sheets[name], np.array(film.fibre_axis))
        except MeshError as error:
            said = str(error)
            raise MeshError(said if said.startswith(key) else f"{key}: {said}") from None
    return sheets


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
        shown = [float(component) for component in axis]
        raise MeshError(
            f"fibre_axis = {shown}: {int(across.sum())} of {len(rows)} faces are normal to it, "
            "where fibre_deg has no meaning; allowed: an axis that no face is normal to"
        )


def _region(mesh: SolidMesh, region: str, key: str) -> np.ndarray:
    if region not in mesh.regions:
        allowed = ", ".join(mesh.regions) or "none in this mesh"
        raise MeshError(f'{key} = "{region}": no such region; allowed: {allowed}')
    return mesh.regions[region]


log = logging.getLogger(__name__)


def morph(config: Config) -> MorphMap:
    """Morph of the finger's mesh.

    Args:
        config: configuration of the finger.

    Returns:
        The morph, in mm.
    """
    return MorphMap(config.morph.xi1, config.morph.xi2, config.morph.d_mm)


def free_form(config: Config) -> FreeForm:
    """The free form that ``config`` asks for, of the planes that its dimensions set."""
    return FreeForm(config.geometry, config.form)


def straight(config: Config, made_for: Geometry | None = None) -> SolidMesh:
    """The mesh of a configuration's dimensions, before free form and morph.

    Args:
        config: adapted.
        made_for: dimensions that the mesh is made for and then moved from, so that its cells are
            the same for all dimensions near these; None: those of ``config``.

    Raises:
        MeshError: one line, if it cannot be made or read.
    """
    # Gmsh and meshio take a fifth of a second to load, so only their users load them
    if config.mesh.file is not None:
        from dolfingrip.meshes import files

        needed = NEEDED if config.geometry.cavities() else BODY
        mesh = files.read(config.mesh.file, needed)
        if SYMMETRY in mesh.facets and not config.mesh.half:
            mesh = mirrored(mesh)
        return divided(mesh, config.mesh.refine)
    geometry = made_for or config.geometry
    if config.hexahedra:
        mesh = structured_mesh(geometry, config.mesh)
    else:
        from dolfingrip.meshes.generate import finger_mesh

        mesh = divided(finger_mesh(geometry, config.mesh), config.mesh.refine)
    if made_for is None:
        return mesh
    return replace(mesh, points=dimensions.moved(mesh.points, made_for, config.geometry))


def placed(points: Floats, config: Config) -> Floats:
    """Points of a straight mesh, moved by the finger's free form and its morph.

    Args:
        points: (n, 3) points of the straight mesh (mm).
        config: configuration of the finger.

    Returns:
        (n, 3) points moved by the free form and the morph (mm).
    """
    config = config.adapted()
    bent_points = points if config.form is None else free_form(config).points(points)
    return morph(config).points(bent_points)


def unplaced(points: Floats, config: Config) -> Floats:
    """The points of the straight mesh that :func:`placed` moves to others.

    Args:
        points: (n, 3) points of the finger (mm).
        config: configuration of the finger.

    Returns:
        (n, 3) points of the straight mesh (mm).
    """
    config = config.adapted()
    straight = morph(config).inverse().points(points)
    return straight if config.form is None else free_form(config).inverse(straight)


def solid(config: Config, made_for: Geometry | None = None) -> SolidMesh:
    """The checked, bent and morphed mesh that ``config`` asks for, on the calling rank.

    Args:
        config: configuration of the finger.
        made_for: see :func:`straight`.

    Raises:
        MeshError: one line, if it cannot be made, read or used.
    """
    config = config.adapted()
    mesh = straight(config, made_for)
    if config.form is not None:
        mesh = bent(mesh, free_form(config))
    mesh = morphed(mesh, morph(config))
    log.info(check(mesh).summary())
    return mesh


class Made(NamedTuple):
    """Arguments of :func:`~dolfingrip.mechanics.model.domain.distribute` on rank 0.

    Attributes:
        solid: the mesh.
        parts: rows of its cells for each part.
        sheets: rows of its cells' faces for each membrane.
    """

    solid: SolidMesh
    parts: dict[str, Ints]
    sheets: dict[str, Ints]


def elements(config: Config, order: int | None = None) -> SolidMesh:
    """The finger in elements of the first or second order, the edges of new nodes straight.

    Args:
        config: of the finger.
        order: of the elements; None: that of the solver's.

    Raises:
        MeshError: one line, if it cannot be meshed.
    """
    mesh = solid(config.changed(mesh={"order": 1}))
    return of_order(mesh, order or (1 if config.solver.element == "P1" else 2))


def of_order(mesh: SolidMesh, order: int) -> SolidMesh:
    """A mesh in elements of an order, the edges of new nodes straight.

    Args:
        mesh: of the first or second order.
        order: of its elements.
    """
    if mesh.order == order:
        return mesh
    if order == 2:
        return second_order(mesh)
    cells = mesh.cells[:, : mesh.shape.corners]
    return assemble(mesh.points, cells, mesh.facets, mesh.regions)


def made(config: Config, made_for: Geometry | None = None) -> Made:
    """The mesh of ``config``, the cells of its parts and the faces of its membranes.

    For ``made_for`` see :func:`straight`.

    Raises:
        MeshError: one line, if one of them cannot be made.
    """
    mesh = solid(config, made_for)
    return Made(mesh, parts_of(config, mesh), sheets_of(config, mesh))


def side_by_side(fingers: Sequence[Made]) -> Made:
    """Several solids as one mesh.

    Args:
        fingers: meshes with their parts and membranes.

    Returns:
        One mesh with the parts and membranes of all; see
        :func:`dolfingrip.meshes.solid.side_by_side`.
    """
    solids = [one.solid for one in fingers]
    cells = [len(one.cells) for one in solids]
    faces = [count * len(solids[0].shape.faces) for count in cells]
    return Made(
        copied(solids),
        all_rows([one.parts for one in fingers], cells),
        all_rows([one.sheets for one in fingers], faces),
    )


def spread(comm: MPI.Comm, make: Callable[[], Made]) -> Domain:
    """Distribute a mesh that rank 0 makes.

    Raises:
        ConfigError: on every rank.
    """
    return distribute(comm, *(on_root(comm, make) or (None, None, None)))


def load_domain(config: Config, comm: MPI.Comm, made_for: Geometry | None = None) -> Domain:
    """The mesh of ``config``, made on rank 0 and distributed.

    For ``made_for`` see :func:`straight`.

    Raises:
        ConfigError: on every rank.
    """
    config = config.adapted()
    domain = spread(comm, lambda: made(config, made_for))
    for uneven in config.uneven() if domain.half else ():
        raise ConfigError(f"{uneven.key} = {config.shown(uneven.key)}: {uneven.allowed}")
    return domain
