"""A meshed solid, distributed over the ranks."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import basix.ufl
import numpy as np
import ufl
from dolfinx import graph, io, mesh
from dolfinx.io.utils import cell_perm_gmsh
from mpi4py import MPI

from dolfingrip.mechanics.model.compatibility import cells_and_local_facets
from dolfingrip.mechanics.model.element import local_facets
from dolfingrip.mechanics.model.placement import Placement
from dolfingrip.meshes.cells import BY_NODES, CellShape
from dolfingrip.meshes.groups import SYMMETRY, cavities
from dolfingrip.meshes.quality import closing_mm3
from dolfingrip.meshes.solid import MeshError, SolidMesh, assemble
from dolfingrip.sections.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Domain:
    """Reference configuration (mm).

    Attributes:
        mesh: tetrahedra, straight or quadratic, or hexahedra.
        regions: local boundary facets by name: the mesh's groups and any added region.
        half: whether it is the half y ≥ 0 of a symmetric solid.
        parts: this rank's cells by name, for several bodies or materials; no cell is in two parts;
            empty if the solid is one part.
        placement: places of the solid's copies in the world; None if the solid is not copied.
        sheets: this rank's cells with a face on a surface that carries an energy, by the surface's
            name and the local facet.
        closing_mm3: of each cavity with an opening at the clamp, the constant that its volume
            differs by from what its facets enclose with the origin.
    """

    mesh: mesh.Mesh
    regions: dict[str, np.ndarray]
    half: bool
    parts: dict[str, np.ndarray] = field(default_factory=dict)
    placement: Placement | None = None
    sheets: dict[str, dict[int, np.ndarray]] = field(default_factory=dict)
    closing_mm3: dict[str, float] = field(default_factory=dict)
    _integration: list[tuple[int, np.ndarray]] = field(init=False, repr=False)
    _cells: list[tuple[int, np.ndarray]] | None = field(init=False, repr=False)

    def __post_init__(self) -> None:
        # UFL wants one and the same subdomain data in all integrals of a form
        data = [
            (tag, cells_and_local_facets(self.mesh, facets))
            for tag, facets in enumerate(self.regions.values())
        ]
        object.__setattr__(self, "_integration", data)
        sheets = [cells for by_facet in self.sheets.values() for cells in by_facet.values()]
        cells = list(enumerate([*self.parts.values(), *sheets])) or None
        object.__setattr__(self, "_cells", cells)

    @property
    def copies(self) -> int:
        """Symmetry multiplicity: copies of the meshed part in the whole solid, 2 for a half."""
        return 2 if self.half else 1

    @property
    def cavities(self) -> tuple[str, ...]:
        """Names of the regions that are cavities; one of most fingers."""
        return cavities(self.regions)

    def facets(self, *names: str) -> np.ndarray:
        """Local indices of the facets in the named regions."""
        return np.unique(np.concatenate([self.regions[name] for name in names]))

    def surface(self, *names: str, **metadata: object) -> ufl.Measure:
        """Surface measure of the named regions with UFL's ``metadata``."""
        order = list(self.regions)
        tags = tuple(order.index(name) for name in names)
        return ufl.Measure("ds", self.mesh, subdomain_data=self._integration, metadata=metadata)(
            tags
        )

    def cells(self, *names: str) -> np.ndarray:
        """This rank's cells in the named parts; without names, all cells."""
        if not names:
            return np.arange(self.mesh.topology.index_map(3).size_local, dtype=np.int32)
        return np.sort(np.concatenate([self.parts[name] for name in names]))

    def volume(self, *names: str, **metadata: object) -> ufl.Measure:
        """Measure of the named parts' volume; without names, of the whole volume.

        All integrals of a form over this domain's volume need measures of this method.
        """
        dx = ufl.Measure("dx", self.mesh, subdomain_data=self._cells, metadata=metadata)
        if not names:
            return dx
        order = list(self.parts)
        return dx(tuple(order.index(name) for name in names))

    def behind(self, sheet: str, facet: int, **metadata: object) -> ufl.Measure:
        """Measure of the volume of the cells with a face on a sheet.

        Args:
            sheet: name of the sheet.
            facet: local facet of the face.
            metadata: UFL's metadata about the integration.
        """
        places = [(name, local) for name, by_facet in self.sheets.items() for local in by_facet]
        tag = len(self.parts) + places.index((sheet, facet))
        dx = ufl.Measure("dx", self.mesh, subdomain_data=self._cells, metadata=metadata)
        return dx(tag)

    def single_walls(self) -> float:
        """Part of the cells on cavities that lie on the skin, too, and so are a wall alone."""
        self.mesh.topology.create_connectivity(2, 3)
        cell_of = self.mesh.topology.connectivity(2, 3).array  # one for each boundary facet
        first = self.mesh.topology.connectivity(2, 3).offsets[:-1]
        inner, outer = (
            np.unique(cell_of[first[self.facets(*names)]]) if names else np.empty(0, dtype=int)
            for names in (self.cavities, [name for name in ("skin", "tip") if name in self.regions])
        )
        both = [len(np.intersect1d(inner, outer)), len(inner)]
        single, total = self.mesh.comm.allreduce(np.array(both), MPI.SUM)
        return float(single / max(total, 1))

    def with_region(
        self, name: str, among: Sequence[str], where: Callable[[np.ndarray], np.ndarray]
    ) -> Domain:
        """This domain with one more named part of its boundary.

        Args:
            name: name of the new region.
            among: regions that contain it.
            where: returns (n,) booleans at (3, n) coordinates in mm; a facet belongs to the region
                if all its vertices do.
        """
        chosen = mesh.locate_entities_boundary(self.mesh, 2, where)
        facets = np.intersect1d(chosen, self.facets(*among)).astype(np.int32)
        regions = {**self.regions, name: facets}
        return replace(self, regions=regions)


def on_root[T](comm: MPI.Comm, work: Callable[[], T]) -> T | None:
    """Run ``work`` on rank 0 only; if it fails, every rank raises its error.

    Args:
        comm: ranks that all call this.
        work: called on rank 0.

    Returns:
        The result of ``work`` on rank 0; None on other ranks.
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


def distribute(
    comm: MPI.Comm,
    solid: SolidMesh | None,
    parts: Mapping[str, np.ndarray] | None = None,
    sheets: Mapping[str, np.ndarray] | None = None,
) -> Domain:
    """Distribute a mesh that rank 0 holds.

    Args:
        comm: communicator of the simulation.
        solid: the mesh on rank 0; None on other ranks.
        parts: rows of its cells by name on rank 0, if it has several parts.
        sheets: rows of its cells' faces (:func:`dolfingrip.meshes.solid.faces`) by name on rank 0,
            surfaces with an energy.

    Raises:
        ConfigError: on every rank, if the mesh has fewer cells than there are ranks.
    """
    parts = parts or {}
    facts = None
    if comm.rank == 0:
        assert solid is not None
        solid = _straight(solid)
        facts = (
            solid.cells.shape[1], tuple(solid.facets), len(solid.cells), tuple(parts),
            closing_mm3(solid),
        )  # fmt: skip
    nodes, names, number, part_names, closing = comm.bcast(facts)
    if number < comm.size:
        raise ConfigError(f"mesh: {number} elements on {comm.size} ranks; allowed: as many or more")
    shape = BY_NODES[nodes]
    order = shape.order(nodes)
    facet_nodes = shape.facet_corners * order
    if solid is not None:
        points = np.ascontiguousarray(solid.points, dtype=np.float64)
        cells = np.asarray(solid.cells, dtype=np.int64)
        facets = np.concatenate([np.asarray(f, dtype=np.int64) for f in solid.facets.values()])
        values = _tags(len(f) for f in solid.facets.values())
        inside = [np.asarray(rows, dtype=np.int64) for rows in parts.values()]
    else:
        points = np.empty((0, 3))
        cells = np.empty((0, nodes), dtype=np.int64)
        facets = np.empty((0, facet_nodes), dtype=np.int64)
        values = np.empty(0, dtype=np.int32)
        inside = [np.empty(0, dtype=np.int64) for _ in part_names]

    cells = cells[:, cell_perm_gmsh(mesh.to_type(shape.name), nodes)].copy()
    facets = facets[:, cell_perm_gmsh(mesh.to_type(shape.facet_name), facet_nodes)].copy()
    element = basix.ufl.element("Lagrange", shape.name, order, shape=(3,))
    domain = mesh.create_mesh(comm, cells, x=points, e=ufl.Mesh(element))  # without ghost cells
    domain.topology.create_connectivity(2, 3)
    regions = _found(domain, 2, facets, values, names)
    behind = _behind(domain, shape, comm.bcast(dict(sheets or {})))
    half = SYMMETRY in names
    if not part_names:
        return Domain(domain, regions, half, sheets=behind, closing_mm3=closing)
    domain.topology.create_connectivity(3, 3)
    rows, tags = cells[np.concatenate(inside)], _tags(len(rows) for rows in inside)
    by_part = _found(domain, 3, rows, tags, part_names)
    return Domain(domain, regions, half, by_part, sheets=behind, closing_mm3=closing)


def _behind(
    domain: mesh.Mesh, shape: CellShape, sheets: Mapping[str, np.ndarray]
) -> dict[str, dict[int, np.ndarray]]:
    """This rank's cells behind each sheet, by local facet; all ranks have the same facets."""
    if not sheets:
        return {}
    order = cell_perm_gmsh(mesh.to_type(shape.name), shape.corners)
    facet_of = local_facets(domain, shape.face_corners, order)
    size = domain.topology.index_map(3).size_local
    original = np.asarray(domain.topology.original_cell_index[:size])
    cells_of: dict[str, dict[int, np.ndarray]] = {}
    for name, rows in sheets.items():
        cells, faces = np.divmod(rows, len(shape.faces))
        cells_of[name] = {}
        for face in np.unique(faces):
            here = np.flatnonzero(np.isin(original, cells[faces == face])).astype(np.int32)
            cells_of[name][int(facet_of[face])] = here
    return cells_of


def _tags(counts: Iterable[int]) -> np.ndarray:
    """The place of each group, as often as it has entities."""
    lengths = list(counts)
    return np.repeat(np.arange(len(lengths), dtype=np.int32), lengths)


def _found(
    domain: mesh.Mesh, dimension: int, nodes: np.ndarray, tags: np.ndarray, names: Sequence[str]
) -> dict[str, np.ndarray]:
    """This rank's entities by name, from (n, nodes) input nodes and each one's place in these."""
    local, values = io.distribute_entity_data(domain, dimension, nodes, tags)
    meshtags = mesh.meshtags_from_entities(
        domain, dimension, graph.adjacencylist(local), np.asarray(values, dtype=np.int32)
    )
    return {name: np.sort(meshtags.find(place)) for place, name in enumerate(names)}


def _straight(solid: SolidMesh) -> SolidMesh:
    """Hexahedra by their corners alone: dolfinx 0.9 has no geometry of 20 nodes.

    Raises:
        MeshError: if an edge is curved, because corners cannot represent it.
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
    facets = {name: nodes[:, :4] for name, nodes in solid.facets.items()}
    return assemble(solid.points, solid.cells[:, :8], facets)
