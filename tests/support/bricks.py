"""Solids of bricks with regions and membranes, in elements S2."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

from dolfingrip.config import Solver
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.mechanics.model.element import Sheet, displacement_element
from dolfingrip.mechanics.model.model import Model
from dolfingrip.mechanics.model.parts import ByPart, StrainEnergy
from dolfingrip.mechanics.model.potential import Potential
from dolfingrip.mechanics.model.supports import at_rest
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes.solid import SolidMesh, faces

STRICT = Solver(rtol=1e-10, max_iterations=40)

SIDES = {
    "low x": (0, 0), "high x": (0, 1), "low y": (1, 0), "high y": (1, 1),
    "low z": (2, 0), "high z": (2, 1),
}  # fmt: skip
"""Axis and side of each group."""


def bricks(*planes: Sequence[float]) -> SolidMesh:
    """A block of bricks between planes along x, y and z, with a group on each side."""
    shape = np.array([len(each) for each in planes])
    number = np.arange(shape.prod()).reshape(shape)
    at = np.stack([part.ravel() for part in np.indices(shape - 1)], axis=1)
    corner = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corner = np.concatenate([corner, corner + np.array([0, 0, 1])])
    place = at[:, None] + corner
    cells = number[place[..., 0], place[..., 1], place[..., 2]].astype(np.int64)
    points = np.stack(np.meshgrid(*planes, indexing="ij"), axis=-1).reshape(-1, 3)
    every = faces(cells)
    groups = {}
    for name, (axis, side) in SIDES.items():
        level = planes[axis][-1 if side else 0]
        groups[name] = every[(points[every][:, :, axis] == level).all(axis=1)]
    return SolidMesh(points.astype(float), cells, groups)


def centres(solid: SolidMesh) -> np.ndarray:
    """Middles (m, 3) of the cells (mm)."""
    return np.asarray(solid.points[solid.cells].mean(axis=1))


def distributed(
    solid: SolidMesh,
    parts: Mapping[str, np.ndarray] | None = None,
    sheets: Mapping[str, np.ndarray] | None = None,
) -> Domain:
    """On this process alone."""
    return distribute(MPI.COMM_SELF, solid, parts, sheets)


def displacement(domain: Domain) -> fem.Function:
    """In elements S2 (mm)."""
    return fem.Function(fem.functionspace(domain.mesh, displacement_element("S2")))


def solved(
    domain: Domain,
    u: fem.Function,
    energies: Sequence[StrainEnergy] | ByPart,
    loads: Sequence[ufl.Form],
    held: Mapping[int, Sequence[str]],
    sheets: Sequence[Sheet] = (),
    further: Sequence[fem.DirichletBC] = (),
    *,
    carried: bool = True,
    ramp: tuple[fem.Constant, Sequence[float]] | None = None,
) -> Model:
    """In equilibrium with ``loads``, of which a constant may go through a ramp of values."""
    potential = Potential(u, energies, loads, domain=domain, sheets=sheets, carried=carried)
    supports = [*at_rest(u.function_space, domain, held), *further]
    model = Model(domain, u, potential, supports, {})
    newton = Newton(model, STRICT)
    for value in (None,) if ramp is None else ramp[1]:
        if ramp is not None:
            ramp[0].value = value
        found = newton.solve()
        assert found.converged, found
    return model
