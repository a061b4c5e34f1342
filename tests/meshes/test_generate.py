"""Sizes, grading, the target number of elements, and the use of Gmsh."""

from __future__ import annotations

import math
import threading

import gmsh
import numpy as np
import pytest

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes import solid_model
from dolfingrip.meshes.generate import concave_curves, finger_mesh, meet
from dolfingrip.meshes.gmsh_model import session
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

COARSE = Mesh(size_mm=10)


def equal(first: SolidMesh, second: SolidMesh) -> bool:
    return (
        np.array_equal(first.points, second.points)
        and np.array_equal(first.cells, second.cells)
        and all(np.array_equal(f, second.facets[name]) for name, f in first.facets.items())
    )


@pytest.mark.parametrize(
    ("target", "resolution"),
    [
        (35140, {"half": False}),
        (5000, {}),
        (3500, {"size_mm": 6.0, "edge_size_mm": 2.0}),
        (1500, {"order": 2}),
    ],
)
def test_target_number_of_elements(target: int, resolution: dict[str, object]) -> None:
    mesh = finger_mesh(Finger(), Mesh.model_validate({"target_elements": target, **resolution}))
    assert len(mesh.cells) == pytest.approx(target, rel=0.01)
    assert mesh.order == resolution.get("order", 1)
    assert check(mesh).scaled_jacobian_min > 0.05


def test_target_out_of_reach_names_the_nearest() -> None:
    with pytest.raises(MeshError, match=r"^mesh\.target_elements = 100: .* nearest allowed: \d+$"):
        finger_mesh(Finger(), Mesh(target_elements=100))


def test_target_between_two_counts_is_met_along_the_finger() -> None:
    def jumping(near: float, far: float, share: float) -> int:
        """A count that one size cannot bring near 1000."""
        each = [1500 if math.log(size) < 0.3 else 500 for size in (near, far)]
        return round(share * each[0] + (1 - share) * each[1])

    counts: list[int] = []

    def mesh(near: float, far: float, share: float) -> int:
        counts.append(jumping(near, far, share))
        return counts[-1]

    meet(1000, mesh)
    assert counts[-1] == pytest.approx(1000, rel=0.01)


def test_same_input_same_mesh() -> None:
    resolution = Mesh(size_mm=6, edge_size_mm=3, order=2)
    assert equal(finger_mesh(Finger(), resolution), finger_mesh(Finger(), resolution))


def test_concave_edges_are_those_of_cavity_and_gap_feet() -> None:
    finger = Finger(bellows=3)
    with session("test"):
        solid_model.build(finger, half=True)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 6)
        gmsh.model.mesh.generate(3)
        middles = [gmsh.model.occ.getCenterOfMass(1, curve) for curve in concave_curves()]
    roof = finger.base_layer_mm + finger.channel_mm
    foot, crown = roof + finger.wall_mm, finger.depth_mm - finger.wall_mm
    heights = sorted(round(x, 6) for x, _, _ in middles)
    expected = (
        # floor: along the side and across both ends of the cavity
        [finger.base_layer_mm] * 3
        # roof of the channel: along the side of each of two bridges
        + [roof] * 2
        # feet of the gaps: two across each
        + [foot] * 6
        # crown of each chamber: along the side and across both ends
        + [crown] * 9
        # upright corners of each chamber: those at the cavity's ends reach to the floor
        + [(finger.base_layer_mm + crown) / 2] * 2
        + [(roof + crown) / 2] * 4
    )
    assert heights == pytest.approx(sorted(expected))


def test_grading_refines_at_concave_edges_only() -> None:
    finger = Finger()
    graded = finger_mesh(finger, Mesh(size_mm=6, edge_size_mm=1.5))
    corners = graded.points[graded.cells]
    size = np.cbrt(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    centre = corners.mean(axis=1)
    foot = finger.base_layer_mm + finger.channel_mm + finger.wall_mm
    gap = finger.base_block_mm + finger.bellows_mm
    near = np.hypot(centre[:, 0] - foot, centre[:, 2] - gap) < 0.8
    block = centre[:, 2] < 0.6 * finger.base_block_mm
    assert np.median(size[block]) > 2 * np.median(size[near])


@pytest.mark.parametrize(("key", "value"), [("size_mm", 0.01), ("edge_size_mm", 1e-3)])
def test_sizes_that_would_fill_the_memory(key: str, value: float) -> None:
    with pytest.raises(MeshError, match=rf"^mesh\.{key} = {value}: .* allowed: at least"):
        finger_mesh(Finger(), Mesh.model_validate({key: value}))


def test_off_the_main_thread() -> None:
    found: list[SolidMesh] = []
    thread = threading.Thread(target=lambda: found.append(finger_mesh(Finger(), COARSE)))
    thread.start()
    thread.join()
    assert equal(found[0], finger_mesh(Finger(), COARSE))


def test_a_session_of_the_caller_is_left_as_it_was() -> None:
    alone = finger_mesh(Finger(), COARSE)
    gmsh.initialize([], readConfigFiles=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.Algorithm3D", 10)
        gmsh.model.add("caller")
        assert equal(finger_mesh(Finger(), COARSE), alone)
        assert gmsh.model.getCurrent() == "caller"
        assert gmsh.option.getNumber("Mesh.Algorithm3D") == 10
    finally:
        gmsh.finalize()


def test_gmsh_errors_are_one_line_and_end_the_session() -> None:
    with pytest.raises(MeshError, match=r"^reading: [^\n]+$"), session("reading"):
        gmsh.open("/nowhere/finger.msh")
    assert not gmsh.isInitialized()


def test_other_errors_pass_through() -> None:
    with pytest.raises(KeyError), session("test"):
        raise KeyError("mine")
    assert not gmsh.isInitialized()
