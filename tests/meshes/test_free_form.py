"""Free form: planes that are bent, and the walls between them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import cKDTree
from support.small import short

from dolfingrip.config import Config, ConfigError, changed
from dolfingrip.experiments.rigs.perturbation import velocities
from dolfingrip.experiments.rigs.undeformed import placed, solid, straight, unplaced
from dolfingrip.meshes.measures import moment_gradients, moments, scaled_jacobians
from dolfingrip.meshes.walls import facing
from dolfingrip.parameter import Entry, every
from dolfingrip.sections.form import Form
from dolfingrip.sections.tables import assignments

SEED = 12


def bent(most_mm: float, *overrides: str, contact_face: bool = False) -> Config:
    """A short finger with random offsets."""
    config = short("morph.xi1=0.1", "morph.xi2=-0.1", *overrides)
    form = Form(along=4, contact_face=contact_face, offsets_mm=())
    count = form.count(config.geometry.solid())
    print("seed", SEED)
    offsets = np.random.default_rng(SEED).uniform(-most_mm, most_mm, count)
    return config.changed(form=form.model_dump() | {"offsets_mm": offsets.tolist()})


@pytest.mark.parametrize("contact_face", [False, True])
def test_points_come_back(contact_face: bool) -> None:
    config = bent(0.4, "mesh.half=false", contact_face=contact_face)
    points = straight(config).points
    np.testing.assert_allclose(unplaced(placed(points, config), config), points, atol=1e-12)


def test_the_contact_face_is_bent_where_it_is_asked_for() -> None:
    """By the first offsets: at its middle the first half of them, at its edges the second."""
    config = short("mesh.half=false")
    form = Form(along=4, contact_face=True, offsets_mm=())
    count = form.count(config.geometry.solid())
    offsets = [0.3] * 4 + [-0.2] * 4 + [0.0] * (count - 8)
    bent = config.changed(form=form.model_dump() | {"offsets_mm": offsets})
    before = straight(bent).points
    after = placed(before, bent)
    face = np.abs(before[:, 0]) < 1e-9
    half_mm = config.geometry.solid().body[1][1]
    share = (before[face, 1] / half_mm) ** 2
    np.testing.assert_allclose(after[face, 0], 0.3 * (1 - share) - 0.2 * share, atol=1e-12)
    roof = before[:, 0] > before[:, 0].max() - 1e-9
    np.testing.assert_array_equal(after[roof], before[roof])


def test_what_stays_and_what_is_mirrored() -> None:
    config = bent(0.4, "mesh.half=false")
    before, after = straight(config).points, placed(straight(config).points, config)
    length = config.geometry.length_mm
    for axis, place in ((0, 0.0), (2, 0.0), (2, length), (1, 0.0)):
        on_plane = np.abs(before[:, axis] - place) < 1e-9
        assert np.abs(after[on_plane, axis] - place).max(initial=0.0) < 1e-12
    mirror = before * [1, -1, 1]
    np.testing.assert_allclose(placed(mirror, config), after * [1, -1, 1], atol=1e-12)


def test_velocities_are_those_of_the_points() -> None:
    config = bent(0.3)
    points = straight(config).points
    parameters = [each for each in every(config) if each.entry is Entry.SHAPE]
    found = velocities(parameters, config, points)
    for each in parameters[:: max(len(parameters) // 12, 1)]:
        step, here = 1e-5, each.value(config)
        ends = []
        for sign in (1, -1):
            changed = each.at(config, here + sign * step)
            moved = straight(changed, config.geometry).points
            ends.append(placed(moved, changed))
        expected = (ends[0] - ends[1]) / (2 * step)
        np.testing.assert_allclose(found[each.key], expected, atol=1e-7, err_msg=each.key)


def test_cells_stay_good_and_are_those_of_the_dimensions_they_were_made_for() -> None:
    config = bent(0.4)
    mesh = solid(config)
    assert scaled_jacobians(mesh).min() > 0.9
    thinner = changed(config, assignments(["finger.wall_mm=1.2"]))
    assert len(solid(thinner, config.geometry).points) == len(mesh.points)


def test_moments_follow_their_gradients() -> None:
    mesh = solid(bent(0.3))
    moving = np.random.default_rng(SEED).normal(size=mesh.points.shape)
    by_volume, by_moment = moment_gradients(mesh)
    step, ends = 1e-6, []
    for sign in (1, -1):
        mesh.points[:] += sign * step * moving
        ends.append(moments(mesh))
        mesh.points[:] -= sign * step * moving
    (more, far), (less, near) = ends
    assert np.vdot(by_volume, moving) == pytest.approx((more - less) / (2 * step), rel=1e-6)
    along = np.tensordot(by_moment, moving, axes=([1, 2], [0, 1]))
    np.testing.assert_allclose(along, (far - near) / (2 * step), rtol=1e-5)


def test_the_least_wall_is_the_distance_of_the_surfaces() -> None:
    """Against points spread densely over the cavity and the skin, which stay 0.1 mm apart."""
    config = bent(0.3)
    walls, *_ = facing(config.geometry, config.mesh)
    corners = placed(walls.corners.reshape(-1, 3), config).reshape(walls.corners.shape)
    least = walls.distances(corners).min()
    mesh = solid(config)
    clouds = [_spread(mesh.points[mesh.facets[name]]) for name in ("cavity", "skin")]
    expected = cKDTree(clouds[1]).query(clouds[0])[0].min()
    print("least wall", least, "distance of the surfaces", expected)
    assert least == pytest.approx(expected, rel=0.02)


def _spread(quads: np.ndarray) -> np.ndarray:
    """Points over bilinear quadrilaterals (k, 4, 3)."""
    s, t = (each.ravel() for each in np.meshgrid(*[np.linspace(0, 1, 41)] * 2))
    shapes = np.stack([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t])
    return np.einsum("cq,kci->kqi", shapes, quads).reshape(-1, 3)


@pytest.mark.parametrize(
    ("offsets", "said"),
    [
        ([0.0] * 7, "form.offsets_mm = 7 numbers: allowed: "),
        (["a"], "form.offsets_mm"),
    ],
)
def test_bad_offsets_get_one_line(offsets: list[object], said: str) -> None:
    with pytest.raises(ConfigError, match=said) as caught:
        short().changed(form={"offsets_mm": offsets})
    assert "\n" not in str(caught.value)
