"""A short, coarse finger: half, and whole by mirroring the half."""

from __future__ import annotations

import numpy as np
from mpi4py import MPI
from support import bodies

from dolfingrip import config
from dolfingrip.experiments.rigs import finger
from dolfingrip.mechanics.model.domain import Domain, distribute
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.solid import SolidMesh

SETTINGS = config.from_dict(
    {
        "finger": {"length_mm": 38.0, "bellows": 2},
        "mesh": {"size_mm": 6.0, "half": True},
        "contact": {"self_contact": False},
        "solver": {"rtol": 1e-12},
    }
)


def half_mesh() -> SolidMesh:
    """The half y ≥ 0."""
    return finger_mesh(SETTINGS.finger, SETTINGS.mesh)


def mirrored(half: SolidMesh) -> SolidMesh:
    """The whole solid: ``half`` and its image in y = 0, joined there."""
    on_plane = np.unique(half.facets["symmetry"])
    count = len(half.points)
    assert np.allclose(half.points[on_plane, 1], 0.0, atol=1e-12)
    off_plane = np.setdiff1d(np.arange(count), on_plane)
    image = np.arange(count)
    image[off_plane] = count + np.arange(len(off_plane))
    points = np.concatenate([half.points, half.points[off_plane] * [1, -1, 1]])
    flip_tetrahedron, flip_triangle = [0, 2, 1, 3], [0, 2, 1]
    tetrahedra = np.concatenate([half.cells, image[half.cells][:, flip_tetrahedron]])
    facets = {
        name: np.concatenate([triangles, image[triangles][:, flip_triangle]])
        for name, triangles in half.facets.items()
        if name != "symmetry"
    }
    return SolidMesh(points, tetrahedra, facets)


def on_domain(solid: SolidMesh) -> Domain:
    """Distributed, with all regions in one order so that half and whole share their kernels."""
    found = distribute(MPI.COMM_SELF, solid)
    regions = {
        name: found.regions.get(name, np.empty(0, dtype=np.int32))
        for name in bodies.REGIONS
        if name != "facing plate"
    }
    return Domain(found.mesh, regions, found.half)


def build(domain: Domain, gap_mm: float) -> finger.FingerModel:
    """Finger and plate; a plate far away leaves the bending free."""
    plate = SETTINGS.plate.model_copy(update={"gap_mm": gap_mm})
    return finger.build(SETTINGS.model_copy(update={"plate": plate}), domain, plate=True)
