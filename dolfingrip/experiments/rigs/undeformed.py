"""The reference (undeformed) configuration: a mesh from dimensions or from a file, on all ranks."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import NamedTuple

from mpi4py import MPI

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.regions import parts_of, sheets_of
from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.meshes import copies
from dolfingrip.meshes.morph import Morph, morphed
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import Ints, SolidMesh
from dolfingrip.meshes.structured import structured_mesh

log = logging.getLogger(__name__)


def morph(config: Config) -> Morph:
    """The morph that ``config`` asks for."""
    return Morph(config.morph.xi1, config.morph.xi2, config.morph.d_mm)


def solid(config: Config) -> SolidMesh:
    """The checked and morphed mesh that ``config`` asks for, on the calling rank.

    Raises:
        MeshError: one line, if it cannot be made, read or used.
    """
    config = config.adapted()
    # Gmsh and meshio take a fifth of a second to load, so only their users load them
    if config.mesh.file is not None:
        from dolfingrip.meshes import files

        mesh = files.read(config.mesh.file)
    elif config.hexahedra:
        mesh = structured_mesh(config.geometry, config.mesh)
    else:
        from dolfingrip.meshes.generate import finger_mesh

        mesh = finger_mesh(config.geometry, config.mesh)
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


def made(config: Config) -> Made:
    """The mesh of ``config``, the cells of its parts and the faces of its membranes.

    Raises:
        MeshError: one line, if one of them cannot be made.
    """
    mesh = solid(config)
    return Made(mesh, parts_of(config, mesh), sheets_of(config, mesh))


def side_by_side(each: Sequence[Made]) -> Made:
    """Several solids in one mesh, by :func:`dolfingrip.meshes.copies.side_by_side`."""
    solids = [one.solid for one in each]
    cells = [len(one.cells) for one in solids]
    faces = [count * len(solids[0].shape.faces) for count in cells]
    return Made(
        copies.side_by_side(solids),
        copies.all_rows([one.parts for one in each], cells),
        copies.all_rows([one.sheets for one in each], faces),
    )


def spread(comm: MPI.Comm, make: Callable[[], Made]) -> Domain:
    """Distribute a mesh that rank 0 makes.

    Raises:
        ConfigError: on every rank.
    """
    return distribute(comm, *(on_root(comm, make) or (None, None, None)))


def load_domain(config: Config, comm: MPI.Comm) -> Domain:
    """The mesh of ``config``, made on rank 0 and distributed.

    Raises:
        ConfigError: on every rank.
    """
    config = config.adapted()
    domain = spread(comm, lambda: made(config))
    sideways = config.sideways()
    if domain.half and sideways is not None:
        key, value = sideways
        raise ConfigError(f"{key} = {value}: allowed: no y-part for a half finger")
    return domain
