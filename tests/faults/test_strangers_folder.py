"""Files of a stranger's folder are data: nothing that lies beside them is read, or run.

The operating system tells which of the planted files any process has opened.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import cv2
import ezdxf
import gmsh
import numpy as np
import openpyxl
import pytest
import pyvista as pv
from scipy.io import savemat
from support import filmed, hollow_box, strangers

from dolfingrip.design.gradient.curve import READERS
from dolfingrip.importing import cells
from dolfingrip.importing.told import Told
from dolfingrip.loading import SETTINGS
from dolfingrip.meshes import closed_surface, files
from dolfingrip.meshes.adoption import formats, step
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.solid import MeshError
from dolfingrip.tracking.frames import open_frames

PARTS = Path(__file__).parents[1] / "meshes" / "parts"


def _mesh(file: Path) -> None:
    files.write(file, hollow_box.mesh())


def _drawn(file: Path) -> None:
    with session("drawn"):
        gmsh.model.occ.addBox(0, 0, 0, 10, 20, 30)
        gmsh.model.occ.synchronize()
        gmsh.write(str(file))


def _surface(file: Path) -> None:
    pv.Cube().triangulate().save(file)


def _packed(file: Path) -> None:
    file.write_bytes((PARTS / "collared_tube.3mf").read_bytes())


def _workbook(file: Path) -> None:
    book = openpyxl.Workbook()
    for row in (("Time (s)", "Pressure (kPa)"), (0, 0), (1, 10), (2, 20)):
        book.active.append(row)
    book.save(file)


def _curve(file: Path) -> None:
    if file.suffix == ".dxf":
        drawing = ezdxf.new()
        drawing.modelspace().add_line((0, 0), (0, 50))
        drawing.saveas(file)
    else:
        path = '<path d="M 0 0 L 0 50"/>'
        file.write_text(f'<svg xmlns="http://www.w3.org/2000/svg" width="50mm">{path}</svg>')


TABLE = "Time (s),Pressure (kPa),Angle (deg)\n0,0,0\n1,10,2\n2,20,5\n3,30,9\n"


def _text(file: Path) -> None:
    file.write_text(TABLE, encoding="utf-8")


def _arrays(file: Path) -> None:
    names, *rows = (line.split(",") for line in TABLE.splitlines())
    columns = np.array(rows, dtype=float).T
    savemat(file, {name.split()[0]: values for name, values in zip(names, columns, strict=True)})


def _picture(file: Path) -> None:
    image = np.zeros((120, 160, 3), dtype=np.uint8)
    if file.suffix == ".mp4":
        filmed.write(file, [image] * 3)
    else:
        cv2.imwrite(str(file), image)


def _cad(file: Path) -> None:
    formats.require_bearable(file)
    formats.triangles_of(file, 1.0)
    with session("read"):
        assert step._imported(file, 1.0)  # noqa: SLF001


READ: dict[str, tuple[Callable[[Path], None], Callable[[Path], object]]] = {
    **dict.fromkeys((".msh", ".inp", ".vtk", ".vtu"), (_mesh, lambda f: files.read(f, needed=()))),
    **dict.fromkeys((".step", ".brep"), (_drawn, _cad)),
    **dict.fromkeys((".obj", ".ply"), (_surface, lambda file: formats.triangles_of(file, 1.0))),
    ".stl": (_surface, lambda file: (formats.triangles_of(file, 1.0), closed_surface.read(file))),
    ".3mf": (_packed, lambda file: formats.triangles_of(file, 1.0)),
    ".xlsx": (_workbook, lambda file: cells.read(file, Told())),
    **{kind: (_curve, READERS[kind]) for kind in (".svg", ".dxf")},
    ".txt": (_text, lambda file: cells.read(file, Told())),
    ".mat": (_arrays, lambda file: cells.read(file, Told())),
    **dict.fromkeys((".png", ".mp4"), (_picture, lambda file: [*open_frames([file])])),
}
"""How a small file is written, and how it is read, by its ending."""


@pytest.mark.parametrize("kind", READ)
def test_what_lies_beside_a_file_is_not_read(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    trace = tmp_path / "trace"
    folders = [tmp_path / "work", tmp_path / "home"]
    write, read = READ[kind]
    for folder in folders:
        folder.mkdir()
    file = folders[0] / f"part{kind}"
    write(file)
    planted = [each for folder in folders for each in strangers.plant(folder, trace)]
    planted += strangers.plant_beside(file, trace)
    monkeypatch.chdir(folders[0])
    monkeypatch.setenv("HOME", str(folders[1]))
    with strangers.opened(planted) as opened:
        read(Path(file.name))
    assert not opened
    assert not trace.exists()


def test_gmsh_by_itself_runs_what_lies_beside_a_mesh(tmp_path: Path) -> None:
    """What the test above would see: a control."""
    trace, file = tmp_path / "trace", tmp_path / "part.msh"
    _mesh(file)
    planted = strangers.plant_beside(file, trace)
    with strangers.opened(planted) as opened, session("control"):
        gmsh.open(str(file))
    assert opened == {"part.msh.opt"}
    assert trace.exists()


@pytest.mark.parametrize("start", [b"$MeshFormX;", b"$MeshForma", b"$Comment;", b"", b"$MeshForm"])
def test_a_script_is_no_mesh(start: bytes, tmp_path: Path) -> None:
    """Gmsh compares eleven characters of $MeshFormat and nine of $Comments; it runs other files."""
    trace, file = tmp_path / "trace", tmp_path / "part.msh"
    file.write_bytes(start + f'\nSystemCall "touch {trace}";\n'.encode())
    with pytest.raises(MeshError, match=r"part\.msh: not a mesh of Gmsh; allowed: a file that"):
        files.read(file)
    assert not trace.exists()


LOAD = """
import importlib, sys
for name in sys.argv[1:]:
    importlib.import_module(name)
import dolfinx.jit, ffcx
ffcx.get_options(), dolfinx.jit.get_options()
"""


@pytest.mark.parametrize("with_the_package", [True, False])
def test_libraries_are_loaded_without_settings_of_the_working_folder(
    with_the_package: bool, tmp_path: Path
) -> None:
    """Alone, each of them reads its own, which is how the list is known to be right."""
    trace = tmp_path / "trace"
    planted = strangers.plant(tmp_path, trace, modules=False)
    ours = ["dolfingrip", "dolfingrip.mechanics.model.jit"] if with_the_package else []
    with strangers.opened(planted) as opened:
        ended = subprocess.run(
            [sys.executable, "-P", "-c", LOAD, *ours, *SETTINGS], cwd=tmp_path,
            capture_output=True, text=True, check=False,
        )  # fmt: skip
    told = {name for names in SETTINGS.values() for name in names.split(", ")}
    if with_the_package:
        assert ended.returncode == 0, ended.stderr
        assert not opened
    else:  # JSON that is none
        assert "JSONDecodeError" in ended.stderr
        assert opened - {"dolfinx_jit_options.json", "ffcx_options.json"} == told
        assert "ffcx_options.json" in opened


SPAWN = """
from multiprocessing import get_context
if __name__ == "__main__":
    process = get_context("spawn").Process(target=print)
    process.start()
    process.join()
"""


def test_workers_import_nothing_of_the_working_folder(tmp_path: Path) -> None:
    """A control first: Python's own way to start a process looks there before all else."""
    pytest.importorskip("distributed")
    trace, folder, script = tmp_path / "trace", tmp_path / "work", tmp_path / "spawn.py"
    folder.mkdir()
    script.write_text(SPAWN, encoding="utf-8")
    planted = strangers.plant(folder, trace)
    # a command that an earlier test has called in this process has set this
    plain = {name: text for name, text in os.environ.items() if name != "PYTHONSAFEPATH"}
    with strangers.opened(planted) as opened:
        subprocess.run(
            [sys.executable, script], cwd=folder, env=plain, capture_output=True, check=False
        )
    assert opened
    assert trace.exists()

    trace.unlink()
    command = [Path(sys.executable).with_name("dolfingrip"), "doe", "--points", "lhs"]
    with strangers.opened(planted) as opened:
        ended = subprocess.run(
            [*command, "--objective", "support.analytic:objective", "--number", "2",
             "--workers", "1"],
            cwd=folder, env={**plain, "PYTHONPATH": str(Path(__file__).parents[1])},
            capture_output=True, check=False,
        )  # fmt: skip
    assert ended.returncode == 0, ended.stderr
    assert not opened
    assert not trace.exists()
