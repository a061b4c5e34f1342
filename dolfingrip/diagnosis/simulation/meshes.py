"""The graded mesh of the base simulation, and the ungraded one on which effects are tried.

An ungraded mesh takes a third of the time. What it gets wrong is wrong with and without an effect,
so that changes are taken between two simulations on it; a part of what grading changes
is a nuisance, for what the graded mesh still gets wrong.
"""

from __future__ import annotations

from dolfingrip.config import Change, Config
from dolfingrip.diagnosis.policy import MODEL


def coarser(config: Config) -> list[Change]:
    """Changes to the meshes that causes may be simulated on, the coarsest first.

    The first is not graded at all, the last is the mesh as configured. Those between are for thick
    walls: of a cast block one element, 4 mm wide, does not bear 5 kPa.
    """
    if config.mesh.file is not None or not config.hexahedra:
        return [{}]
    size_mm, edge_mm = config.mesh.hexahedra_mm(config.geometry)
    between = [by * edge_mm for by in MODEL.edges if by * edge_mm < size_mm]
    sizes_mm = [size_mm, *between] if edge_mm < size_mm else []
    return [*({"mesh.edge_size_mm": each} for each in sizes_mm), {}]
