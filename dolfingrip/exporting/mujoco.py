"""A flexible body for MuJoCo: the tetrahedra as one block of Gmsh's format, and a model of them.

Lengths in the mesh are in mm, those in the model in m.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final
from xml.sax.saxutils import quoteattr

import meshio
import numpy as np

from dolfingrip.config import Config
from dolfingrip.exporting.asked import plain, tetrahedra
from dolfingrip.files import whole
from dolfingrip.meshes.groups import CLAMP
from dolfingrip.meshes.measures import jacobians

PA_PER_MPA: Final = 1e6
KG_MM3: Final = 1e-9
"""kg/mm³ per kg/m³."""

MODEL: Final = """<!-- {title}
     MuJoCo's elasticity of flexes is Saint Venant and Kirchhoff's, with this material's moduli at
     small strain; it has no pressure in a cavity. MuJoCo 3 has integrator="implicitfast" here. -->
<mujoco model={name}>
  <compiler meshdir="."/>
  <option timestep="0.001" gravity="{gravity}" integrator="discrete" iterations="1000"
          tolerance="1e-10"/>
  <worldbody>
    <light pos="0.2 0.2 0.4" dir="-1 -1 -1.5"/>
    <flexcomp name={name} type="gmsh" file={mesh} dim="3" scale="0.001 0.001 0.001"
              mass="{mass:.8g}" radius="0.0002" rgba="0.9 0.6 0.2 1">
      <elasticity young="{young:.8g}" poisson="{poisson:.8g}" damping="0.002"/>
      <contact selfcollide="none"/>
      <pin id="{clamped}"/>
    </flexcomp>
  </worldbody>
</mujoco>
"""


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
    mesh, solid = tetrahedra(config, file.suffix), file.with_suffix(".msh")
    with whole.replacing(solid, check=lambda it: _read(it) == mesh.cells.shape) as (partial,):
        # MuJoCo refuses nodes in several blocks, as Gmsh itself writes them
        tags = [np.ones(len(mesh.cells), dtype=np.int32)]
        tagged = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        written = meshio.Mesh(mesh.points, [("tetra", mesh.cells)], cell_data=tagged)
        meshio.gmsh.write(partial, written, fmt_version="2.2", binary=False)
    material, gravity = config.material, config.gravity
    axis = np.array(gravity.direction) / np.linalg.norm(gravity.direction)
    volume_mm3 = float(jacobians(mesh).mean(axis=1).sum()) / 6
    content = MODEL.format(
        title=f"A finger of {len(mesh.cells)} tetrahedra, written by dolfingrip.",
        name=quoteattr(file.stem),
        gravity=" ".join(f"{each:.8g}" for each in gravity.acceleration_m_s2 * axis),
        mesh=quoteattr(solid.name),
        mass=KG_MM3 * material.density_kg_m3 * volume_mm3,
        young=2 * material.shear_MPa * (1 + material.poisson) * PA_PER_MPA,
        poisson=material.poisson,
        clamped=" ".join(map(str, np.unique(mesh.facets[CLAMP]))),
    )
    whole.write(file, content)
    return f"{len(mesh.points)} vertices, {len(mesh.cells)} tetrahedra, with {solid.name}"


def _read(file: Path) -> tuple[int, ...]:
    return meshio.gmsh.read(file).cells[0].data.shape
