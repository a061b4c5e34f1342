"""What is found in frames whose contents are known: sheet, plane, dots, tags, identity, order."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest
from support.filmed import RED, Filmed, arc

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import dots, order, plane
from dolfingrip.tracking.follow import Follower
from dolfingrip.tracking.sheet import SHEETS
from dolfingrip.tracking.tags import Tags


def fitted(camera: Filmed, image: np.ndarray) -> plane.Calibration:
    """The camera of a frame by the sheet in it."""
    return plane.of_sheet(camera.size_px, *SHEETS["a4"].find(image), (camera.front_mm, 0.5))


def learnt(image: np.ndarray, count: int | None = None, groups: int = 1) -> np.ndarray:
    """Places of the dots that are found, from above."""
    places = dots.learn(image, None, count, groups, None)[1]
    return places[np.argsort(places[:, 1])]


@pytest.mark.parametrize("paper", SHEETS)
def test_a_page_has_the_papers_size_and_a_corner_its_place(tmp_path: Path, paper: str) -> None:
    sheet = SHEETS[paper]
    sheet.write(tmp_path / "sheet.pdf")
    written = (tmp_path / "sheet.pdf").read_bytes()
    box = written.split(b"/MediaBox [")[1].split(b"]")[0].split()
    size_mm = np.array([float(each) for each in box[2:]]) / 72 * 25.4
    np.testing.assert_allclose(size_mm, sheet.size_mm, atol=0.01)
    # seen from above at 3 px/mm: OpenCV's pixel (0, 0) has its middle at half a pixel
    across = np.array(sheet.bits.shape[::-1]) * sheet.square_mm / 8
    picture = np.full((1000, 760), 255, np.uint8)
    size = np.round(3 * across).astype(int)
    bits = np.where(sheet.bits, 0, 255).astype(np.uint8)
    picture[60 : 60 + size[1], 40 : 40 + size[0]] = cv2.resize(
        bits, size.tolist(), interpolation=cv2.INTER_NEAREST
    )
    mm, px = sheet.find(cv2.cvtColor(picture, cv2.COLOR_GRAY2BGR))
    assert len(mm) == 2 * sum(n - 3 for n in sheet.squares) + 4  # one ring of corners
    expected = 3 * (mm - sheet.corner_mm) + [39.5, 59.5]
    np.testing.assert_allclose(px, expected, atol=0.25)
    np.testing.assert_allclose((px - expected).mean(axis=0), 0, atol=0.1)


@pytest.mark.parametrize(("tilt", "k1"), [(0.0, 0.0), (6.0, -0.1), (12.0, 0.05)])
def test_the_plane_of_the_dots_is_found_by_the_sheet(tilt: float, k1: float) -> None:
    """Places are those that were drawn, to what is not known of the camera."""
    camera = Filmed(tilt_deg=tilt, k1=k1)
    image = camera.frame(arc(40.0))
    found = fitted(camera, image)
    # of a camera that looks straight at the sheet the tilt is known least, as it does little
    assert found.tilt_deg == pytest.approx(tilt, abs=0.4 if tilt else 1.0)
    assert found.residual_px < 0.15
    places = arc(40.0)
    off = found.plane_mm(camera.pixels(places)) - places
    # half a millimetre in front of the sheet is a tenth of one beside it at 12°, and 0.1 % of scale
    assert np.abs(off).max() < 0.12
    middle = places.mean(axis=0)
    cross = camera.pixels(middle + np.array([[-9.0, 0], [9, 0], [0, -9], [0, 9]]))
    px = np.linalg.norm(cross[1] - cross[0]) + np.linalg.norm(cross[3] - cross[2])
    scale, spread = found.scale(cross.mean(axis=0))
    assert scale == pytest.approx(36 / px, rel=0.003)
    assert 0.0005 < spread < 0.01


def test_what_a_scale_of_two_points_does_not_tell_stays_open() -> None:
    """A length at one place says nothing of a tilt of 8°; its error is within the interval."""
    camera = Filmed(tilt_deg=8.0, way_deg=85.0, sheet=False, front_mm=0.0)
    ends = np.array([[-20.0, 5.0], [-20.0, 65.0]])
    length = plane.Length(camera.pixels(ends), 60.0, 0.1)
    found = plane.of_lengths(camera.size_px, [length], (0.0, 0.1), "two points")
    places = arc(45.0)

    def turn(unknowns: np.ndarray | None) -> float:
        seen = found.plane_mm(camera.pixels(places), unknowns)
        arm = seen[-1] - seen[-2]
        return float(np.degrees(np.arctan2(arm[0], arm[1])))

    true = np.degrees(np.arctan2(*(places[-1] - places[-2])))
    spread = np.std([turn(each) for each in found.draws(200, np.random.default_rng(1))])
    assert 0.1 < abs(turn(None) - true) < 2 * spread
    assert not found.determined(plane.K1)


@pytest.mark.parametrize("colour", [RED, (200, 80, 30), (60, 170, 40), (30, 210, 235)])
@pytest.mark.parametrize("quality", [95, 75])
def test_dots_are_found_among_others_in_a_jpeg(colour: tuple[int, int, int], quality: int) -> None:
    """Larger things of their colour, shadows of their size, glare, and a coloured light."""
    camera = Filmed()
    places = arc(35.0)
    image = camera.frame(places, colour=colour)
    camera.add(image, camera.pixels(np.array([[-35.0, 60.0]])), 14.0, colour)
    cv2.rectangle(image, (600, 560), (680, 570), colour, -1)
    shadows = camera.pixels(places + np.array([9.0, 6.0]))
    camera.add(image, shadows, 1.5 * camera.px_per_mm, (120, 120, 120))
    at = camera.pixels(places)
    camera.add(image, at + np.array([0.8, -0.8]), 0.9, (250, 250, 250))  # glare within
    lit = np.clip(image * np.array([0.75, 0.9, 1.0]), 0, 255).astype(np.uint8)
    packed = cv2.imencode(".jpg", lit, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    found = learnt(cv2.imdecode(packed, cv2.IMREAD_COLOR))
    assert len(found) == 6
    off = np.linalg.norm(found - at[np.argsort(at[:, 1])], axis=1)
    assert off.max() < (0.8 if quality > 80 else 1.2)


def test_nothing_is_taken_for_dots_where_there_are_none() -> None:
    with pytest.raises(ConfigError, match=r"no dot is seen.*--colour.*--points"):
        learnt(Filmed().frame(np.zeros((0, 2))))
    with pytest.raises(ConfigError, match="of 7"):
        learnt(Filmed().frame(arc(20.0)), count=7)


def test_points_keep_their_identity_and_a_lost_one_has_no_place() -> None:
    """A bar hides a dot and half of another as the arc sweeps past it; a decoy is passed."""
    camera = Filmed()
    bends = np.linspace(0, 75, 26)
    first = camera.frame(arc(0.0))
    colour, places = dots.learn(first, None, 6, 1, None)
    (own,) = order.fingers(places, 1)
    own = own if places[own[0], 1] < places[own[-1], 1] else own[::-1]
    follower = Follower(colour, places, [own])
    errors, hidden = [], 0
    for i, bend in enumerate(bends):
        image = camera.frame(arc(bend), seed=i)
        camera.add(image, camera.pixels(np.array([[20.0, 58.0]])), 6.0, RED)
        bar = camera.pixels(np.array([[12.0, 40.0], [12.0, 70.0]])).astype(int)
        cv2.rectangle(
            image, (bar[0, 0] - 4, bar[0, 1]), (bar[1, 0] + 4, bar[1, 1]), (60, 60, 60), -1
        )
        px, seen = follower.step(image)
        off = np.linalg.norm(px[own] - camera.pixels(arc(bend)), axis=1)
        hidden += int(np.isnan(off).sum())
        errors.append(np.where(seen[own] > 0.95, off, 0.0))
        assert np.nanmax(off) < 0.5 * 11 * camera.px_per_mm  # nobody else's place
    assert 0 < hidden < 30
    assert np.nanmax(errors) < 0.6
    assert np.isfinite(px).all()  # it is found again


def test_order_follows_the_body_where_it_curls_back() -> None:
    """Places along x or z alone would be out of order; the generator's seed makes the order."""
    places = arc(300.0, count=12)
    mixed = np.random.default_rng(5).permutation(12)
    (own,) = order.fingers(places[mixed], 1)
    along = mixed[own]
    assert along.tolist() in (list(range(12)), list(range(12))[::-1])
    pair = np.concatenate([arc(60.0), arc(60.0) * [-1, 1] + [100.0, 0.0]])
    left, right = order.fingers(pair, 2)
    assert set(left) == set(range(6))
    assert set(right) == set(range(6, 12))


def test_a_tags_corners_tell_its_rotation() -> None:
    """Two tags, the lower one turned by 30°, anticlockwise as seen."""
    image = np.full((480, 640, 3), 230, np.uint8)
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_APRILTAG_36h11)
    for number, middle, turn in ((3, (320, 120), 0.0), (7, (320, 320), 30.0)):
        tag = cv2.cvtColor(
            cv2.aruco.generateImageMarker(dictionary, number, 400), cv2.COLOR_GRAY2BGR
        )
        cosine, sine = np.cos(np.radians(turn)) * 0.2, np.sin(np.radians(turn)) * 0.2
        move = np.array([[cosine, sine, 0.0], [-sine, cosine, 0.0]])
        move[:, 2] = np.array(middle) - move[:, :2] @ [199.5, 199.5]
        size = (640, 480)
        cv2.warpAffine(tag, move, size, image, cv2.INTER_AREA, cv2.BORDER_TRANSPARENT)
    found = Tags("36h11", image)
    assert found.numbers == [3, 7]
    centres, seen, corners = found.step(image)
    np.testing.assert_allclose(centres, [[320, 120], [320, 320]], atol=0.3)
    assert seen.tolist() == [1, 1]
    edge = corners[1, 1] - corners[1, 0]
    assert np.degrees(np.arctan2(-edge[1], edge[0])) == pytest.approx(30, abs=0.5)
    assert np.isnan(found.step(np.full_like(image, 230))[0]).all()


def test_dots_that_a_jpeg_taught_are_found_in_a_coloured_light() -> None:
    """Their size is that of what is found, and not of the contrast by which they were told."""
    camera, places = Filmed(size_px=(1280, 960), distance_mm=380.0), arc(0.0, count=8)
    cast = np.array([0.45, 0.5, 1.0])
    image = camera.frame(places, colour=(60, 170, 40), noise=4.0)
    lit = np.clip(image * cast, 0, 255).astype(np.uint8)
    packed = cv2.imencode(".jpg", lit, [cv2.IMWRITE_JPEG_QUALITY, 85])[1]
    colour, _ = dots.learn(cv2.imdecode(packed, cv2.IMREAD_COLOR), None, None, 1, None)
    found = np.array([dot.centre_px for dot in dots.find(lit, colour)])
    assert len(found) == 8
    off = found[np.argsort(found[:, 1])] - camera.pixels(places)
    assert np.linalg.norm(off, axis=1).max() < 0.3


def test_arms_that_cross_while_they_curl_keep_their_dots_in_hard_photographs() -> None:
    """JPEG in a red light, with glare at dots' edges, shadows like dots, a ruler and red things.

    Two arms bend towards each other by up to 150°, so that the tip of each is beside the base of
    the other one; places are those that were drawn.
    """
    camera, fingers = Filmed(size_px=(1280, 960), distance_mm=400.0), []
    radius = 1.5 * camera.px_per_mm
    for seed, bend in enumerate((0.0, 30.0, 60.0, 120.0, 150.0)):
        arms = [arc(bend) - [30.0, 0.0], arc(bend) * [-1, 1] + [30.0, 8.0]]
        at = [camera.pixels(each) for each in arms]
        image = camera.frame(np.zeros((0, 2)), seed=seed)
        camera.add(image, at[0] + [25.0, 18.0], radius, (105, 108, 115))
        cv2.rectangle(image, (60, 200), (110, 800), (110, 190, 215), -1)
        for y in range(200, 800, 12):
            cv2.line(image, (60, y), (85, y), (20, 20, 20), 2)
        cv2.putText(image, "R2", (560, 820), cv2.FONT_HERSHEY_DUPLEX, 2, RED, 4)
        cv2.rectangle(image, (900, 180), (1000, 195), RED, -1)
        for each in at:
            camera.add(image, each, radius, RED)
            camera.add(image, each + 0.4 * radius * np.array([1, -1]), 0.4 * radius, (255,) * 3)
        lit = np.clip(image * np.array([0.4, 0.55, 1.0]), 0, 255).astype(np.uint8)
        packed = cv2.imencode(".jpg", lit, [cv2.IMWRITE_JPEG_QUALITY, 75])[1]
        picture = cv2.imdecode(packed, cv2.IMREAD_COLOR)
        if not fingers:
            colour, places = dots.learn(picture, None, None, 2, None)
            fingers = order.fingers(places, 2)
            fingers = [each[np.argsort(places[each, 1])] for each in fingers]
            assert [len(each) for each in fingers] == [6, 6]
            follower = Follower(colour, places, fingers)
        px, _ = follower.anew(picture)
        off = np.linalg.norm(px[np.array(fingers)] - np.array(at), axis=2)
        print(bend, off.round(1))
        assert np.nanmax(off) < 3
        assert np.isnan(off).sum() <= 1
