"""Free bending by FElupe (https://felupe.readthedocs.io) on a linear mesh of dolfingrip."""

from __future__ import annotations

import time
import warnings
from typing import Any

import felupe
import numpy as np
from felupe.quadrature import Scheme
from scipy.sparse.linalg import spsolve, use_solver
from support.tip import mean_displacement

from dolfingrip.config import KPA, Config
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.meshes.cells import TETRAHEDRON
from dolfingrip.meshes.groups import CAVITY, CLAMP, SYMMETRY
from dolfingrip.meshes.solid import SolidMesh, match

FACE_CENTRE = Scheme(points=np.array([[1 / 3, 1 / 3, 0.0]]), weights=np.array([0.5]))
"""Midpoint of the face of the first three corners: exact, F being constant in an element."""


class CavityRegion(felupe.Region):
    """Elements on the cavity, integrated over their faces there.

    FElupe has boundary regions for quadrilaterals and hexahedra only, so this gives a linear
    tetrahedron one: the face's corners come first in each cell.
    """

    def __init__(self, mesh: felupe.Mesh, solid: SolidMesh) -> None:
        rows = match(solid.facets[CAVITY], solid.cells)
        cells, face = np.divmod(rows, 4)
        outward = np.take_along_axis(solid.cells[cells], TETRAHEDRON.face_corners[face], axis=1)
        opposite = solid.cells[cells].sum(axis=1) - outward.sum(axis=1)
        # seen from the fourth corner the first three turn left: a positive element
        turned = np.column_stack([outward[:, [0, 2, 1]], opposite])
        bounded = mesh.copy()
        bounded.update(cells=turned)
        super().__init__(bounded, felupe.Tetra(), FACE_CENTRE)
        a, b, c = (solid.points[outward[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        length = np.linalg.norm(normal, axis=1)
        self.dV = length[None, :] / 2
        self.normals = (normal / length[:, None]).T[:, None, :]
        self.dA = self.normals * self.dV


def bend(config: Config, steps: int, ordering: str) -> dict[str, Any]:
    """Bend the finger to the configuration's highest pressure.

    The strain energy is FElupe's ``NeoHookeCompressible``, μ/2 (tr C − 3) − μ ln J + λ/2 ln²J:
    dolfingrip's own.

    Args:
        config: with linear elements.
        steps: equal pressure steps.
        ordering: of SuperLU's columns; FElupe's default is ``COLAMD``.

    Returns:
        Times by phase (s), iterations and the tip's mean displacement (mm).
    """
    warnings.filterwarnings("ignore", message="splu converted its input")
    use_solver(useUmfpack=False)
    start = time.perf_counter()
    mesh = solid(config)
    meshed = time.perf_counter()
    grid = felupe.Mesh(mesh.points, mesh.cells, "tetra")
    field = felupe.FieldContainer([felupe.Field(felupe.RegionTetra(grid), dim=3)])
    body = felupe.SolidBody(
        felupe.NeoHookeCompressible(config.material.mu_MPa, config.material.lmbda_MPa), field
    )
    on_cavity = felupe.FieldContainer([felupe.Field(CavityRegion(grid, mesh), dim=3)])
    pressure = felupe.SolidBodyPressure(on_cavity)
    held = {"clamp": felupe.Boundary(field[0], mask=_mask(mesh, CLAMP))}
    if SYMMETRY in mesh.facets:
        held["symmetry"] = felupe.Boundary(field[0], mask=_mask(mesh, SYMMETRY), skip=(1, 0, 1))
    prescribed, free = felupe.dof.partition(field, held)
    values = felupe.dof.apply(field, held, prescribed)
    built = time.perf_counter()
    iterations = []
    for step in range(1, steps + 1):
        pressure.update(config.experiment.max_pressure_kPa * KPA * step / steps)
        solve = felupe.newtonraphson(
            items=[body, pressure],
            dof0=prescribed,
            dof1=free,
            ext0=values,
            solver=lambda a, b: spsolve(a, b, permc_spec=ordering),
            maxiter=30,
            verbose=0,
        )
        iterations.append(int(solve.iterations))
    solved = time.perf_counter()
    moved = mean_displacement(mesh, field[0].values)
    return {
        "dofs": int(3 * len(mesh.points)),
        "elements": len(mesh.cells),
        "mesh_s": meshed - start,
        "setup_s": built - meshed,
        "solve_s": solved - built,
        "iterations": sum(iterations),
        "load_steps": steps,
        "tip_x_mm": float(moved[0]),
        "tip_z_mm": float(moved[2]),
    }


def _mask(mesh: SolidMesh, group: str) -> np.ndarray:
    """Points (n,) of the group, True where one is in it."""
    return np.isin(np.arange(len(mesh.points)), mesh.facets[group])
