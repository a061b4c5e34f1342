"""``dolfingrip morph`` on files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.command import run_command

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes import files
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.morph import MorphMap


@pytest.mark.parametrize(("first", "second"), [(".msh", ".vtk"), (".vtu", ".inp")])
def test_there_and_back(first: str, second: str, tmp_path: Path) -> None:
    original = finger_mesh(Finger(), Mesh(size_mm=10))
    paths = [str(tmp_path / name) for name in (f"a{first}", f"b{second}", f"c{first}")]
    files.write(Path(paths[0]), original)
    xi = ("--xi", "0.3", "-0.3")
    assert run_command("morph", paths[0], *xi, "-o", paths[1]) == 0
    moved = files.read(Path(paths[1]))
    np.testing.assert_allclose(
        moved.points, MorphMap(0.3, -0.3, 9.5).points(original.points), atol=1e-9
    )
    assert run_command("morph", paths[1], *xi, "--inverse", "-o", paths[2]) == 0
    back = files.read(Path(paths[2]))
    np.testing.assert_allclose(back.points, original.points, atol=1e-9)
    np.testing.assert_array_equal(back.cells, original.cells)
    assert set(back.facets) == set(original.facets)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["in.msh", "--xi", "-0.3", "0"], "morph.xi1 = -0.3: allowed: at least -0.2 and at most 1"),
        (["in.msh", "--xi", "0", "0"], "in.msh: No such file"),
        (["in.stl", "--xi", "0", "0"], "in.stl: unknown format; allowed: .msh, .inp, .vtk, .vtu"),
        (["broken.vtk", "--xi", "0", "0"], "broken.vtk: not readable as VTK"),
        (["broken.vtu", "--xi", "0", "0"], "broken.vtu: not readable as VTK"),
    ],
)
def test_refused(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("broken.vtk", "broken.vtu"):
        Path(name).write_text("nothing")
    assert run_command("morph", *arguments, "-o", "out.msh") == 2
    error = capfd.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert not Path("out.msh").exists()
