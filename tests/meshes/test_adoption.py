"""Parts from files: what is taken for what, checked against shapes whose volumes are known."""

from __future__ import annotations

import math
from pathlib import Path

import gmsh
import pytest

from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import Wanted
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.solid import MeshError


def tube(file: Path, *, closed: bool = False) -> Path:
    """A round tube along x, 60 mm long, of radii 10 and 7 mm, with an end of 5 mm; as STEP."""
    occ = gmsh.model.occ
    with session("tube"):
        outer = occ.addCylinder(0, 0, 0, 60, 0, 0, 10)
        start = 5.0 if closed else -1.0
        inner = occ.addCylinder(start, 0, 0, 55 - start, 0, 0, 7)
        occ.cut([(3, outer)], [(3, inner)])
        occ.synchronize()
        gmsh.write(str(file))
    return file


@pytest.mark.parametrize("closed", [True, False])
def test_the_volumes_of_a_tube(tmp_path: Path, closed: bool) -> None:
    found = adopt(tube(tmp_path / "tube.step", closed=closed), Asked(), Wanted())
    hollow = math.pi * 7**2 * (50 if closed else 55)
    assert found.roles.half
    assert 2 * found.quality.cavity_mm3 == pytest.approx(hollow, rel=5e-3)
    assert 2 * found.quality.volume_mm3 == pytest.approx(math.pi * 6000 - hollow, rel=5e-3)
    assert found.size_mm == pytest.approx([20, 20, 60], rel=1e-2)


def test_a_wall_too_thin_for_its_mesh(tmp_path: Path) -> None:
    file = tube(tmp_path / "tube.step")
    with pytest.raises(MeshError, match=r"--size-mm 9: too large for a wall of 2\.\d+ mm"):
        adopt(file, Asked(), Wanted(size_mm=9.0))


def test_a_file_that_is_no_part(tmp_path: Path) -> None:
    file = tmp_path / "part.step"
    file.write_text("nothing", encoding="utf-8")
    with pytest.raises(MeshError, match=r"part\.step: not readable"):
        adopt(file, Asked(), Wanted())
