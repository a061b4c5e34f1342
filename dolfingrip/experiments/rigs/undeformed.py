"""The reference (undeformed) configuration: a mesh from dimensions or from a file, on all ranks."""

from __future__ import annotations

import logging

import numpy as np
from mpi4py import MPI

from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.regions import parts_of, sheets_of
from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.meshes.morph import Morph, morphed
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.meshes.structured import structured_mesh

log = logging.getLogger(__name__)


def morph(config: Config) -> Morph:
    """The morph that ``config`` asks for."""
    return Morph(config.morph.xi1, config.morph.xi2, config.morph.d_mm)


def solid(config: Config) -> SolidMesh:
    """The checked and morphed mesh that ``config`` asks for, on the calling rank.

    Raises:
        MeshError: one line, where it cannot be made, read or used.
    """
    config = config.adapted()
    # Gmsh and meshio take a fifth of a second to load: only where they are used
    if config.mesh.file is not None:
        from dolfingrip.meshes import files

        mesh = files.read(config.mesh.file)
    elif config.hexahedra:
        mesh = structured_mesh(config.geometry, config.mesh)
    else:
        from dolfingrip.meshes.generate import finger_mesh

        mesh = finger_mesh(config.finger, config.mesh)
    mesh = morphed(mesh, morph(config))
    log.info(check(mesh).summary())
    return mesh


def load_domain(config: Config, comm: MPI.Comm) -> Domain:
    """The mesh of ``config``, made on rank 0 and distributed.

    Raises:
        ConfigError: on every rank.
    """
    config = config.adapted()
    made = on_root(comm, lambda: _made(config))
    domain = distribute(comm, *(made or (None, None, None)))
    sideways = config.sideways()
    if domain.half and sideways is not None:
        key, value = sideways
        raise ConfigError(f"{key} = {value}: allowed: no y-part for a half finger")
    return domain


def _made(config: Config) -> tuple[SolidMesh, dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The mesh, the cells of its parts and the faces of its membranes."""
    mesh = solid(config)
    return mesh, parts_of(config, mesh), sheets_of(config, mesh)
