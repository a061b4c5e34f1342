"""A flexible body for MuJoCo: the tetrahedra as one block of Gmsh's format, and a model of them.

Lengths in the mesh are in mm, those in the model in m.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final
from xml.etree.ElementTree import Comment, Element

import meshio
import numpy as np

from dolfingrip.config import Config
from dolfingrip.exporting.asked import KG_MM3, beside, plain, tetrahedra
from dolfingrip.files import whole
from dolfingrip.files.xml import add, text
from dolfingrip.meshes.groups import CLAMP
from dolfingrip.meshes.measures import jacobians

PA_PER_MPA: Final = 1e6

NOTE: Final = (
    " MuJoCo's elasticity of flexes is Saint Venant and Kirchhoff's, with this material's moduli "
    'at small strain; it has no pressure in a cavity. MuJoCo 3 has integrator="implicitfast" here. '
)


def write(config: Config, file: Path) -> str:
    """Write the model, and beside it the mesh of the whole finger.

    Args:
        config: of the finger.
        file: target, ``….xml``; the mesh is the ``.msh`` of the same name.

    Returns:
        What is in it, for a person.

    Raises:
        ConfigError: one line, where the finger has what MuJoCo lacks.
        WriteError: one line.
    """
    config = plain(config, file.suffix)
    solid = beside(config, file, ".msh")
    mesh = tetrahedra(config, file.suffix)
    with whole.replacing(solid, check=lambda it: _read(it) == mesh.cells.shape) as (partial,):
        # MuJoCo refuses nodes in several blocks, as Gmsh itself writes them
        tags = [np.ones(len(mesh.cells), dtype=np.int32)]
        tagged = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        written = meshio.Mesh(mesh.points, [("tetra", mesh.cells)], cell_data=tagged)
        meshio.gmsh.write(partial, written, fmt_version="2.2", binary=False)
    material, gravity = config.material, config.gravity
    axis = np.array(gravity.direction) / np.linalg.norm(gravity.direction)
    volume_mm3 = float(jacobians(mesh).mean(axis=1).sum()) / 6
    model = Element("mujoco", model=file.stem)
    model.append(Comment(NOTE))
    add(model, "compiler", meshdir=".")
    add(
        model, "option", timestep=0.001, gravity=gravity.acceleration_m_s2 * axis,
        integrator="discrete", iterations=1000, tolerance=1e-10,
    )  # fmt: skip
    world = add(model, "worldbody")
    add(world, "light", pos=(0.2, 0.2, 0.4), dir=(-1, -1, -1.5))
    body = add(
        world, "flexcomp", name=file.stem, type="gmsh", file=solid.name, dim=3,
        scale=np.full(3, 1e-3), mass=KG_MM3 * material.density_kg_m3 * volume_mm3, radius=0.0002,
        rgba=(0.9, 0.6, 0.2, 1),
    )  # fmt: skip
    young = 2 * material.shear_MPa * (1 + material.poisson) * PA_PER_MPA
    add(body, "elasticity", young=young, poisson=material.poisson, damping=0.002)
    add(body, "contact", selfcollide="none")
    add(body, "pin", id=np.unique(mesh.facets[CLAMP]))
    whole.write(file, text(model))
    return f"{len(mesh.points)} vertices, {len(mesh.cells)} tetrahedra, with {solid.name}"


def _read(file: Path) -> tuple[int, ...]:
    return meshio.gmsh.read(file).cells[0].data.shape
