"""Archives and XML of a stranger: what would fill the memory, or read other files, is refused."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile

import openpyxl
import pytest

from dolfingrip.config import ConfigError
from dolfingrip.design.gradient.curve import READERS
from dolfingrip.files.package import PackageError, PackagePolicy, opened
from dolfingrip.importing import cells
from dolfingrip.importing.told import Told
from dolfingrip.meshes import closed_surface, files
from dolfingrip.meshes.adoption.adopt import adopt
from dolfingrip.meshes.adoption.formats import triangles_of
from dolfingrip.meshes.adoption.roles import Asked
from dolfingrip.meshes.adoption.sizes import MeshRequest
from dolfingrip.meshes.solid import MeshError
from dolfingrip.report.fields import list_steps, read_grid

PARTS = Path(__file__).parents[1] / "meshes" / "parts"
MOST_BYTES = 50_000_000
"""Memory in which each of these files has to be refused; what they ask for is far more."""


@pytest.fixture(autouse=True)
def little_memory() -> object:
    tracemalloc.start()
    yield
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert most < MOST_BYTES


def _rewritten(source: Path, target: Path, change: Callable[[str, bytes], bytes]) -> None:
    """Write a package anew with each of its parts changed."""
    with ZipFile(source) as old, ZipFile(target, "w", ZIP_DEFLATED) as new:
        for part in old.namelist():
            new.writestr(part, change(part, old.read(part)))


def _book(file: Path, sheet: str = "", begins: str = "") -> None:
    """Write a workbook of a small table, with XML behind the rows of its sheet, and before all."""
    book = openpyxl.Workbook()
    for row in (("Time (s)", "Pressure (kPa)"), (0, 0), (1, 10), (2, 20)):
        book.active.append(row)
    plain = file.with_suffix(".plain")
    book.save(plain)

    def changed(part: str, content: bytes) -> bytes:
        if part == "xl/worksheets/sheet1.xml":
            assert b"</sheetData>" in content
            assert content.startswith(b"<worksheet")
            return begins.encode() + content.replace(
                b"</sheetData>", sheet.encode() or b"</sheetData>"
            )
        return content

    _rewritten(plain, file, changed)


def _import(file: Path) -> None:
    cells.read(file, Told())


def test_a_small_workbook_is_read(tmp_path: Path) -> None:
    _book(tmp_path / "table.xlsx")
    _import(tmp_path / "table.xlsx")


@pytest.mark.parametrize(
    ("sheet", "said"),
    [
        ('<row r="1048576"><c r="XFD1048576"><v>1</v></c></row></sheetData>', "1048576 rows by"),
        ('<row r="9999999"><c><v>1</v></c><c/><c/></row></sheetData>', "9999999 rows by"),
        ('</sheetData><mergeCells><mergeCell ref="A1:XFD9999"/></mergeCells>', "9999 rows by 16"),
    ],
)
def test_a_sheet_of_many_empty_cells(sheet: str, said: str, tmp_path: Path) -> None:
    file = tmp_path / "table.xlsx"
    _book(file, sheet)
    with pytest.raises(ConfigError, match=rf"{said}.*; allowed: up to 20000000 cells"):
        _import(file)


LAUGHS = (
    '<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a0 "ha">'
    + "".join(f'<!ENTITY a{i} "{f"&a{i - 1};" * 10}">' for i in range(1, 12))
    + "]>"
)
"""Entities of entities: 10¹¹ words."""


def entity(file: Path) -> str:
    """A document type by which a parser reads another file."""
    return f'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a11 SYSTEM "{file.as_uri()}">]>'


@pytest.fixture(params=["laughs", "another file"])
def document_type(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    secret = tmp_path / "secret"
    secret.write_text("7", encoding="utf-8")
    return LAUGHS if request.param == "laughs" else entity(secret)


NO_TYPE = "declares a document type; allowed: none"


def test_entities_of_a_workbook(document_type: str, tmp_path: Path) -> None:
    file = tmp_path / "table.xlsx"
    _book(file, begins=document_type)
    with pytest.raises(ConfigError, match=NO_TYPE):
        _import(file)


def test_entities_of_3mf(document_type: str, tmp_path: Path) -> None:
    def changed(part: str, content: bytes) -> bytes:
        if part.endswith(".model"):
            return document_type.encode() + content.partition(b"?>")[2]
        return content

    _rewritten(PARTS / "collared_tube.3mf", tmp_path / "part.3mf", changed)
    with pytest.raises(MeshError, match=NO_TYPE):
        triangles_of(tmp_path / "part.3mf", 1.0)


@pytest.mark.parametrize("of", ["itself", "others"])
def test_objects_of_objects(of: str, tmp_path: Path) -> None:
    """A 3MF file of a kilobyte that places 10¹¹ objects, or one within itself."""
    first = 1 if of == "itself" else 2
    objects = "".join(
        f'<object id="{i}"><components>'
        + f'<component objectid="{i - first + 1}"/>' * (1 if of == "itself" else 10)
        + "</components></object>"
        for i in range(1, 12)
    )
    space = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
    model = (
        f'<model unit="millimeter" xmlns="{space}"><resources><object id="0"><mesh>'
        '<vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/>'
        '<vertex x="0" y="1" z="0"/></vertices>'
        '<triangles><triangle v1="0" v2="1" v3="2"/></triangles></mesh></object>'
        f"{objects}</resources>"
        '<build><item objectid="11"/></build></model>'
    )
    with ZipFile(tmp_path / "part.3mf", "w") as packed:
        packed.writestr("3D/3dmodel.model", model)
    with pytest.raises(MeshError, match=r"more than 10000 objects|recursion"):
        triangles_of(tmp_path / "part.3mf", 1.0)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_entities_of_meshes_and_fields(document_type: str, encoding: str, tmp_path: Path) -> None:
    text = document_type + '<VTKFile type="UnstructuredGrid"><a>&a11;</a></VTKFile>'
    for name in ("part.vtu", "fields.pvd"):
        (tmp_path / name).write_text(text, encoding=encoding)
    with pytest.raises(MeshError, match=NO_TYPE):
        files.read(tmp_path / "part.vtu")
    with pytest.raises(MeshError, match=NO_TYPE):
        triangles_of(tmp_path / "part.vtu", 1.0)
    with pytest.raises(ValueError, match=NO_TYPE):
        read_grid(tmp_path / "part.vtu")
    with pytest.raises(ValueError, match=NO_TYPE):
        list_steps(tmp_path / "fields.pvd")


def test_entities_of_a_drawing(document_type: str, tmp_path: Path) -> None:
    """Drawing programs write document types; what they declare is not looked up, nor repeated."""
    pytest.importorskip("svgpathtools")
    file = tmp_path / "curve.svg"
    width, path = 'width="50mm" viewBox="0 0 50 50"', '<path d="M 0 0 L 0 50&a11;"/>'
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" {width}>{path}</svg>'
    file.write_text(document_type + svg, encoding="utf-8")
    with pytest.raises(ConfigError, match="not an SVG that can be read"):
        READERS[".svg"](file)


@pytest.mark.parametrize("file", ["steps.pkl", "steps.pickle", "steps.vtm", "steps"])
def test_a_collection_names_grids_alone(file: str, tmp_path: Path) -> None:
    """Older versions of pyvista unpickle a file by its ending."""
    (tmp_path / "fields.pvd").write_text(
        f'<VTKFile><Collection><DataSet timestep="0" file="{file}"/></Collection></VTKFile>'
    )
    with pytest.raises(ValueError, match=rf"{file}: allowed: \.vtu, \.pvtu"):
        list_steps(tmp_path / "fields.pvd")


POLICY = PackagePolicy(parts=5, unpacked_bytes=4_000_000, ratio=20, small_bytes=100_000)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ({f"{i}": b"x" for i in range(6)}, "archive of 6 parts; allowed: up to 5"),
        ({"a": bytes(5_000_000)}, "archive of 5 MB unpacked; allowed: up to 4 MB"),
        ({"a": bytes(200_000)}, r"unpacks to \d+ times its size; allowed: up to 20 times"),
    ],
)
def test_limits_of_packages(parts: dict[str, bytes], said: str, tmp_path: Path) -> None:
    file = tmp_path / "packed"
    with ZipFile(file, "w", ZIP_DEFLATED) as packed:
        for name, content in parts.items():
            packed.writestr(name, content)
    with pytest.raises(PackageError, match=said), opened(file, POLICY):
        pass


def test_a_table_of_contents_that_lies(tmp_path: Path) -> None:
    """A part holds more than the table says: no more than that is unpacked."""
    file, size = tmp_path / "packed", 3_000_000
    with ZipFile(file, "w", ZIP_DEFLATED) as packed:
        packed.writestr("a", bytes(size))
    data = file.read_bytes()
    true, false = size.to_bytes(4, "little"), (1000).to_bytes(4, "little")
    assert data.count(true) == 2  # in front of the part, and in the table
    file.write_bytes(data.replace(true, false))
    with pytest.raises(PackageError, match="damaged archive"), opened(file) as packed:
        packed.read("a")


def test_a_bomb(tmp_path: Path) -> None:
    """A few megabytes that unpack to more than half a gigabyte."""
    file = tmp_path / "bomb.3mf"
    with (
        ZipFile(file, "w", ZIP_DEFLATED, compresslevel=1) as packed,
        packed.open("3D/3dmodel.model", "w") as part,
    ):
        for _ in range(60):
            part.write(bytes(10_000_000))
    for read in (lambda file: triangles_of(file, 1.0), _import):
        with pytest.raises((MeshError, ConfigError), match="archive of 600 MB unpacked; allowed: "):
            read(file)


CRAFTED = {
    "HDF5": b"\x89HDF\r\n\x1a\n" + b"\0\0\0\0\0\x08\x08\0\x04\0\x10\0" + b"\xff" * 500,
    "a broken archive": b"PK\x03\x04" + b"\xff" * 500,
    "an empty archive": b"PK\x05\x06" + bytes(18),
    "a pickle": b"\x80\x04cos\nsystem\n(S'touch trace'\ntR." + bytes(200),
    "nothing": b"",
}
"""Files of formats that no reader has, by a name that it has."""


@pytest.mark.parametrize("content", CRAFTED)
@pytest.mark.parametrize(
    "kind",
    [".msh", ".inp", ".vtk", ".vtu", ".stl", ".obj", ".ply", ".3mf", ".csv", ".xlsx", ".svg",
     ".dxf", ".h5", ".hdf5", ".mat", ".pkl"],
)  # fmt: skip
def test_crafted_files_are_refused_in_one_line(
    content: str, kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / f"crafted{kind}"
    file.write_bytes(CRAFTED[content])
    reads: list[Callable[[Path], object]] = [
        files.read, lambda file: adopt(file, Asked(), MeshRequest()), _import, closed_surface.read,
    ]  # fmt: skip
    if kind in (".svg", ".dxf"):
        pytest.importorskip("ezdxf")
        reads.append(READERS[kind])
    for read in reads:
        with pytest.raises((MeshError, ConfigError)) as refused:
            read(file)
        assert "\n" not in str(refused.value)
        assert file.name in str(refused.value)
    assert not (tmp_path / "trace").exists()
