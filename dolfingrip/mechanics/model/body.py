"""Deformable bodies: each with its mesh, materials and supports, all in one model."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import dolfinx
import numpy as np
from mpi4py import MPI

from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.mechanics.model.parts import ByPart, StrainEnergy
from dolfingrip.meshes.solid import MeshError, SolidMesh

Material = Callable[[dolfinx.mesh.Mesh], Sequence[StrainEnergy]]
"""Makes strain energies, whose constants belong to a mesh."""

WHOLE = ""
"""Name of a body's only region."""


@dataclass(frozen=True)
class DeformableBody:
    """A meshed solid with its materials and supports.

    Attributes:
        name: of the body; no slash.
        solid: its mesh (mm), on rank 0; None elsewhere.
        materials: by region; :data:`WHOLE` is the body where it has one region.
        cells: rows of the mesh's cells by region, on rank 0; not needed for :data:`WHOLE`.
        held: surface groups without displacement along each axis.
    """

    name: str
    solid: SolidMesh | None
    materials: Mapping[str, Material]
    cells: Mapping[str, np.ndarray] = field(default_factory=dict)
    held: Mapping[int, Sequence[str]] = field(default_factory=dict)

    def region(self, name: str) -> str:
        """Name of a region or surface group beside other bodies."""
        return f"{self.name}/{name}" if name else self.name


def assembled(comm: MPI.Comm, bodies: Sequence[DeformableBody]) -> Domain:
    """One distributed domain of all bodies, which share no node.

    A lone body keeps the names of its surface groups; of several a group is named "body/group".
    Parts are named likewise, and there are none where a lone body is of one material. Several
    bodies are no halves: a plane of symmetry is then a group that is held.

    Raises:
        ConfigError: on every rank, where the bodies' elements differ.
    """
    merged = on_root(comm, lambda: _merged(bodies))
    solid, parts = merged if merged is not None else (None, None)
    return distribute(comm, solid, parts)


def _merged(bodies: Sequence[DeformableBody]) -> tuple[SolidMesh, dict[str, np.ndarray]]:
    """The bodies' meshes as one, and the rows of cells of their parts."""
    solids = [body.solid for body in bodies if body.solid is not None]
    assert len(solids) == len(bodies)
    if len({solid.cells.shape[1] for solid in solids}) > 1:
        kinds = ", ".join(
            f"{body.name}: {solid.shape.plural} of order {solid.order}"
            for body, solid in zip(bodies, solids, strict=True)
        )
        raise MeshError(f"bodies: {kinds}; allowed: elements of one shape and order")
    lone = len(bodies) == 1
    facets: dict[str, np.ndarray] = {}
    parts: dict[str, np.ndarray] = {}
    one_part = lone and set(bodies[0].materials) == {WHOLE}
    points = np.concatenate([solid.points for solid in solids])
    cells: list[np.ndarray] = []
    first_node = first_cell = 0
    for body, solid in zip(bodies, solids, strict=True):
        cells.append(solid.cells + first_node)
        for name, found in solid.facets.items():
            facets[name if lone else body.region(name)] = found + first_node
        for name in () if one_part else body.materials:
            rows = np.arange(len(solid.cells)) if name == WHOLE else body.cells[name]
            parts[name if lone else body.region(name)] = rows + first_cell
        first_node += len(solid.points)
        first_cell += len(solid.cells)
    return SolidMesh(points, np.concatenate(cells), facets), parts


def strain_energies(
    domain: Domain, bodies: Sequence[DeformableBody]
) -> Sequence[StrainEnergy] | ByPart:
    """Strain energies of all bodies; regions of the same material share one.

    Args:
        domain: of :func:`assembled`.
        bodies: the same.
    """
    lone = len(bodies) == 1
    regions: dict[Material, list[str]] = {}
    for body in bodies:
        for name, material in body.materials.items():
            regions.setdefault(material, []).append(name if lone else body.region(name))
    if len(regions) == 1:
        (material,) = regions
        return material(domain.mesh)
    return {tuple(names): material(domain.mesh) for material, names in regions.items()}


def held(bodies: Sequence[DeformableBody]) -> dict[int, list[str]]:
    """Regions of the domain without displacement along each axis, of all bodies."""
    lone = len(bodies) == 1
    found: dict[int, list[str]] = {0: [], 1: [], 2: []}
    for body in bodies:
        for axis, groups in body.held.items():
            found[axis] += [name if lone else body.region(name) for name in groups]
    return found
