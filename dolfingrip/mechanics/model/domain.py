"""A meshed solid, distributed over the ranks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem, graph, io, mesh
from mpi4py import MPI

from dolfingrip.meshes.cells import BY_NODES
from dolfingrip.meshes.groups import SURFACE_TAGS, SYMMETRY
from dolfingrip.meshes.solid import MeshError, SolidMesh, assemble
from dolfingrip.sections.complaint import ConfigError


@dataclass(frozen=True, slots=True)
class Domain:
    """Reference configuration (mm).

    Attributes:
        mesh: tetrahedra, straight or quadratic, or hexahedra.
        regions: local boundary facets by name: the mesh's groups and any added region.
        half: the half y ≥ 0 of a symmetric solid.
    """

    mesh: mesh.Mesh
    regions: dict[str, np.ndarray]
    half: bool
    _integration: list[tuple[int, np.ndarray]] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        # UFL wants one and the same subdomain data in all integrals of a form
        data = [
            (tag, _cells_and_local(self.mesh, facets))
            for tag, facets in enumerate(self.regions.values())
        ]
        object.__setattr__(self, "_integration", data)

    @property
    def copies(self) -> int:
        """How often the mesh stands for in the whole solid: 2 for a half."""
        return 2 if self.half else 1

    def facets(self, *names: str) -> np.ndarray:
        """Local indices of the facets in the named regions."""
        return np.unique(np.concatenate([self.regions[name] for name in names]))

    def surface(self, *names: str, **metadata: object) -> ufl.Measure:
        """Surface measure of the named regions, integrated as ``metadata`` says."""
        order = list(self.regions)
        tags = tuple(order.index(name) for name in names)
        return ufl.Measure("ds", self.mesh, subdomain_data=self._integration, metadata=metadata)(
            tags
        )

    def with_region(
        self, name: str, among: Sequence[str], where: Callable[[np.ndarray], np.ndarray]
    ) -> Domain:
        """This domain with one more named part of its boundary.

        Args:
            name: of the new region.
            among: regions it is part of.
            where: (3, n) coordinates in mm to (n,) booleans; a facet belongs to the region
                if all its vertices do.
        """
        chosen = mesh.locate_entities_boundary(self.mesh, 2, where)
        facets = np.intersect1d(chosen, self.facets(*among)).astype(np.int32)
        return Domain(self.mesh, {**self.regions, name: facets}, self.half)


def _cells_and_local(domain: mesh.Mesh, facets: np.ndarray) -> np.ndarray:
    """(cell, local facet) pairs, flattened, of boundary facets."""
    found = fem.compute_integration_domains(
        fem.IntegralType.exterior_facet, domain.topology, facets, 2
    )
    return np.asarray(found, dtype=np.int32)


def on_root[T](comm: MPI.Comm, work: Callable[[], T]) -> T | None:
    """Run ``work`` on rank 0 only; if it fails, every rank raises the same error.

    Returns:
        What ``work`` returned on rank 0, None elsewhere.
    """
    result: T | None = None
    failure: Exception | None = None
    if comm.rank == 0:
        try:
            result = work()
        except Exception as error:  # passed on to all ranks, which would wait for ever
            failure = error
    failure = comm.bcast(failure)
    if failure is not None:
        raise failure
    return result


def distribute(comm: MPI.Comm, solid: SolidMesh | None) -> Domain:
    """Distribute a mesh that rank 0 holds.

    Args:
        comm: communicator of the simulation.
        solid: the mesh on rank 0, None elsewhere.

    Raises:
        ConfigError: on every rank, where the mesh has fewer cells than there are ranks.
    """
    facts = None
    if comm.rank == 0:
        assert solid is not None
        solid = _straight(solid)
        facts = (solid.cells.shape[1], tuple(solid.facets), len(solid.cells))
    nodes, names, number = comm.bcast(facts)
    if number < comm.size:
        raise ConfigError(f"mesh: {number} elements on {comm.size} ranks; allowed: as many or more")
    shape = BY_NODES[nodes]
    order = shape.order(nodes)
    facet_nodes = shape.facet_corners * order
    if solid is not None:
        points = np.ascontiguousarray(solid.points, dtype=np.float64)
        cells = np.asarray(solid.cells, dtype=np.int64)
        facets = np.concatenate([np.asarray(f, dtype=np.int64) for f in solid.facets.values()])
        values = np.concatenate(
            [np.full(len(f), SURFACE_TAGS[n], np.int32) for n, f in solid.facets.items()]
        )
    else:
        points = np.empty((0, 3))
        cells = np.empty((0, nodes), dtype=np.int64)
        facets = np.empty((0, facet_nodes), dtype=np.int64)
        values = np.empty(0, dtype=np.int32)

    cells = cells[:, io.gmshio.cell_perm_array(mesh.to_type(shape.name), nodes)].copy()
    facets = facets[
        :, io.gmshio.cell_perm_array(mesh.to_type(shape.facet_name), facet_nodes)
    ].copy()
    element = basix.ufl.element("Lagrange", shape.name, order, shape=(3,))
    parts = mesh.create_cell_partitioner(mesh.GhostMode.none)
    domain = mesh.create_mesh(comm, cells, points, ufl.Mesh(element), parts)
    domain.topology.create_connectivity(2, 3)
    local, local_values = io.gmshio.distribute_entity_data(domain, 2, facets, values)
    tags = mesh.meshtags_from_entities(
        domain, 2, graph.adjacencylist(local), np.asarray(local_values, dtype=np.int32)
    )
    regions = {name: np.sort(tags.find(SURFACE_TAGS[name])) for name in names}
    return Domain(domain, regions, SYMMETRY in names)


def _straight(solid: SolidMesh) -> SolidMesh:
    """Hexahedra by their corners alone: dolfinx 0.9 has no geometry of 20 nodes.

    Raises:
        MeshError: where an edge is curved, which corners cannot say.
    """
    if solid.cells.shape[1] != 20:
        return solid
    ends = solid.points[solid.cells[:, solid.shape.edges]]
    off = np.linalg.norm(ends.mean(axis=2) - solid.points[solid.cells[:, 8:]], axis=-1)
    length = np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=-1)
    if (off > 1e-6 * length).any():
        raise MeshError(
            f"mesh: {(off > 1e-6 * length).any(axis=1).sum()} hexahedra with curved edges; "
            "allowed: straight ones"
        )
    facets = {name: found[:, :4] for name, found in solid.facets.items()}
    return assemble(solid.points, solid.cells[:, :8], facets)
