"""Food as rigid bodies: mass, inertia, and that skin and distance are of one shape."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dolfingrip.config import Config
from dolfingrip.experiments.rigs.food import GraspedBody, grasped, halved
from dolfingrip.foods.food import Food
from dolfingrip.sections.errors import ConfigError, checked

KINDS = (
    "cube", "sausage-short", "sausage-long", "potato-small", "potato-large", "strawberry"
)  # fmt: skip


def lowest_mm(found: GraspedBody) -> float:
    """Of the skin, where it is put."""
    return float(found.surface.points[:, 2].min() + found.body.centre_mm[2])


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_stands_on_the_table(kind: str) -> None:
    food = Food(kind=kind)  # type: ignore[arg-type]
    found = grasped(food)
    skin = found.surface
    assert np.abs(found.shape.at(skin.points).value).max() < 1e-6
    assert lowest_mm(found) == pytest.approx(0, abs=1e-9)
    bump = 2 * food.bump_mm if kind.startswith("potato") else 0.0
    np.testing.assert_allclose(np.ptp(skin.points, axis=0), food.size_mm, atol=bump + 0.1)
    assert np.abs(skin.centre_mm).max() < 0.01


@pytest.mark.parametrize(("kind", "grams", "within"), [
    ("sausage-short", 16, 0.1), ("potato-small", 170, 0.02), ("potato-large", 369, 0.02),
    ("strawberry", 27, 0.02),
])  # fmt: skip
def test_ordinary_masses(kind: str, grams: float, within: float) -> None:
    """As USDA lists them."""
    found = grasped(Food(kind=kind))  # type: ignore[arg-type]
    assert 1e3 * found.body.mass_kg == pytest.approx(grams, rel=within)


def test_closed_forms() -> None:
    """A capsule's and, but for its edges, a cube's."""
    capsule = grasped(Food(kind="sausage-short", width_mm=20.0, length_mm=60.0, height_mm=20.0))
    volume = np.pi * 100 * 40 + 4 / 3 * np.pi * 1000
    assert capsule.body.mass_kg == pytest.approx(1040e-9 * volume, rel=5e-3)
    cube = grasped(Food(edge_radius_mm=0.2))
    mass = 1080e-9 * 33 * 33 * 32
    assert cube.body.mass_kg == pytest.approx(mass, rel=2e-3)
    wanted = mass / 12 * np.diag([33**2 + 32**2, 33**2 + 32**2, 2 * 33**2])
    np.testing.assert_allclose(cube.body.inertia_kg_mm2, wanted, rtol=5e-3, atol=1e-6)


def test_a_bent_sausage_lies_flat() -> None:
    """Its bend is in the plane of the table; its centre of gravity is where it is put."""
    found = grasped(Food(kind="sausage-long", bend_radius_mm=80.0, turn_deg=30.0))
    assert np.ptp(found.surface.points[:, 2]) == pytest.approx(22.2, abs=0.05)
    assert np.abs(found.surface.centre_mm).max() < 0.02


@pytest.mark.parametrize("height_mm", [38.4, 30.0])
def test_a_strawberry_lies_still_on_its_flank(height_mm: float) -> None:
    """Its centre of gravity is above the point that it lies on, and half of it is computed."""
    found = grasped(Food(kind="strawberry", height_mm=height_mm))
    points = found.surface.points
    low = points[points[:, 2] < points[:, 2].min() + 0.05]
    assert np.abs(low.mean(axis=0)[:2]).max() < 0.3
    tilted = Rotation.from_euler("y", [-5, 5], degrees=True)
    heights = [-turn.apply(points)[:, 2].min() for turn in tilted]
    assert min(heights) > -points[:, 2].min() + 0.05  # a turn to either side lifts the centre
    assert halved(Config(), found)


def test_a_file(tmp_path: Path) -> None:
    """An STL cube, its edges rounded off: flat faces stay where they are."""
    path = tmp_path / "cube.stl"
    import pyvista as pv

    pv.Cube(center=(5, 5, 5), x_length=30, y_length=30, z_length=30).triangulate().clean().save(
        path
    )
    found = grasped(Food(kind="file", file=path))
    assert found.body.mass_kg == pytest.approx(27e-3, rel=0.02)
    at = np.array([[15.0, 0, 0], [0, -15, 3], [2, 1, 15]])
    assert np.abs(found.shape.at(at).value).max() < 0.05
    corner = found.shape.at(np.full((1, 3), 15.0)).value
    assert 0.2 < corner[0] < 2.0


@pytest.mark.parametrize(("given", "said"), [
    ({"kind": "file"}, "file = none: allowed: a path"),
    ({"kind": "cube", "edge_radius_mm": 17.0}, "edge_radius_mm = 17.0: allowed: above 0 and up"),
    ({"kind": "sausage-long", "bend_radius_mm": 10.0}, "bend_radius_mm = 10.0: allowed: at least"),
    ({"kind": "sausage-long", "length_mm": 20.0}, "length_mm = 20.0: allowed: above width_mm"),
    ({"kind": "potato-small", "bump_mm": 9.0}, "bump_mm = 9.0: allowed: at least 0 and up to 7.5"),
])  # fmt: skip
def test_impossible_food(given: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        checked(Food, given)
