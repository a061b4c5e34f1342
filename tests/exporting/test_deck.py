"""Decks that CalculiX solves as they are: energies on a cube, angle and force of a finger."""

from __future__ import annotations

import shutil
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import ufl
from support import hexagon
from support.calculix import Printed, printed, solve
from support.small import SHORT
from support.tip import mean_displacement

from dolfingrip import config, experiments
from dolfingrip.config import Config, ConfigError
from dolfingrip.experiments.rigs.undeformed import elements
from dolfingrip.exporting import deck
from dolfingrip.forms import bulk_modulus
from dolfingrip.forms.evaluate import number
from dolfingrip.meshes import files
from dolfingrip.sections.material import Material
from dolfingrip.sections.tables import assignments

needs_calculix = pytest.mark.skipif(shutil.which("ccx") is None, reason="no CalculiX here")

LAWS = {
    "neo-hooke": ("material.mu_MPa=2.9",),
    "Yeoh": (
        'material.law="polynomial"', "material.C10_MPa=1.4", "material.C20_MPa=-0.2",
        "material.C30_MPa=0.05",
    ),
    "Mooney-Rivlin": (
        'material.law="polynomial"', "material.C10_MPa=1.1", "material.C01_MPa=0.4",
    ),
    "ogden": (
        'material.law="ogden"', "material.ogden_mu_MPa=[2.0, 0.5]",
        "material.ogden_alpha=[2.5, -1.5]",
    ),
    "arruda-boyce": ('material.law="arruda-boyce"', "material.ab_mu_MPa=2.0"),
}  # fmt: skip


def solved(deck: Path) -> list[Printed]:
    """The blocks that CalculiX printed, in turn."""
    return [*printed(solve(deck.resolve()))]


@needs_calculix
@pytest.mark.parametrize("name", LAWS)
def test_the_stress_of_a_cube(name: str, tmp_path: Path) -> None:
    """The reference is the derivative of our own energy, by central differences.

    At constant volume all laws agree but for the pressure, which CalculiX' volumetric function has
    none of, nor ours. With a change of volume neo-Hooke's law agrees as a whole.
    """
    material = config.load(None, assignments(LAWS[name])).material
    stretch = np.diag([1.3, 0.9, 1 / (1.3 * 0.9)])
    stretch[0, 1] = 0.2
    for volume in (1.0, 1.03) if name == "neo-hooke" else (1.0,):
        gradient = volume ** (1 / 3) * stretch
        path = tmp_path / f"cube_{volume:g}.inp"
        path.write_text(cube(material, gradient), encoding="utf-8")
        theirs = solved(path)[-1].rows[:, 2:].mean(axis=0)
        np.testing.assert_allclose(
            theirs, cauchy(material, gradient), atol=2e-4 * np.abs(theirs).max()
        )


def cube(material: Material, gradient: np.ndarray) -> str:
    """A deck of eight bricks whose outer nodes move by (F − I) X."""
    places = np.array(list(product(range(3), repeat=3)))
    number_of = {tuple(place): i for i, place in enumerate(places.tolist(), 1)}
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    lines = ["*NODE"]
    lines += [f"{i}, {x}, {y}, {z}" for i, (x, y, z) in enumerate(places.tolist(), 1)]
    lines.append("*ELEMENT, TYPE=C3D8, ELSET=solid")
    for i, (x, y, z) in enumerate(product(range(2), repeat=3), 1):
        nodes = [number_of[x + a, y + b, z + c] for c in (0, 1) for a, b in corners.tolist()]
        lines.append(", ".join(map(str, [i, *nodes])))
    lines.append(f"*MATERIAL, NAME=rubber\n{deck.law(material)}*SOLID SECTION, ELSET=solid,")
    lines[-1] += " MATERIAL=rubber\n*STEP, NLGEOM\n*STATIC\n0.25, 1.\n*BOUNDARY"
    for i, place in enumerate(places, 1):
        if not (place == 1).all():
            moved = (gradient - np.eye(3)) @ place
            lines += [f"{i}, {k}, {k}, {moved[k - 1]:.12g}" for k in (1, 2, 3)]
    lines.append("*EL PRINT, ELSET=solid, FREQUENCY=100\nS\n*END STEP\n")
    return "\n".join(lines)


def cauchy(material: Material, gradient: np.ndarray) -> np.ndarray:
    """Cauchy stress (MPa): xx, yy, zz, xy, xz, yz."""

    def energy(f: np.ndarray) -> float:
        strain = ufl.as_matrix((0.5 * (f.T @ f - np.eye(3))).tolist())
        volumetric = material.volumetric(material.shear_MPa, material.lmbda_MPa)
        shape = material.of_shape(strain, material.constants())
        return number(shape + bulk_modulus.energy(strain, volumetric))

    nominal, step = np.zeros((3, 3)), 1e-5
    for place in product(range(3), repeat=2):
        change = np.zeros((3, 3))
        change[place] = step
        nominal[place] = (energy(gradient + change) - energy(gradient - change)) / (2 * step)
    found = nominal @ gradient.T / np.linalg.det(gradient)
    return found[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]


def finger(*more: str) -> Config:
    """A short finger whose walls may pass through one another, as the deck's may."""
    options = ("contact.self_contact=false", "experiment.step_kPa=50", *more)
    return config.load(None, assignments([*SHORT, *options]))


@needs_calculix
@pytest.mark.parametrize("element", ["P2", "S2"])
def test_the_tip_of_the_free_finger(element: str, tmp_path: Path) -> None:
    """The reference is our own run; CalculiX' tolerance leaves 2e-4."""
    asked = finger(f'solver.element="{element}"')
    said = deck.write(asked, tmp_path / "free.inp")
    assert said.startswith(f"{541 if element == 'P2' else 158} elements, 1 s for 50 kPa")
    mesh = elements(asked)
    theirs = mean_displacement(mesh, solved(tmp_path / "free.inp")[-1].on(mesh))[[0, 2]]
    ours = experiments.run("bending", asked).rows[-1]
    assert np.hypot(*theirs) > 1.5
    assert theirs == pytest.approx([ours["tip_x_mm"], ours["tip_z_mm"]], rel=1e-3)


@needs_calculix
def test_chambers_with_supplies_of_their_own(tmp_path: Path) -> None:
    """The reference is our own run: two chambers, then the third, which is under suction.

    CalculiX' own tolerance would leave 5e-3 of so soft a finger's motion.
    """
    asked = hexagon.driven(tmp_path, [0.0, 5.0, 5.0], cavity_2=[0.0, 0.0, -5.0])
    path = tmp_path / "driven.inp"
    assert "2 s for 5 kPa" in deck.write(asked, path)
    finer = "*CONTROLS, PARAMETERS=FIELD\n1e-6, 1e-6, , , 1e-6\n*STATIC\n"
    text = path.read_text(encoding="utf-8").replace("*STATIC\n", finer)
    path.write_text(text, encoding="utf-8")
    mesh, ours = elements(asked), experiments.run("bending", asked)
    for at, block in enumerate(solved(path), 1):  # printed at whole seconds
        theirs = mean_displacement(mesh, block.on(mesh))
        expected = [ours[f"tip_{axis}_mm"][at] for axis in "xyz"]
        assert np.linalg.norm(expected) > 0.004
        assert theirs == pytest.approx(expected, rel=2e-3, abs=1e-6)
    assert at == 2


@needs_calculix
def test_the_force_on_the_plate(tmp_path: Path) -> None:
    """The reference is our own run with a thin barrier: the deck's plate is ideally hard."""
    asked = finger(
        'solver.element="P2"', "plate.gap_mm=0.5", "plate.tilt_deg=3", "plate.barrier_mm=0.01"
    )
    deck.write(asked, tmp_path / "blocked.inp", plate=True)
    what, _, rows = solved(tmp_path / "blocked.inp")[-1]
    assert what == "forces"
    ours = experiments.run("blocked_force", asked).column("force_N")[-1]
    assert ours > 0.5
    assert 2 * np.linalg.norm(rows[0, 1:]) == pytest.approx(ours, rel=5e-3)


def test_regions_weight_and_cavities(tmp_path: Path) -> None:
    """What the deck says of them; and our own reader finds the mesh again."""
    asked = config.load(
        None,
        assignments([
            "finger.kind=cast", "mesh.size_mm=8", "mesh.edge_size_mm=8",
            "material.film.mu_MPa=4.0", "gravity.acceleration_m_s2=9.81",
            "cavity.cavity.pressure_ratio=0.5", "experiment.max_pressure_kPa=20",
        ]),
    )  # fmt: skip
    deck.write(asked, tmp_path / "cast.inp")
    text = (tmp_path / "cast.inp").read_text(encoding="utf-8")
    for line in (
        "*SOLID SECTION, ELSET=film, MATERIAL=film", "*SOLID SECTION, ELSET=rest, MATERIAL=rest",
        "solid, GRAV, 9810, 0, 0, 1", "cavity, P, 0.5", "0, 0, 1, 0.02", "*DENSITY\n1.19e-09",
    ):  # fmt: skip
        assert f"{line}\n" in text
    assert "*ELEMENT, TYPE=C3D20\n" in text  # more points than C3D20R, which a cast finger needs
    assert len(files.read(tmp_path / "cast.inp").cells) == len(elements(asked).cells)


REFUSED = {
    "gent": (
        ('material.law="gent"', "material.gent_mu_MPa=1"), False, 'no law "gent"; allowed: neo',
    ),
    "effect": (
        ("extensions.prony.g=[0.1]", "extensions.prony.tau_s=[1.0]"), False,
        "no effect extensions.prony",
    ),
    "film": (("film.paper.Et_N_per_mm=50.0",), False, "no film.paper"),
    "air": (("cavity.cavity.closed=true",), False, "no air in cavity.cavity"),
    "volume": (('experiment.control="volume"',), False, r'\.inp: allowed: "pressure"'),
    "mixed": (('solver.element="P2-P1"',), False, "allowed: P1, P2, S2"),
    "hanging": (("gravity.acceleration_m_s2=9.81",), True, "with a plate: allowed: 0 m/s²"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(name: str, tmp_path: Path) -> None:
    changes, plate, said = REFUSED[name]
    asked = config.load(None, assignments([*SHORT, *changes]))
    with pytest.raises(ConfigError, match=said):
        deck.write(asked, tmp_path / "a.inp", plate=plate)
    assert not list(tmp_path.iterdir())
