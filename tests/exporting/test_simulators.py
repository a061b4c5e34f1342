"""Files for MuJoCo, which loads and runs them, and for SOFA, read back by independent readers."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import meshio
import numpy as np
import pytest
import pyvista as pv
from support import small
from support.small import short

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.finger_rig import go_to_rest
from dolfingrip.experiments.rigs.undeformed import solid
from dolfingrip.exporting import deck, sofa
from dolfingrip.exporting import mujoco as exported
from dolfingrip.mechanics.newton.newton import Newton
from dolfingrip.meshes import files
from dolfingrip.meshes.groups import SYMMETRY
from dolfingrip.meshes.measures import jacobians
from dolfingrip.sections.tables import assignments

ACROSS = ("gravity.acceleration_m_s2=9.81", "gravity.direction=[1.0, 0.0, 0.0]")


def adopted(folder: Path) -> Config:
    """The same finger as a mesh file."""
    half = solid(short('solver.element="P1"'))
    assert SYMMETRY in half.facets
    files.write(folder / "own.msh", half)
    return config.load(None, assignments([f'mesh.file="{folder / "own.msh"}"']))


def test_mujoco_sags_as_far(tmp_path: Path) -> None:
    """The reference is our own run of the same linear tetrahedra under their weight.

    At the strains of the weight, 1e-4, Saint Venant and Kirchhoff's energy is that of any law.
    MuJoCo spreads mass evenly over vertices, so the weight is applied at them, by their volume.
    """
    mujoco = pytest.importorskip("mujoco")
    asked = short('solver.element="P1"', *ACROSS)
    exported.write(asked, tmp_path / "finger.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "finger.xml"))
    mesh = meshio.gmsh.read(tmp_path / "finger.msh")
    assert (model.nflexvert, model.nflexelem) == (len(mesh.points), len(mesh.cells[0].data))
    free = model.nflexvert - (mesh.points[:, 2] == 0).sum()  # the others are the world's
    moving_kg = 1190e-9 * pv.from_meshio(mesh).volume * free / model.nflexvert
    assert model.body_mass.sum() == pytest.approx(moving_kg, rel=1e-6)
    cells = mesh.cells[0].data
    volumes = pv.from_meshio(mesh).compute_cell_sizes()["Volume"]
    weight = 9.81 * 1190e-9 / 4 * np.bincount(cells.ravel(), np.repeat(volumes, 4))
    data = mujoco.MjData(model)
    data.xfrc_applied[model.flex_vertbodyid, 0] = weight
    model.opt.gravity[:] = 0
    mujoco.mj_forward(model, data)
    rest = data.flexvert_xpos.copy()
    for _ in range(200):
        mujoco.mj_step(model, data)
    assert not any(warning.number for warning in data.warning)
    tip = mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-6
    theirs = (data.flexvert_xpos - rest)[tip, 0].mean() * 1e3
    loose = short('solver.element="P1"', "contact.self_contact=false", *ACROSS)
    ours = sag_mm(loose)
    assert ours > 0.01
    assert theirs == pytest.approx(ours, rel=2e-3)


def sag_mm(asked: Config) -> float:
    """Mean displacement of the tip's nodes along x under weight."""
    finger = small.model(asked, plate=False)
    assert go_to_rest(finger, Newton(finger.model, asked.solver)) is None
    places = finger.model.u.function_space.tabulate_dof_coordinates()
    tip = places[:, 2] > places[:, 2].max() - 1e-6
    return float(finger.model.u.x.array.reshape(-1, 3)[tip, 0].mean())


class Node:
    """Stands in for SOFA's node: it remembers what is added."""

    def __init__(self, name: str) -> None:
        self.name, self.objects, self.children = name, [], []

    def addObject(self, kind: Any, **data: Any) -> Any:  # SOFA's name
        self.objects.append((kind, data))
        return Component(data)

    def addChild(self, name: str) -> Node:  # SOFA's name
        self.children.append(Node(name))
        return self.children[-1]

    def data(self, kind: str) -> dict[str, Any]:
        (found,) = [data for each, data in self.objects if each == kind]
        return found


class Component:
    """Stands in for a component of SOFA's, whose data are read and set as ``data.value``."""

    def __init__(self, data: dict[str, Any]) -> None:
        for key, value in data.items():
            setattr(self, key, type("Data", (), {"value": value})())


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Runs a scene's file with a stand-in for SOFA, and returns the root."""
    core, package = ModuleType("Sofa.Core"), ModuleType("Sofa")
    core.Controller = type("Controller", (), {})  # type: ignore[attr-defined]
    package.Core = core  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "Sofa", package)
    monkeypatch.setitem(sys.modules, "Sofa.Core", core)

    def run(file: Path) -> Node:
        known: dict[str, Any] = {"__file__": str(file)}
        exec(compile(file.read_text(encoding="utf-8"), file, "exec"), known)
        root = Node("root")
        root.dt = Component({"dt": 0.0}).dt  # type: ignore[attr-defined]
        found = known["createScene"](root)
        found.dt = type("Data", (), {"value": found.dt})()
        return found

    return run


@pytest.mark.parametrize("of_file", [False, True])
def test_the_scene_for_sofa(of_file: bool, tmp_path: Path, scene: Any) -> None:
    """References: volumes of our half mesh, twice, and of the boxes of the cavity."""
    asked = adopted(tmp_path) if of_file else short(*ACROSS)
    sofa.write(asked, tmp_path / "finger.py")
    root = scene(tmp_path / "finger.py")
    (finger,) = root.children
    mesh = pv.read(finger.data("MeshVTKLoader")["filename"])
    half = solid(short('solver.element="P1"'))
    assert mesh.volume == pytest.approx(2 * jacobians(half).mean(axis=1).sum() / 6, rel=1e-9)
    assert len(meshio.read(tmp_path / "finger.vtk").cells_dict["tetra"]) == 2 * len(half.cells)
    clamped = finger.data("FixedProjectiveConstraint")["indices"]
    np.testing.assert_array_equal(
        np.sort(clamped), np.flatnonzero(np.abs(mesh.points[:, 2]) < 1e-9)
    )
    material = finger.data("TetrahedronHyperelasticityFEMForceField")
    assert material["materialName"] == "NeoHookean"
    assert material["ParameterSet"] == "2930 26370"
    (cavity,) = finger.children
    inside = pv.read(cavity.data("MeshSTLLoader")["filename"]).clean()
    assert inside.is_manifold
    outside = inside.compute_normals(auto_orient_normals=True)
    np.testing.assert_allclose(inside.face_normals, outside.cell_normals, atol=1e-5)
    supply = root.objects[-1][0]
    for _ in range(2000):
        supply.onAnimateBeginEvent(None)
    ((inlet, *_),) = supply.inlets
    assert inlet.value.value == pytest.approx([asked.experiment.max_pressure_kPa])


@pytest.mark.parametrize(
    ("cavity", "expected_kPa"),
    [("pressure_kPa=[0.0, 4.0, -10.0]", [0.0, 4.0, -10.0]), ("pressure_ratio=0.5", [0, 10, 5])],
)
def test_sofa_follows_the_protocol(
    cavity: str, expected_kPa: list[float], tmp_path: Path, scene: Any
) -> None:
    """Pressures of the cavity's own supply or a part of the experiment's, straight in between."""
    times_s = [0.0, 1.0, 2.0]
    asked = short(
        f"protocol.time_s={times_s}", "protocol.pressure_kPa=[0.0, 20.0, 10.0]",
        f"cavity.cavity.{cavity}",
    )  # fmt: skip
    sofa.write(asked, tmp_path / "finger.py")
    root = scene(tmp_path / "finger.py")
    root.dt.value = 0.5
    supply = root.objects[-1][0]
    for now_s in (0.5, 1.0, 1.5, 2.0, 2.5):
        supply.onAnimateBeginEvent(None)
        ((inlet, *_),) = supply.inlets
        expected = np.interp(now_s, times_s, expected_kPa)
        assert inlet.value.value == pytest.approx([expected])


LAWS = {
    ("material.C10_MPa=1.1", "material.C01_MPa=0.4"): "MooneyRivlin",
    ("material.ogden_mu_MPa=[2.0]", "material.ogden_alpha=[3.0]"): "Ogden",
}


@pytest.mark.parametrize("keys", LAWS)
def test_laws_of_sofa(keys: tuple[str, str]) -> None:
    """Each has our shear modulus and bulk modulus: of (C10, C01, K) and of (2μ, α, K)."""
    kind = "polynomial" if "C10" in keys[0] else "ogden"
    material = short(f'material.law="{kind}"', *keys).material
    name, (first, second, bulk) = sofa.law(material)
    assert name == LAWS[keys]
    shear = 2 * (first + second) if name == "MooneyRivlin" else first / 2
    assert shear == pytest.approx(1e3 * material.shear_MPa)
    assert bulk == pytest.approx(1e3 * (material.lmbda_MPa + 2 / 3 * material.shear_MPa))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('material.law="polynomial"', "material.C10_MPa=1", "material.C20_MPa=1"), "no law"),
        (('material.law="gent"', "material.gent_mu_MPa=1"), 'no law "gent"; allowed: neo-hooke'),
        (("finger.kind=cast", "material.film.mu_MPa=4.0"), "no material.film; allowed: one"),
    ],
)
def test_sofa_refuses(change: tuple[str, ...], said: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=said):
        sofa.write(config.load(None, assignments(change)), tmp_path / "a.py")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("write", "name"), [(exported.write, "own.xml"), (deck.write, "own.inp")])
def test_the_own_mesh_is_not_lost(write: Any, name: str, tmp_path: Path) -> None:
    """A model for MuJoCo has its mesh beside it, under the name of that of `adopt`."""
    asked = adopted(tmp_path)
    if name.endswith(".inp"):
        files.write(tmp_path / name, solid(asked))
        asked = config.load(None, {"mesh.file": str(tmp_path / name)})
    before = Path(str(asked.mesh.file)).read_bytes()
    with pytest.raises(ConfigError, match=r"is mesh.file, which would be lost; allowed: another"):
        write(asked, tmp_path / name)
    assert Path(str(asked.mesh.file)).read_bytes() == before
    write(asked, tmp_path / f"other_{name}")


def test_hexahedra_of_a_file_are_refused(tmp_path: Path) -> None:
    files.write(tmp_path / "own.msh", solid(short()))
    asked = config.load(None, assignments([f'mesh.file="{tmp_path / "own.msh"}"']))
    with pytest.raises(ConfigError, match=r"\.xml: allowed: of tetrahedra"):
        exported.write(asked, tmp_path / "a.xml")
