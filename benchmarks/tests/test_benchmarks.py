"""The benchmark's own parts: decks, energies, extrapolation, the page; nothing is timed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import ufl
from support import hollow_box, tip

from benchmarks import calculix, orders, outcomes, results, split_energy
from benchmarks.parts import PARTS, REFERENCE_NODES
from dolfingrip import config
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.solid import SolidMesh
from dolfingrip.sections.tables import assignments

SMALL = config.load(
    None, assignments(["mesh.size_mm=6", "mesh.order=2", "experiment.max_pressure_kPa=80"])
)
MU, BULK = 2.93, 28.32
CAVITY = "*SURFACE, NAME=cavity, TYPE=ELEMENT"


@pytest.fixture(scope="module")
def mesh() -> SolidMesh:
    """A coarse quadratic half finger."""
    return finger_mesh(SMALL.finger, SMALL.mesh)


def blocks(deck: str) -> dict[str, list[str]]:
    """Data lines of a deck by keyword line."""
    found: dict[str, list[str]] = {}
    for line in deck.splitlines():
        if line.startswith("*"):
            data = found.setdefault(line, [])
        else:
            data.append(line)
    return found


def test_deck_has_the_mesh_and_the_loads(mesh: SolidMesh, tmp_path: Path) -> None:
    """The deck has as many nodes, elements and loaded faces as the mesh, in numbers it can read."""
    calculix.write_deck(tmp_path / "finger.inp", mesh, SMALL)
    deck = blocks((tmp_path / "finger.inp").read_text())
    assert len(deck["*NODE"]) == len(mesh.points)
    assert len(deck["*ELEMENT, TYPE=C3D10"]) == len(mesh.cells)
    assert len(deck[CAVITY]) == len(mesh.facets["cavity"])
    assert deck["*DSLOAD"] == ["cavity, P, 0.08"]
    longest = max(len(w.strip()) for line in deck["*NODE"] for w in line.split(","))
    assert longest <= 20  # CalculiX reads no more of a number
    for name in ("clamp", "symmetry", "tip"):
        nodes = " ".join(deck[f"*NSET, NSET={name}"]).replace(",", " ").split()
        assert len(nodes) == len(np.unique(mesh.facets[name]))


def test_loaded_faces_are_the_cavity(mesh: SolidMesh, tmp_path: Path) -> None:
    """Faces by Abaqus' numbers have the corners of the cavity's facets."""
    corners = {1: (0, 1, 2), 2: (0, 3, 1), 3: (1, 3, 2), 4: (2, 3, 0)}  # Abaqus' manual
    calculix.write_deck(tmp_path / "finger.inp", mesh, SMALL)
    faces = [line.split(", S") for line in blocks((tmp_path / "finger.inp").read_text())[CAVITY]]
    loaded = {frozenset(mesh.cells[int(e) - 1, list(corners[int(f)])]) for e, f in faces}
    assert loaded == {frozenset(facet) for facet in mesh.facets["cavity"][:, :3]}


@pytest.mark.parametrize(("order", "kind", "nodes"), [(1, "C3D8", 8), (2, "C3D20R", 20)])
def test_deck_of_hexahedra(order: int, kind: str, nodes: int, tmp_path: Path) -> None:
    """Elements of CalculiX' types, no more than 16 numbers to a line, and faces 1 to 6."""
    box = hollow_box.mesh(order)
    calculix.write_deck(tmp_path / "box.inp", box, SMALL)
    deck = blocks((tmp_path / "box.inp").read_text())
    lines = deck[f"*ELEMENT, TYPE={kind}"]
    assert max(line.rstrip(",").count(",") for line in lines) < 16
    numbers = np.array(" ".join(lines).replace(",", " ").split(), dtype=int)
    cells = numbers.reshape(-1, nodes + 1)
    assert np.array_equal(cells[:, 0], 1 + np.arange(len(box.cells)))
    assert np.array_equal(np.sort(cells[:, 1:] - 1), np.sort(box.cells))
    # Abaqus' manual
    corners = {1: "1234", 2: "5876", 3: "1562", 4: "2673", 5: "3784", 6: "4851"}
    loaded = set()
    for line in deck[CAVITY]:
        element, face = line.split(", S")
        of_face = [int(corner) for corner in corners[int(face)]]
        loaded.add(frozenset(cells[int(element) - 1, of_face] - 1))
    assert loaded == {frozenset(facet) for facet in box.facets["cavity"][:, :4]}


def test_output_is_read(mesh: SolidMesh, tmp_path: Path) -> None:
    """The last increment counts; a uniform displacement is its own mean."""
    lines = []
    for time, moved in ((0.5, "1. 1. 1."), (1.0, "-2.5E+00 0. -1.0E-01")):
        lines += ["", f" displacements (vx,vy,vz) for set TIP and time  {time:.7E}", ""]
        lines += [f"{node + 1:10d} {moved}" for node in np.unique(mesh.facets["tip"])]
    (tmp_path / "finger.dat").write_text("\n".join(lines))
    part, moved = calculix.read_tip(tmp_path / "finger.dat", mesh)
    assert part == 1.0
    assert moved == pytest.approx([-2.5, 0.0, -0.1], rel=1e-12)


def test_mean_of_a_linear_field(mesh: SolidMesh) -> None:
    """The mean of x over the half tip face is that of its centre: half depth, quarter width."""
    centre = tip.mean_displacement(mesh, mesh.points)
    finger = SMALL.finger
    expected = [finger.depth_mm / 2, finger.width_mm / 4, finger.length_mm]
    assert centre[1:] == pytest.approx(expected[1:], rel=1e-12)
    assert 0 < centre[0] <= finger.depth_mm


@pytest.mark.parametrize("order", [1, 2])
def test_mean_on_quadrilaterals(order: int) -> None:
    """Means over the box's end, at z = 15 mm: x is 4 mm and, on second order, x² 64/3 mm²."""
    box = hollow_box.mesh(order)
    x = box.points
    assert tip.mean_displacement(box, x) == pytest.approx([4.0, 2.25, 15.0], rel=1e-12)
    if order == 2:
        field = np.column_stack([x[:, 0] ** 2, x[:, 0] * x[:, 2], x[:, 0] * x[:, 1]])
        assert tip.mean_displacement(box, field) == pytest.approx([64 / 3, 60, 9], rel=1e-12)


def split(stretch: np.ndarray) -> float:
    """Split energy of a diagonal deformation gradient."""
    strain = ((stretch**2 - 1) / 2) * np.eye(3)
    return float(split_energy.energy(ufl.as_matrix(strain.tolist()), MU, BULK)(()))


def test_split_energy_has_the_values_of_its_formula() -> None:
    """C10 (Ī1 − 3) + (J − 1)²/D1 with C10 = μ/2 and D1 = 2/K."""
    for stretch in ([1.3, 0.9, 0.8], [0.7, 1.2, 1.4], [1.1, 1.1, 1.1]):
        f = np.array(stretch)
        j = f.prod()
        expected = MU / 2 * ((f**2).sum() * j ** (-2 / 3) - 3) + BULK / 2 * (j - 1) ** 2
        assert split(f) == pytest.approx(expected, rel=1e-12)
    assert split(np.ones(3)) == 0.0


def test_extrapolation_finds_limit_and_order() -> None:
    """Exact for values that follow v0 + c hᵖ."""
    h = [4.0, 2.8, 2.0, 1.5]
    limit = orders.extrapolate(h, [140.0 - 0.7 * size**1.4 for size in h])
    assert limit.value == pytest.approx(140.0, abs=1e-9)
    assert limit.order == pytest.approx(1.4, abs=1e-9)
    assert orders.exponent([1, 10, 100], [2, 2 * 10**1.3, 2 * 100**1.3]) == pytest.approx(1.3)


def canned(folder: Path) -> None:
    """Outcomes of two parts, as runs leave them."""
    facts = {"date": "2026-01-01 00:00 UTC", "commit": "abc", "processor": "one", "versions": {}}
    row = {"tip_x_mm": -40.0, "tip_z_mm": -8.0}
    run = {"run_s": 10.0, "mesh_s": 0.5, "solve_s": 9.0, "processor_s": 9.5, "iterations": 40,
           "factorisations": 30, "dofs": 30000, "peak_MB": 500.0, "load": [0.1, 1.0],
           "rows": [row]}  # fmt: skip
    peer = {**row, "run_s": 39.0, "processor_s": 38.0, "load": [0.1, 1.0], "pressure_kPa": 100.0}
    for part, runs in {
        "blocked": {"dolfingrip": [run, {**run, "run_s": 30.0}, run]},
        "machine": {"calculix": [peer], "dolfingrip": [run]},
    }.items():
        outcomes.Outcome(part, facts, runs).write(folder)


def test_nodes_of_the_machine_part_are_those_that_were_computed() -> None:
    """The page's unknowns of that part are those of so many nodes."""
    page = Path(results.__file__).with_suffix(".md").read_text(encoding="utf-8")
    _, runs = page.split("## Runs\n")
    rows = [line.split("|")[1:-1] for line in runs.split("\n## ")[0].splitlines()]
    rows = [row for row in rows if row and row[0].strip() == "machine"]
    assert rows
    for row in rows:
        assert int(row[2].replace(",", "")) == 3 * REFERENCE_NODES


def test_tips_are_compared_with_short_increments_where_these_were_run(tmp_path: Path) -> None:
    canned(tmp_path)
    found = outcomes.read_all(PARTS, tmp_path)
    results.write(found, tmp_path / "results.md", tmp_path)
    page = (tmp_path / "results.md").read_text()
    assert "it has not been run yet" in page
    assert "5.0 for whole processes and 6.0 without start-up" in page
    machine = found["machine"]
    machine.runs["calculix tight"] = [{**machine.runs["calculix"][0], "tip_x_mm": -40.1}]
    machine.runs["calculix short"] = [{**machine.runs["calculix"][0], "tip_x_mm": -40.01}]
    results.write(found, tmp_path / "results.md", tmp_path)
    page = (tmp_path / "results.md").read_text()
    assert "2.5e-03 with the peer's tolerance tight, 2.5e-04 with its increments short" in page
    assert "it has not been run yet" not in page


def test_page_is_written_from_outcomes(tmp_path: Path) -> None:
    """Medians, goals scaled by the machine, and lines for what was not run."""
    canned(tmp_path)
    results.write(outcomes.read_all(PARTS, tmp_path), tmp_path / "results.md", tmp_path)
    page = (tmp_path / "results.md").read_text()
    assert "≤ 12 s (here 24.0 s) | 10.0 s (9.5 s of processor; 0.5 s for the mesh)" in page
    assert (
        "4.1 times (9.5 s, the mesh given, to 39.0 s; by processor time 4.2 times), tip 0.0e+00"
        in page
    )
    assert "| 0.50 GB | yes |" in page
    assert page.count("not run") >= 8
    results.write({}, tmp_path / "nothing.md", tmp_path)
    assert "not run" in (tmp_path / "nothing.md").read_text()
