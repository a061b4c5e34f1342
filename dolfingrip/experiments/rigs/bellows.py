"""Distances between neighbouring bellows, and the reading of the smallest one."""

from __future__ import annotations

from itertools import pairwise

import ipctk
import numpy as np

from dolfingrip.channels import CONTACT_GAP
from dolfingrip.experiments.rigs.finger import FingerModel
from dolfingrip.experiments.rigs.undeformed import morph
from dolfingrip.mechanics.readings.reading import Reading


class BellowsGaps:
    """Smallest distance across each gap between bellows, base block and tip.

    Parts are identified by the configuration's dimensions, so a mesh file of another shape has
    no gaps here. Vertices below the gap's floor belong to no part.
    """

    def __init__(self, finger: FingerModel) -> None:
        self._model = finger.model
        geometry = finger.config.geometry
        gaps = geometry.gaps()
        self._reach = 1.25 * gaps.width_mm
        self._pairs: list[tuple[str, ipctk.CollisionMesh, np.ndarray]] = []
        contact = finger.contact
        self._surface = contact.surface if contact is not None else None
        if self._surface is None:
            return
        floor = float(morph(finger.config).moved(np.array(gaps.floor_mm)))
        floor += 1e-6 * geometry.depth_mm
        part = _parts(floor, gaps.intervals, self._surface.rest)
        for i, (one, other) in enumerate(pairwise(gaps.parts)):
            mesh, vertices = self._facing(part, i)
            if mesh is not None:
                self._pairs.append((f"{one} and {other}", mesh, vertices))

    def _facing(
        self, part: np.ndarray, first: int
    ) -> tuple[ipctk.CollisionMesh | None, np.ndarray]:
        """Collision mesh of the parts ``first`` and ``first`` + 1, without contact within one."""
        assert self._surface is not None
        whole = self._surface.triangles
        label = part[whole]
        inside = (label == label[:, :1]).all(axis=1) & np.isin(label[:, 0], (first, first + 1))
        if len(np.unique(label[inside, 0])) < 2:
            return None, np.empty(0, dtype=np.int64)
        vertices, triangles = np.unique(whole[inside], return_inverse=True)
        faces = np.asfortranarray(triangles.reshape(-1, 3).astype(np.int32))
        mesh = ipctk.CollisionMesh(
            np.asfortranarray(self._surface.rest[vertices]), ipctk.edges(faces), faces
        )
        mesh.can_collide = ipctk.make_vertex_patches_filter(part[vertices].astype(np.int32))
        return mesh, vertices

    def all_mm(self) -> dict[str, float]:
        """Distance of each pair of neighbours (mm); infinite beyond 1.25 times the gap at rest."""
        if self._surface is None:
            return {}
        dofs = self._model.u.x.array
        now = self._surface.positions(dofs)
        found = {}
        for name, mesh, vertices in self._pairs:
            moved = np.asfortranarray(now[vertices])
            close = ipctk.NormalCollisions()
            close.build(mesh, moved, self._reach)
            found[name] = float(np.sqrt(close.compute_minimum_distance(mesh, moved)))
        return found


class ContactGap(Reading):
    """Smallest distance between neighbouring bellows (mm); NaN if none is known or near.

    Attributes:
        gaps_mm: distance of each pair of neighbours at the last reading.
    """

    differentiable = False

    def __init__(self, finger: FingerModel) -> None:
        super().__init__(finger.model, CONTACT_GAP.name)
        self._gaps = BellowsGaps(finger)
        self.gaps_mm: dict[str, float] = {}

    def value(self) -> float:
        self.gaps_mm = self._gaps.all_mm()
        smallest = min(self.gaps_mm.values(), default=np.inf)
        return smallest if np.isfinite(smallest) else float("nan")


def _parts(floor_mm: float, gaps: list[tuple[float, float]], points: np.ndarray) -> np.ndarray:
    """(n,) number of gaps before each reference point (along z); −1 for points below the gaps."""
    part = np.zeros(len(points), dtype=np.int64)
    for start, end in gaps:
        part[points[:, 2] > (start + end) / 2] += 1
    part[points[:, 0] <= floor_mm] = -1
    return part
