"""A scene for SOFA with its plugin SoftRobots: tetrahedra, cavities, material and pressure.

Units are mm, kg, s, so that stress and pressure are in kPa and forces in mN.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config
from dolfingrip.exporting import asked
from dolfingrip.files import whole
from dolfingrip.meshes.groups import CLAMP, cavities
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.report.printable import write_stl
from dolfingrip.sections.laws.neo_hooke import NeoHooke
from dolfingrip.sections.laws.ogden import Ogden
from dolfingrip.sections.laws.polynomial import InvariantPolynomial
from dolfingrip.sections.material import Material

KPA_PER_MPA: Final = 1e3

SCENE: Final = '''"""{title}

runSofa {name}            (needs the plugins SofaPython3 and SoftRobots)
Units: mm, kg, s; pressure and stress in kPa, forces in mN.
"""

from pathlib import Path

import numpy as np
import Sofa.Core

HERE = Path(__file__).resolve().parent
TIMES_S = {times}
SUPPLIES_KPA = {supplies}  # the pressure of each at these times
CAVITIES = {cavities}  # file, supply, and pressure by the supply's
CLAMPED = {clamped}
PLUGINS = (
    "SoftRobots",
    "Sofa.Component.AnimationLoop",
    "Sofa.Component.Constraint.Lagrangian.Correction",
    "Sofa.Component.Constraint.Lagrangian.Solver",
    "Sofa.Component.Constraint.Projective",
    "Sofa.Component.IO.Mesh",
    "Sofa.Component.LinearSolver.Direct",
    "Sofa.Component.Mapping.Linear",
    "Sofa.Component.Mass",
    "Sofa.Component.ODESolver.Backward",
    "Sofa.Component.SolidMechanics.FEM.HyperElastic",
    "Sofa.Component.StateContainer",
    "Sofa.Component.Topology.Container.Constant",
    "Sofa.Component.Topology.Container.Dynamic",
    "Sofa.Component.Visual",
)


class Supply(Sofa.Core.Controller):
    """Follows the pressures of the experiment, and stays at the last ones."""

    def __init__(self, root, inlets):
        super().__init__()
        self.root, self.inlets, self.now_s = root, inlets, 0.0

    def onAnimateBeginEvent(self, event):
        self.now_s += self.root.dt.value
        for inlet, supply, ratio in self.inlets:
            pressure = np.interp(self.now_s, TIMES_S, SUPPLIES_KPA[supply])
            inlet.value.value = [float(pressure) * ratio]


def createScene(root):
    root.addObject("RequiredPlugin", pluginName=list(PLUGINS))
    root.addObject("VisualStyle", displayFlags="showForceFields showVisualModels")
    root.addObject("FreeMotionAnimationLoop")
    root.addObject("GenericConstraintSolver", maxIterations=1000, tolerance=1e-6)
    root.gravity, root.dt = {gravity}, 0.01

    finger = root.addChild("finger")
    finger.addObject("EulerImplicitSolver", rayleighStiffness=0.01)
    finger.addObject(
        "SparseLDLSolver", name="solver", template="CompressedRowSparseMatrixMat3x3d"
    )
    finger.addObject("MeshVTKLoader", name="loader", filename=str(HERE / "{mesh}"))
    finger.addObject("TetrahedronSetTopologyContainer", name="topology", src="@loader")
    finger.addObject("TetrahedronSetGeometryAlgorithms", template="Vec3")
    finger.addObject("MechanicalObject", name="nodes", template="Vec3", src="@loader")
    finger.addObject("MeshMatrixMass", massDensity={density}, topology="@topology")
    finger.addObject(
        "TetrahedronHyperelasticityFEMForceField",
        materialName="{law}",
        ParameterSet="{parameters}",
        topology="@topology",
    )
    finger.addObject("FixedProjectiveConstraint", indices=CLAMPED)
    finger.addObject("GenericConstraintCorrection", linearSolver="@solver")

    inlets = []
    for name, supply, ratio in CAVITIES:
        cavity = finger.addChild(Path(name).stem)
        cavity.addObject("MeshSTLLoader", name="loader", filename=str(HERE / name))
        cavity.addObject("MeshTopology", name="topology", src="@loader")
        cavity.addObject("MechanicalObject", name="nodes", template="Vec3")
        inlet = cavity.addObject(
            "SurfacePressureConstraint",
            template="Vec3",
            triangles="@topology.triangles",
            valueType="pressure",
            value=[0.0],
        )
        cavity.addObject("BarycentricMapping", mapForces=False, mapMasses=False)
        inlets.append((inlet, supply, ratio))
    root.addObject(Supply(root, inlets))
    return root
'''


def write(config: Config, file: Path) -> str:
    """Write the scene, and beside it the mesh as legacy VTK and each cavity as STL.

    Args:
        config: of the finger and of the experiment's pressures.
        file: target, ``….py``; the other files' names begin with its.

    Returns:
        What is in it, for a person.

    Raises:
        ConfigError: one line, where the finger has what SOFA lacks.
        WriteError: one line.
    """
    config = asked.plain(config, file.suffix)
    times_s, supplies = asked.supplies_kPa(config, file.suffix)
    name, parameters = law(config.material)
    solid = asked.beside(config, file, ".vtk")
    mesh = asked.tetrahedra(config, file.suffix)
    inlets = []
    for group in cavities(mesh.facets):
        inside = file.with_name(f"{file.stem}_{group}.stl")
        # seen from inside the solid: normals point out of the cavity
        write_stl(mesh.points, mesh.facets[group][:, ::-1], inside)
        inlets.append((inside.name, *asked.supplied(config, group)))
    whole.write(solid, legacy_vtk(mesh))
    weight = 1e3 * config.gravity.acceleration_m_s2 * np.array(config.gravity.direction)
    content = SCENE.format(
        title=f"A pneumatic finger of {len(mesh.cells)} tetrahedra, written by dolfingrip.",
        name=file.name,
        times=times_s,
        supplies=supplies,
        cavities=inlets,
        clamped=np.unique(mesh.facets[CLAMP]).tolist(),
        gravity=(weight / np.linalg.norm(config.gravity.direction)).tolist(),
        mesh=solid.name,
        density=asked.KG_MM3 * config.material.density_kg_m3,
        law=name,
        parameters=" ".join(f"{number:.10g}" for number in parameters),
    )
    whole.write(file, content)
    others = ", ".join([solid.name, *(stl for stl, *_ in inlets)])
    return f"{len(mesh.cells)} tetrahedra, with {others}"


def legacy_vtk(mesh: SolidMesh) -> str:
    """Linear tetrahedra as text in VTK's format 3.0, which SOFA's loader reads.

    Args:
        mesh: in mm.
    """
    count = len(mesh.cells)
    return "\n".join(
        [
            "# vtk DataFile Version 3.0\nfinger in mm\nASCII\nDATASET UNSTRUCTURED_GRID",
            f"POINTS {len(mesh.points)} double",
            *(f"{x:.12g} {y:.12g} {z:.12g}" for x, y, z in mesh.points),
            f"CELLS {count} {5 * count}",
            *(f"4 {a} {b} {c} {d}" for a, b, c, d in mesh.cells),
            f"CELL_TYPES {count}",
            "10\n" * count,
        ]
    )


def law(material: Material) -> tuple[str, list[float]]:
    """SOFA's name of a law, and its parameters in kPa; each energy is exactly ours.

    Source: sofa/component/solidmechanics/fem/hyperelastic/material/ of SOFA 24.06: NeoHookean
    (μ, λ), MooneyRivlin (C10, C01, K), Ogden (μ, α, K) with μ/α² for our 2μ/α².

    Args:
        material: of the finger.

    Raises:
        ConfigError: one line, if SOFA has not the law.
    """
    bulk = material.lmbda_MPa + 2 / 3 * material.shear_MPa
    if isinstance(material, NeoHooke):
        moduli = (material.mu_MPa, material.lmbda_MPa)
        return "NeoHookean", [KPA_PER_MPA * modulus for modulus in moduli]
    c = material.constants()
    if isinstance(material, InvariantPolynomial) and c.keys() <= {"C10_MPa", "C01_MPa"}:
        moduli = (c.get("C10_MPa", 0.0), c.get("C01_MPa", 0.0), bulk)
        return "MooneyRivlin", [KPA_PER_MPA * modulus for modulus in moduli]
    if isinstance(material, Ogden) and len(material.ogden_alpha) == 1:
        (mu,), (alpha,) = material.ogden_mu_MPa, material.ogden_alpha
        return "Ogden", [KPA_PER_MPA * 2 * mu, alpha, KPA_PER_MPA * bulk]
    allowed = "neo-hooke, polynomial of C10_MPa and C01_MPa alone, ogden of one term"
    raise asked.no_law(material, ".py", allowed)
