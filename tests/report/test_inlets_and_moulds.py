"""Air inlets and moulds: closed, thick enough to be printed, and of the volume that they must have.

References: volumes of cylinders and boxes by hand, and which points lie in a design's boxes. The
files are read by PyVista, which shares no code with OpenCASCADE.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
from support.command import run_command

from dolfingrip import config
from dolfingrip.config import Config, ConfigError
from dolfingrip.meshes import closed_surface
from dolfingrip.meshes.closed_surface import ClosedSurface
from dolfingrip.meshes.mould import COMES_OFF
from dolfingrip.report import printable
from dolfingrip.sections.geometry.boxes import Box, BoxSolid
from dolfingrip.sections.tables import assignments

COARSE = ("mesh.size_mm=8", "mesh.edge_size_mm=8")
SHORT = ("finger.length_mm=38", "finger.bellows=2", *COARSE)
ROUND = ("finger.kind=round_bellows", "round_bellows.convolutions=2", "solver.element=P2")
CAST = ("finger.kind=cast", "cast.chambers=2", *COARSE)
PNEUNET = ("finger.kind=pneunet", "pneunet.chambers=2", "pneunet.gap_mm=1.6", *COARSE)
MOULDED = {"cast": CAST, "pneunet": (*PNEUNET, "pneunet.tube=true")}


def configured(*texts: str) -> Config:
    return config.load(None, assignments(texts))


def read(file: Path) -> ClosedSurface:
    """Triangles of a file, which must be one closed surface."""
    found = pv.read(file).clean()
    assert found.is_manifold
    assert found.n_open_edges == 0
    assert found.split_bodies().n_blocks == 1
    return closed_surface.read(file)


@pytest.mark.parametrize(
    ("design", "cavities", "block_mm", "own_mm", "place"),
    [
        (SHORT, 1, 13.6, 1.6, "clamp"),
        ((*SHORT, "finger.tube_mm=2"), 1, 13.6, 1.6, "side"),
        (ROUND, 2, 5.0, 0.8, "side"),
        ((*CAST, "cast.tube=true"), 1, 7.0, 0.5, "clamp"),
        (PNEUNET, 1, 11.5, 1.5, "clamp"),
    ],
)
def test_an_inlet_reaches_every_cavity(
    tmp_path: Path, design: tuple[str, ...], cavities: int, block_mm: float, own_mm: float,
    place: str,
) -> None:  # fmt: skip
    """A tube of 1 mm bore: what it adds outside, and what its bore takes from the block."""
    shut = configured(*design)
    if opening := next((text for text in design if ".tube" in text), ""):
        key = opening.partition("=")[0]
        shut = configured(*design, f"{key}={'0' if key.endswith('_mm') else 'false'}")
    sealed = printable.write(shut, tmp_path / "sealed.step")
    assert sealed.voids == cavities
    size = ("inlet.bore_mm=1.0", "inlet.wall_mm=1.5", "inlet.length_mm=9", f"inlet.place={place}")
    plain = configured(*design, *size, "inlet.kind=tube")
    written = printable.write(plain, tmp_path / "open.stl")
    length, corner = block_mm, 0.0
    if place == "side":  # a quarter of a ball less a quarter of what two bores share
        length = block_mm / 2 + plain.geometry.width_mm / 2
        corner = (math.pi - 4) / 3 * 0.5**3
    change = math.pi * (2.0**2 * 9 - 0.5**2 * (length + 9)) - corner
    assert (written.volume_mm3 - sealed.volume_mm3) / cavities == pytest.approx(change, abs=1e-3)
    assert written.voids == 0
    assert written.wall is not None
    flat_mm = 12.5 * (1 - math.cos(math.pi / 32))  # plane triangles on the roundest wall
    assert written.wall.mm == pytest.approx(min(own_mm, 1.5), abs=flat_mm)
    surface = read(tmp_path / "open.stl")
    assert surface.volume_mm3 == pytest.approx(written.volume_mm3, rel=2e-3)


def test_air_comes_in_along_the_bore(tmp_path: Path) -> None:
    printable.write(configured(*SHORT, "inlet.kind=barb"), tmp_path / "a.stl")
    surface = read(tmp_path / "a.stl")
    x = (3.5 + 16 - 1.6) / 2  # amid the first bellows' chamber
    along = np.linspace(-14, 15, 200)
    axis = np.stack([np.full(200, x), np.zeros(200), along], axis=1)
    assert (surface.distances_mm(axis) > 0).all()
    beside = axis + np.array([0.0, 1.8, 0.0])  # in the wall around it
    solid = surface.distances_mm(beside) < 0
    assert solid[(along > -11.9) & (along < 13.5)].all()


@pytest.mark.parametrize("kind", MOULDED)
def test_each_part_comes_off_in_its_turn(tmp_path: Path, kind: str) -> None:
    """Points of what is left, moved against the part that is pulled, never lie in it."""
    printable.write_mould(configured(*MOULDED[kind], "mould.clearance_mm=0"), tmp_path)
    parts = {name: read(tmp_path / f"{name}.stl") for name in COMES_OFF}
    boxes = configured(*MOULDED[kind]).geometry.solid()
    assert isinstance(boxes, BoxSolid)
    floor = min(x[0] for x, _, _ in boxes.cavity)
    high, wide, long = (end for _, end in boxes.body)
    seed = 5
    print("seed", seed)
    low, top = (floor - 4, -wide - 8, -8), (high, wide + 8, long + 8)
    places = np.random.default_rng(seed).uniform(low, top, (1500, 3))
    solid = {name: part.distances_mm(places) < 0 for name, part in parts.items()}
    of_mould = solid["core_plate"] | solid["half_1"] | solid["half_2"]
    cast = inside(places, ((floor, high), *boxes.body[1:])) & ~of_mould
    base = inside(places, ((0.0, floor), *boxes.body[1:])) & ~solid["base_tray"]

    def hits(name: str, left: np.ndarray) -> int:
        """Points of what is left that the part meets on its way."""
        way = np.array(COMES_OFF[name])
        moved = [places[left] - way * mm for mm in (0.5, 1.5, 3.0, 5.0, 8.0, 12.0)]
        return int((parts[name].distances_mm(np.concatenate(moved)) < 0).sum())

    left = {"core_plate", "half_1", "half_2"}
    for name in COMES_OFF:
        if name == "base_tray":  # which holds the base alone
            assert hits(name, base) == 0
            continue
        left.discard(name)
        assert hits(name, np.any([cast, *(solid[each] for each in left)], axis=0)) == 0
    assert hits("half_1", solid["core_plate"]) > 0  # so the plate has to be off before


@pytest.mark.parametrize("draft_deg", [0.0, 1.0])
@pytest.mark.parametrize("kind", MOULDED)
def test_mould_and_cast_fill_the_box(tmp_path: Path, kind: str, draft_deg: float) -> None:
    design = configured(*MOULDED[kind], f"mould.draft_deg={draft_deg}", "mould.clearance_mm=0")
    made = printable.write_mould(design, tmp_path)
    names = ["base_tray", "core_plate", "half_1", "half_2"]
    assert sorted(file.name for file in tmp_path.iterdir()) == [f"{name}.stl" for name in names]
    parts = {name: read(tmp_path / f"{name}.stl") for name in names}
    for name, part in parts.items():
        known = made.parts[tmp_path / f"{name}.stl"]
        assert part.volume_mm3 == pytest.approx(known.volume_mm3, rel=1e-5)
        assert known.voids == 0
        assert known.wall is not None
        assert known.wall.mm >= 1.2
    boxes = design.geometry.solid()
    assert isinstance(boxes, BoxSolid)
    floor, wall = min(x[0] for x, _, _ in boxes.cavity), 4.0
    high, wide, long = (end for _, end in boxes.body)
    block = (high - floor) * (2 * wide + 2 * wall) * (long + 2 * wall)
    outer = (2 * wide + 4 * wall) * (long + 4 * wall)
    plate_and_rim = outer * wall + (outer - block / (high - floor)) * 2 * wall
    together = sum(parts[name].volume_mm3 for name in names[1:]) + made.body_mm3
    assert together == pytest.approx(block + plate_and_rim, rel=1e-6)
    tray = (2 * wide + 2 * wall) * (long + 2 * wall) * (floor + wall)
    assert parts["base_tray"].volume_mm3 + made.base_mm3 == pytest.approx(tray, rel=1e-6)

    seed = 48
    print("seed", seed)
    places = np.random.default_rng(seed).uniform(
        (floor, -wide - wall, -wall), (high, wide + wall, long + wall), (4000, 3)
    )
    in_parts = np.array([parts[name].distances_mm(places) < 0 for name in names[1:]])
    cast = inside(places, boxes.body) & ~any_of(places, [*boxes.cavity, *boxes.gaps])
    if draft_deg:  # walls move by up to half of what the draft makes over the width
        most = math.tan(math.radians(draft_deg)) * max(high - floor, wide) / 2
        assert (in_parts.sum(axis=0) + cast != 1).mean() < 6 * most / min(high - floor, wide)
        assert (in_parts.sum(axis=0) <= 1).all()
    else:
        assert (in_parts.sum(axis=0) + cast == 1).all()


def inside(places: np.ndarray, box: Box) -> np.ndarray:
    low, high = np.array(box).T
    return np.asarray(((places > low) & (places < high)).all(axis=1))


def any_of(places: np.ndarray, boxes: list[Box]) -> np.ndarray:
    return np.asarray(np.any([inside(places, box) for box in boxes], axis=0))


@pytest.mark.parametrize("kind", MOULDED)
def test_parts_come_off(tmp_path: Path, kind: str) -> None:
    """Every face on the silicone opens by the draft, as its part is pulled off."""
    printable.write_mould(configured(*MOULDED[kind]), tmp_path)
    boxes = configured(*MOULDED[kind]).geometry.solid()
    assert isinstance(boxes, BoxSolid)
    floor, least = min(x[0] for x, _, _ in boxes.cavity), math.sin(math.radians(1.0))
    end = boxes.body[2][1]
    for name, axis, sign in (("half_1", 1, 1), ("half_2", 1, -1), ("core_plate", 0, 1)):
        part = pv.read(tmp_path / f"{name}.stl").compute_normals(auto_orient_normals=False)
        middle, normal = part.cell_centers().points, part.cell_normals
        on = (middle[:, 2] > -0.2) & (middle[:, 2] < end + 0.2)
        on &= np.abs(middle[:, 1]) < boxes.body[1][1] + 1e-3
        on &= (middle[:, 0] > floor + 1e-3) & (middle[:, 0] < boxes.body[0][1] - 1e-3)
        on &= np.abs(middle[:, 1]) > 1e-3 if axis == 1 else middle[:, 2] > 0.2
        assert on.sum() > 10
        assert (sign * normal[on, axis] > least - 1e-4).all()


def test_the_thinnest_core(tmp_path: Path) -> None:
    """A blade 2 mm thick and 8 mm high loses tan 1° · 8 mm of its thickness at its edge."""
    made = printable.write_mould(configured(*CAST), tmp_path)
    wall = made.parts[tmp_path / "core_plate.stl"].wall
    assert wall is not None
    assert wall.mm == pytest.approx(2 - 8 * math.tan(math.radians(1)), abs=0.02)


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        ((*SHORT, "inlet.bore_mm=12"), r"inlet\.bore_mm = 12: wider .* up to 10\.9 mm"),
        ((*SHORT, "inlet.x_mm=15"), r"inlet\.x_mm = 15: beside .* 4\.5 to 13\.4 mm"),
        ((*SHORT, "inlet.place=side", "inlet.z_mm=2"), r"inlet\.z_mm = 2: .* between 3\.2 mm"),
        (
            (*ROUND, "inlet.kind=barb", "morph.xi1=0.2"),
            r"inlet: \[morph\] flattens .* without \[inlet\]",
        ),
    ],
)
def test_no_room_for_an_inlet(tmp_path: Path, texts: tuple[str, ...], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        printable.write(configured(*texts), tmp_path / "a.stl")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        (SHORT, r'finger\.kind = "bellows": not cast; allowed with --mould: cast, pneunet'),
        ((*PNEUNET, "pneunet.gap_mm=1.0"), r"half_1\.stl would have a wall of 0\.8\d* mm"),
        ((*CAST, "mould.split_mm=11"), r"mould\.split_mm = 11: .* below 11 mm"),
    ],
)
def test_no_mould(tmp_path: Path, texts: tuple[str, ...], reason: str) -> None:
    with pytest.raises(ConfigError, match=reason):
        printable.write_mould(configured(*texts), tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_command(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    options = [text for each in PNEUNET for text in ("--set", each)]
    file, folder = tmp_path / "a.stl", tmp_path / "mould"
    assert run_command("export", str(file), "--mould", str(folder), *options) == 0
    said = capfd.readouterr().out.splitlines()
    assert said[0].endswith("1 sealed void: [inlet] lets air in")
    assert "silicone: " in said[-2]
    assert said[-1].endswith("--set pneunet.tube=true leaves room for a hose")
    assert run_command("export", *options) == 2
    assert "FILE: none; allowed" in capfd.readouterr().err
