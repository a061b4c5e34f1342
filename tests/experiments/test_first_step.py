"""Adopted parts of other CAD kernels: the right back, the right sign, quality judged.

``tests/meshes/parts/make.py`` draws them; it says which side of each is the back.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from dolfinx import fem
from mpi4py import MPI
from support.command import run_command

from dolfingrip import config
from dolfingrip.experiments.rigs import finger
from dolfingrip.experiments.rigs.first_step import adopt
from dolfingrip.mechanics.model.domain import distribute
from dolfingrip.meshes.adoption import roles
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.quality import check

PARTS = Path(__file__).parents[1] / "meshes" / "parts"


def volume_mm3(angles: int, *frustums: tuple[float, float, float]) -> float:
    """Volume of frustums of regular polygons, each of two radii and a height."""
    area = angles / 2 * math.sin(2 * math.pi / angles)
    return sum(area * h * (a * a + a * b + b * b) / 3 for a, b, h in frustums)


def segment_mm2(radius: float, off: float) -> float:
    """Area of the part of a disc that lies farther than ``off`` to one side of its centre."""
    return radius**2 * math.acos(off / radius) - off * math.sqrt(radius**2 - off**2)


@pytest.mark.parametrize(
    ("name", "back", "cavity_mm3"),
    [
        ("slits_up.step", (0, 0, -1), 4 * 4 * 51 + 4 * (9 * 13 - 4 * 4) * 6),
        ("slits_left.step", (1, 0, 0), 4 * 4 * 51 + 4 * (9 * 13 - 4 * 4) * 6),
        ("half_round.step", (-1, 0, 0), segment_mm2(9, 2.6) * 76),
        ("thick_back.step", (1, 0, 0), 14 * 14 * 76),
    ],
)
def test_parts_that_bend(name: str, back: tuple[float, ...], cavity_mm3: float) -> None:
    found = adopt(PARTS / name, Asked(), MeshRequest())
    assert np.allclose(-found.roles.rotation[0], back, atol=1e-9)
    assert found.roles.said["bends"].startswith("towards the back: one step of pressure")
    assert "(--back: another direction)" in found.roles.said["back"]
    assert 2 * found.quality.cavity_mm3 == pytest.approx(cavity_mm3, rel=2e-3)
    assert found.quality.scaled_jacobian_min > 0.05


@pytest.mark.parametrize(
    ("name", "cavities", "volume"),
    [
        ("three_chambers.step", 3, 3 * math.pi * 3.5**2 * 62),
        ("collared_tube.3mf", 1, volume_mm3(32, (5.5, 5.5, 56))),
        ("suction_cup.stl", 1, None),
    ],
)
def test_parts_that_do_not_bend_by_themselves(
    name: str, cavities: int, volume: float | None
) -> None:
    found = adopt(PARTS / name, Asked(), MeshRequest())
    assert found.roles.said["bends"].startswith("not by itself: one step of pressure")
    assert len(found.roles.cavities) == cavities
    assert abs(found.roles.rotation[2] @ [0, 0, 1]) == pytest.approx(1)
    if volume is not None:
        sides = 2 if found.roles.half else 1
        assert sides * found.quality.cavity_mm3 == pytest.approx(volume, rel=1e-2)
    if cavities > 1:  # the back is opposite to the first chamber
        first = found.roles.cavities[0].centre_mm * [1, 1, 0]
        assert found.roles.rotation[0] @ first == pytest.approx(np.linalg.norm(first), rel=1e-2)
    else:
        # the clamp is the collar's end, and the cup's neck, not its mouth
        assert found.roles.origin_mm[2] == pytest.approx(0, abs=1e-6)


def test_the_part_itself_is_kept(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    part = tmp_path / "adopted.msh"
    part.write_bytes(b"of another program")
    assert run_command("adopt", part, "--out", tmp_path) == 2
    assert "adopted.msh would be lost; allowed: another folder" in capfd.readouterr().err
    assert part.read_bytes() == b"of another program"


def test_a_wrong_guess_is_corrected(monkeypatch: pytest.MonkeyPatch) -> None:
    """By centroids alone the slit side is taken for the back."""
    monkeypatch.setattr(roles, "bearing_centre", lambda *given: None)
    found = adopt(PARTS / "slits_up.step", Asked(), MeshRequest())
    assert np.allclose(-found.roles.rotation[0], (0, 0, -1), atol=1e-9)
    assert "corrected by the first step of pressure" in found.roles.said["back"]
    assert "faces +z of the file" in found.roles.said["back"]  # what the walls had told


def test_a_back_that_is_asked_for_stays() -> None:
    found = adopt(PARTS / "thick_back.step", Asked(back=(-1, 0, 0)), MeshRequest())
    assert np.allclose(-found.roles.rotation[0], (-1, 0, 0))
    assert found.roles.said["bends"].startswith(
        "towards +x of the file, away from the back that was asked for"
    )


def test_the_volume_of_a_cavity_whose_rim_is_not_at_the_origin() -> None:
    """The reading is the closed cavity's, wherever the held rim lies."""
    mesh = adopt(PARTS / "thick_back.step", Asked(), MeshRequest()).mesh
    moved = replace(mesh, points=mesh.points + np.array([0.0, 0.0, 11.0]))
    adopted = config.load(
        overrides={"finger.kind": "adopted", "mesh.file": "part.msh", "solver.element": "P1"}
    )
    model = finger.build(adopted, distribute(MPI.COMM_SELF, moved), plate=False)
    found = fem.assemble_scalar(fem.form(model.enclosed))
    assert found == pytest.approx(14 * 14 * 76 / 2, rel=1e-9)
    assert check(moved).cavity_mm3 == pytest.approx(found, rel=1e-9)


def test_a_collar_that_is_held_by_the_command(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part, out = PARTS / "collared_tube.3mf", tmp_path / "out"
    assert run_command("adopt", part, "--clamp-region=-20,-20,-1,20,20,6", "--out", out) == 0
    told = capsys.readouterr().out
    assert "clamp:          105.3 mm² where what --clamp-region holds ends, at (0, 0, 6) mm" in told
    assert "bends:          not by itself" in told
    told_of = config.load(out / "adopted.toml").adopted
    assert told_of.length_mm == pytest.approx(54)
    assert told_of.back.startswith("faces ")
    assert not told_of.bends_to_back
    assert run_command("adopt", part, "--clamp-region", "1,2,3", "--out", out) == 2
    assert "--clamp-region 1,2,3: allowed: six numbers, as in" in capsys.readouterr().err
    assert run_command("adopt", part, "--cavity", "none.stl", "--out", out) == 2
    assert "--cavity none.stl: no such file" in capsys.readouterr().err
