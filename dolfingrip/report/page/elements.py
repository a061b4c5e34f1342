"""What the elements of a run went through, computed anew from its stored displacements.

It is independent of the solver: shape functions of ``meshes``, the law of the configuration, sums
in numpy.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from dolfingrip.config import Config
from dolfingrip.forms.jet import Jet
from dolfingrip.meshes.shape_functions import of_cell
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.page.finger import Fields
from dolfingrip.report.page.runs import Run

Floats = npt.NDArray[np.float64]

SERENDIPITY: Final = 20
"""Nodes of a quadratic hexahedron; the file also has middles of faces, which follow from them."""

MPA_PER_KPA: Final = 1e-3


def _rule(nodes: int) -> tuple[Floats, Floats]:
    """Points and weights: of degree 3 on the reference hexahedron, of 2 on the tetrahedron."""
    if nodes in (4, 10):
        a, b = (5 - np.sqrt(5)) / 20, (5 + 3 * np.sqrt(5)) / 20
        return np.full((4, 3), a) + (b - a) * np.vstack([np.zeros(3), np.eye(3)]), np.full(
            4, 1 / 24
        )
    ends = 0.5 + np.array([-1, 1]) / np.sqrt(12)
    return np.array(list(product(ends, repeat=3))), np.full(8, 1 / 8)


def _gradients(mesh: FieldMesh) -> tuple[npt.NDArray[np.int64], Floats, Floats]:
    """Nodes of the cells, gradients of their shape functions, and volumes of the points.

    Returns:
        Shapes (cells, nodes), (cells, points, nodes, 3) and (cells, points).
    """
    cells = mesh.cells[:, :SERENDIPITY]
    points, weights = _rule(cells.shape[1])
    along = of_cell(cells.shape[1]).gradients(points)
    jacobian = np.einsum("cnk,qnj->cqkj", mesh.points[cells], along)
    volumes = np.abs(np.linalg.det(jacobian)) * weights
    return cells, np.einsum("qnj,cqjk->cqnk", along, np.linalg.inv(jacobian)), volumes


def deformation(mesh: FieldMesh, displacement: Floats) -> tuple[Floats, Floats]:
    """F at the integration points, shape (cells, points, 3, 3), and their volumes in mm³."""
    cells, gradients, volumes = _gradients(mesh)
    return np.eye(3) + np.einsum("cnk,cqnj->cqkj", displacement[cells], gradients), volumes


def volume_ratios(mesh: FieldMesh, displacement: Floats) -> Floats:
    """det F at the integration points, shape (cells, points)."""
    f, _ = deformation(mesh, displacement)
    return np.asarray(np.linalg.det(f))


@dataclass(frozen=True)
class PointInvariants:
    """Invariants of the laws as numbers at many points; derivatives are not needed.

    Attributes:
        of_shape: Ī₁ − 3, or what a law that is not split takes in its place, shape (points,).
        c: C̄, shape (points, 3, 3).
    """

    of_shape: Floats
    c: Floats

    @property
    def first(self) -> Jet:
        return _jet(self.of_shape)

    @property
    def second(self) -> Jet:
        trace = np.trace(self.c, axis1=1, axis2=2)
        return _jet((trace**2 - np.einsum("pij,pij->p", self.c, self.c)) / 2 - 3)

    def power_sum(self, exponent: Any) -> Jet:
        """Sum of the isochoric principal stretches to this power, less 3."""
        return _jet((np.linalg.eigvalsh(self.c) ** (exponent / 2)).sum(axis=1) - 3)


def _jet(values: Floats) -> Jet:
    return Jet(values, 0.0, 0.0, 0.0, 0.0, 0.0)


def strain_energy_mJ(config: Config, mesh: FieldMesh, displacement: Floats) -> float:
    """Strain energy of the base material in the meshed part."""
    f, volumes = deformation(mesh, displacement)
    f, volumes = f.reshape(-1, 3, 3), volumes.ravel()
    ratio = np.linalg.det(f)
    c = np.swapaxes(f, 1, 2) @ f
    isochoric = ratio[:, None, None] ** (-2 / 3) * c
    material = config.material
    split = material.volumetric(1.0, 0.0) > 0  # a law of I₁ itself leaves λ alone to the volume
    shape = np.trace(isochoric, axis1=1, axis2=2) - 3
    if not split:
        shape = np.trace(c, axis1=1, axis2=2) - 3 - 2 * np.log(ratio)
    found = material.energy(material.constants(), PointInvariants(shape, isochoric)).f
    bulk = material.volumetric(material.shear_MPa, material.lmbda_MPa)
    return float((volumes * (found + bulk / 2 * np.log(ratio) ** 2)).sum())


def balance(run: Run, fields: Fields) -> float | str:
    """Difference of the work of pressure and the strain energy at the last step, by the work.

    The work is ∫ p dV of the cubic spline through the readings, V being
    the cavity's volume.

    Returns:
        The share; or why it cannot be told.
    """
    config = run.result.config
    effects = sorted(config.extensions.model_fields_set)
    if effects:
        return f"the energy of {', '.join(effects)} is not known here"
    if config.film.model_fields_set:
        return "the energy of its films is not known here"
    pressure, volume = run.column("cavity_pressure_kPa"), run.column("cavity_volume_mm3")
    if pressure is None or volume is None:
        return "nothing was inflated"
    if config.gravity.acceleration_m_s2 or run.column("force_N") is not None:
        return "weight or the plate take part of the work"
    if len(set(run.branch)) > 1 or not (np.diff(volume) > 0).all():
        return "the volume falls"
    curve = CubicSpline(volume, pressure) if len(volume) > 2 else None
    if curve is None:
        return "too few readings"
    work = MPA_PER_KPA * float(curve.integrate(volume[0], volume[-1]))
    energy = strain_energy_mJ(config, fields.mesh, fields.displacements[-1])
    if run.result.facts.mesh.half:
        energy *= 2
    return abs(energy - work) / work
