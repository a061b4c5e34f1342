"""Thick-walled spheres: an octant of finite elements, and the radial equation."""

from __future__ import annotations

import gmsh
import numpy as np
from mpi4py import MPI
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from support import bodies

from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.meshes.gmsh_model import current_mesh, session
from dolfingrip.meshes.groups import SURFACE_TAGS

RATIO = 1.3
"""Outer to inner radius."""


def octant(inner_mm: float, outer_mm: float, size_mm: float) -> Domain:
    """One octant with quadratic geometry; its three plane faces pass through the centre."""
    with session("mesh of a sphere's octant"):
        occ = gmsh.model.occ
        shell, _ = occ.cut(
            [(3, occ.addSphere(0, 0, 0, outer_mm))], [(3, occ.addSphere(0, 0, 0, inner_mm))]
        )
        occ.intersect(shell, [(3, occ.addBox(0, 0, 0, *(3 * [2 * outer_mm])))])
        occ.synchronize()
        groups: dict[str, list[int]] = {"cavity": [], "skin": [], "symmetry": []}
        for _, surface in gmsh.model.getEntities(2):
            x = np.array(gmsh.model.occ.getCenterOfMass(2, surface))
            on_plane = np.abs(x).min() < 1e-6
            inside = np.linalg.norm(x) < (inner_mm + outer_mm) / 2 * 0.87
            groups["symmetry" if on_plane else "cavity" if inside else "skin"].append(surface)
        for name, surfaces in groups.items():
            gmsh.model.addPhysicalGroup(2, surfaces, SURFACE_TAGS[name], name)
        gmsh.option.setNumber("Mesh.MeshSizeMax", size_mm)
        gmsh.option.setNumber("Mesh.MeshSizeMin", size_mm)
        gmsh.model.mesh.generate(3)
        gmsh.model.mesh.setOrder(2)
        solid = distribute(MPI.COMM_SELF, current_mesh())
    return bodies.domain(solid.mesh, solid.regions)


def hold_octant(solid: bodies.Body) -> None:
    """No motion through the planes of symmetry."""
    for axis in range(3):
        solid.hold(bodies.plane(axis, 0.0), axis)


def pressure_MPa(stretch: float, mu: float, lmbda: float, ratio: float = RATIO) -> float:
    """Pressure that widens the cavity's radius by ``stretch``, of a sphere of radii 1, ``ratio``.

    Radial equilibrium dP_r/dR + 2 (P_r − P_t)/R = 0 (Ogden, Non-Linear Elastic Deformations,
    section 5.3.2) of r(R) with P_i = μ(λ_i − 1/λ_i) + Λ ln J/λ_i, λ_r = r', λ_t = r/R; P_r = 0
    outside and P_r = −p λ_t² inside. Integrated from the cavity outwards; the radial stretch
    there is found by shooting.
    """

    def stresses(radial: float, hoop: float) -> tuple[float, float]:
        volumetric = lmbda * np.log(radial * hoop**2)
        return (
            mu * (radial - 1 / radial) + volumetric / radial,
            mu * (hoop - 1 / hoop) + volumetric / hoop,
        )

    def equilibrium(big_r: float, y: np.ndarray) -> list[float]:
        radius, radial = y
        hoop = radius / big_r
        hoop_rate = (radial - hoop) / big_r
        p_r, p_t = stresses(radial, hoop)
        log_j = np.log(radial * hoop**2)
        by_radial = mu * (1 + radial**-2) + lmbda * (1 - log_j) / radial**2
        by_hoop = 2 * lmbda / (radial * hoop)
        return [radial, (-2 * (p_r - p_t) / big_r - by_hoop * hoop_rate) / by_radial]

    def outer_stress(radial: float) -> float:
        path = solve_ivp(
            equilibrium, (1, ratio), [stretch, radial], rtol=1e-12, atol=1e-13, method="DOP853"
        )
        radius, last = path.y[:, -1]
        return stresses(last, radius / ratio)[0]

    radial = brentq(outer_stress, 0.6 * stretch**-2, 1.2, xtol=1e-14)
    return float(-stresses(radial, stretch)[0] / stretch**2)
