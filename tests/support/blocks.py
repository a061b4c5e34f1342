"""Blocks of tetrahedra, each with its materials and supports, in one model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import basix.ufl
import dolfinx
import numpy as np
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc
from support import bodies

from dolfingrip.forms import neo_hookean
from dolfingrip.mechanics.model.compatibility import points_of_cells
from dolfingrip.mechanics.model.domain import Domain, distribute, on_root
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.parts import ByPart, StrainEnergy
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.meshes.solid import SolidMesh, assemble, boundary, faces, merged

SIDES = {"left": (0, 0), "right": (0, 1), "front": (1, 0), "back": (1, 1), "below": (2, 0),
         "above": (2, 1)}  # fmt: skip
"""Axis and end of each of a box' surface groups."""


def block(
    cells: tuple[int, int, int],
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> SolidMesh:
    """A box with its six sides as groups."""
    box = bodies.box(cells, size)
    corners = points_of_cells(box.geometry).astype(np.int64)
    points = np.asarray(box.geometry.x)
    edges = points[corners[:, 1:]] - points[corners[:, :1]]
    turned = np.linalg.det(edges) < 0
    corners[turned] = corners[turned][:, [0, 2, 1, 3]]
    outside = faces(corners)[boundary(corners)]
    at = points[outside]
    groups = {}
    for name, (axis, end) in SIDES.items():
        groups[name] = outside[np.isclose(at[:, :, axis], end * size[axis]).all(axis=1)]
    return assemble(points + np.array(origin), corners, groups)


class NeoHooke:
    """A material of given Young's modulus (MPa) and Poisson's ratio."""

    def __init__(self, young_MPa: float, nu: float) -> None:
        self.young_MPa = young_MPa
        self.mu = young_MPa / (2 * (1 + nu))
        self.lmbda = 2 * self.mu * nu / (1 - 2 * nu)

    def __call__(self, mesh: dolfinx.mesh.Mesh) -> Sequence[StrainEnergy]:
        moduli = [fem.Constant(mesh, PETSc.ScalarType(value)) for value in (self.mu, self.lmbda)]
        return [lambda strain: neo_hookean.energy(strain, *moduli)]


@dataclass(frozen=True)
class Block:
    """A meshed solid with its materials and supports.

    Attributes:
        name: of the block; no slash.
        solid: its mesh (mm).
        material: of the whole, or by region of the mesh.
        held: surface groups without displacement along each axis.
    """

    name: str
    solid: SolidMesh
    material: NeoHooke | Mapping[str, NeoHooke]
    held: Mapping[int, Sequence[str]] = field(default_factory=dict)

    @property
    def materials(self) -> Mapping[str, NeoHooke]:
        """By region, "" for the whole."""
        return {"": self.material} if isinstance(self.material, NeoHooke) else self.material

    def named(self, name: str, *, lone: bool) -> str:
        """What a region or surface group is called in the model."""
        if lone:
            return name
        return f"{self.name}/{name}" if name else self.name

    def alone(self, *, lone: bool) -> SolidMesh:
        """The mesh, groups and regions named as in the model."""
        every = np.arange(len(self.solid.cells))
        facets = {self.named(k, lone=lone): v for k, v in self.solid.facets.items()}
        regions = {
            self.named(k, lone=lone): self.solid.regions.get(k, every) for k in self.materials
        }
        return replace(self.solid, facets=facets, regions=regions)


def domain(solids: Sequence[Block], comm: MPI.Comm = MPI.COMM_SELF) -> Domain:
    """All blocks in one mesh; groups and regions of several are named "block/group".

    There is a part for each region of a block, none where a lone block is of one material.
    """
    lone = len(solids) == 1

    def made() -> tuple[SolidMesh, Mapping[str, np.ndarray]]:
        solid = merged([each.alone(lone=lone) for each in solids])
        return solid, {name: rows for name, rows in solid.regions.items() if name}

    return distribute(comm, *(on_root(comm, made) or (None, None)))


def energies(domain: Domain, solids: Sequence[Block]) -> Sequence[StrainEnergy] | ByPart:
    """Strain energies of all blocks; regions of the same material share one."""
    lone = len(solids) == 1
    regions: dict[NeoHooke, list[str]] = {}
    for each in solids:
        for name, material in each.materials.items():
            regions.setdefault(material, []).append(each.named(name, lone=lone))
    if len(regions) == 1:
        (material,) = regions
        return material(domain.mesh)
    return {tuple(names): material(domain.mesh) for material, names in regions.items()}


def model(
    solids: Sequence[Block],
    *,
    degree: int = 1,
    comm: MPI.Comm = MPI.COMM_SELF,
    carried: bool = True,
) -> Model:
    """A model of blocks without loads."""
    made = domain(solids, comm)
    element = basix.ufl.element("Lagrange", "tetrahedron", degree, shape=(3,))
    space = fem.functionspace(made.mesh, element)
    u = fem.Function(space, name="displacement_mm")
    potential = Potential(u, energies(made, solids), carried=carried, domain=made)
    lone = len(solids) == 1
    held: dict[int, list[str]] = {0: [], 1: [], 2: []}
    for each in solids:
        for axis, groups in each.held.items():
            held[axis] += [each.named(group, lone=lone) for group in groups]
    return Model(made, u, potential, at_rest(space, made, held), {})
