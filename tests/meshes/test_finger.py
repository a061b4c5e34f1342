"""The geometry: volumes, groups and their areas, against the closed form."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

from dolfingrip.config import Finger, Mesh
from dolfingrip.meshes.generate import finger_mesh
from dolfingrip.meshes.quality import check
from dolfingrip.meshes.solid import MeshError, SolidMesh

COARSE = Mesh(size_mm=10)


def volumes(finger: Finger) -> tuple[float, float]:
    """Volume of the whole finger's solid and of its cavity, mm³."""
    bellows = finger.bellows_intervals()
    roof = finger.base_layer_mm + finger.channel_mm
    gaps = sum(end - start for start, end in finger.gap_intervals())
    chambers = sum(end - start - 2 * finger.wall_mm for start, end in bellows)
    ends = bellows[0][0] + finger.wall_mm, bellows[-1][1] - finger.wall_mm
    between = ends[1] - ends[0] - chambers
    cavity = (
        chambers
        * finger.chamber_width_mm
        * (finger.depth_mm - finger.wall_mm - finger.base_layer_mm)
        + between * finger.channel_width * finger.channel_mm
    )
    above = finger.depth_mm - roof - finger.wall_mm
    box = finger.depth_mm * finger.width_mm * finger.length_mm
    return box - gaps * finger.width_mm * above - cavity, cavity


def random_finger(rng: np.random.Generator) -> Finger:
    """A finger of possible dimensions, far from the reference."""
    while True:
        try:
            return Finger(
                length_mm=rng.uniform(30, 150),
                width_mm=rng.uniform(8, 40),
                depth_mm=rng.uniform(8, 40),
                base_layer_mm=rng.uniform(0.8, 8),
                wall_mm=rng.uniform(0.5, 4),
                bellows=int(rng.integers(1, 15)),
                gap_mm=rng.uniform(0.5, 6),
                channel_mm=rng.uniform(0.5, 8),
                channel_width_mm=rng.choice([None, rng.uniform(1, 20)]),
                base_block_mm=rng.uniform(1, 30),
                tip_mm=rng.uniform(1, 20),
            )
        except ValidationError:
            continue


def area(mesh: SolidMesh, name: str) -> float:
    x = mesh.points[mesh.facets[name][:, :3]]
    return float(np.linalg.norm(np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]), axis=1).sum() / 2)


@pytest.mark.parametrize(
    "finger",
    [
        Finger(),
        Finger(channel_width_mm=4.0),
        Finger(bellows=1),
        Finger(bellows=2, channel_mm=9.0),
        Finger(bellows=30, length_mm=300.0),
    ],
    ids=["reference", "narrow channel", "one bellows", "high channel", "thirty bellows"],
)
def test_volumes_are_those_of_the_dimensions(finger: Finger) -> None:
    solid, cavity = volumes(finger)
    whole = check(finger_mesh(finger, Mesh(half=False, size_mm=10)))
    half = check(finger_mesh(finger, COARSE))
    assert whole.volume_mm3 == pytest.approx(solid, rel=1e-9)
    assert whole.cavity_mm3 == pytest.approx(cavity, rel=1e-9)
    assert half.volume_mm3 == pytest.approx(solid / 2, rel=1e-9)
    assert half.cavity_mm3 == pytest.approx(cavity / 2, rel=1e-9)


def test_areas_of_the_groups() -> None:
    finger = Finger()
    mesh = finger_mesh(finger, COARSE)
    end = finger.depth_mm * finger.width_mm / 2
    gap_height = finger.depth_mm - finger.base_layer_mm - finger.channel_mm - finger.wall_mm
    gap_profile = finger.bellows * finger.gap_mm * gap_height
    inner_height = finger.depth_mm - finger.wall_mm - finger.base_layer_mm
    chamber = finger.bellows_mm - 2 * finger.wall_mm
    bridge = finger.pitch_mm - chamber
    cavity_profile = (
        finger.bellows * chamber * inner_height + (finger.bellows - 1) * bridge * finger.channel_mm
    )
    side = finger.depth_mm * finger.length_mm - gap_profile
    back_and_crown = finger.length_mm * finger.width_mm  # a gap's foot is its missing crown
    gap_faces = 2 * finger.bellows * gap_height * finger.width_mm / 2
    assert area(mesh, "clamp") == pytest.approx(end)
    assert area(mesh, "tip") == pytest.approx(end)
    assert area(mesh, "symmetry") == pytest.approx(side - cavity_profile)
    assert area(mesh, "skin") == pytest.approx(side + back_and_crown + gap_faces)
    length = finger.bellows * chamber + (finger.bellows - 1) * bridge
    walls = (
        2 * length
        + 2 * inner_height
        + 2 * (finger.bellows - 1) * (inner_height - finger.channel_mm)
    )
    assert area(mesh, "cavity") == pytest.approx(
        cavity_profile + walls * finger.chamber_width_mm / 2
    )


def test_place_of_the_groups() -> None:
    mesh = finger_mesh(Finger(), COARSE)
    for name, axis, value in (("clamp", 2, 0.0), ("tip", 2, 90.0), ("symmetry", 1, 0.0)):
        assert np.abs(mesh.points[mesh.facets[name], axis] - value).max() < 1e-9
    assert mesh.points.min(axis=0) == pytest.approx([0, 0, 0], abs=1e-9)
    assert mesh.points.max(axis=0) == pytest.approx([16, 10, 90])
    assert "symmetry" not in finger_mesh(Finger(), Mesh(half=False, size_mm=10)).facets


def test_bellows_lie_between_base_block_and_tip() -> None:
    finger = Finger()
    bellows = finger.bellows_intervals()
    assert len(bellows) == finger.bellows
    assert bellows[0][0] >= finger.base_block_mm
    assert bellows[-1][1] <= finger.length_mm - finger.tip_mm
    assert all(end - start == pytest.approx(finger.bellows_mm) for start, end in bellows)


@pytest.mark.parametrize("seed", range(8))
def test_random_fingers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    finger = random_finger(rng)
    half, order = bool(rng.integers(2)), int(rng.integers(1, 3))
    size = finger.depth_mm / 3
    print(f"seed {seed}: {finger}")
    resolution = {"half": half, "order": order, "size_mm": size, "edge_size_mm": size / 2}
    quality = check(finger_mesh(finger, Mesh.model_validate(resolution)))
    parts = 2 if half else 1
    expected = [volume / parts for volume in volumes(finger)]
    assert [quality.volume_mm3, quality.cavity_mm3] == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("key", ["wall_mm", "gap_mm", "channel_mm", "base_layer_mm", "tip_mm"])
def test_too_thin_to_be_modelled(key: str) -> None:
    with pytest.raises(MeshError, match=rf"^finger\.{key} = 0\.001: .* at least 0\.01 mm$"):
        finger_mesh(Finger.model_validate({key: 1e-3}), COARSE)
