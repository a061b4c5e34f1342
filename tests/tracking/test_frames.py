"""Videos and pictures that are turned, uneven in time, cut off, damaged, or none at all."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from PIL import Image
from support import filmed

from dolfingrip.sections.errors import ConfigError
from dolfingrip.tracking import dots, frames

WIDTH, HEIGHT = 192, 128


def images(count: int) -> list[np.ndarray]:
    """Frames with a bright corner above on the left, and noise that a codec cannot leave out."""
    found = []
    for i in range(count):
        image = np.random.default_rng(i).integers(0, 90, (HEIGHT, WIDTH, 3)).astype(np.uint8)
        image[:40, :40] = 250
        found.append(image)
    return found


def test_frames_have_the_containers_times(tmp_path: Path) -> None:
    """Of a phone that films fewer pictures where it is dark."""
    file, ticks = tmp_path / "uneven.mp4", [0, 1, 2, 5, 6, 11]
    with av.open(str(file), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for tick, image in zip(ticks, images(6), strict=True):
            frame = av.VideoFrame.from_ndarray(image, format="bgr24")
            frame.pts, frame.time_base = tick, Fraction(1, 30)
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    found = list(frames.open_frames([file]))
    np.testing.assert_allclose([each.time_s for each in found], np.array(ticks) / 30, atol=1e-4)
    short = list(frames.open_frames([file], until_s=0.1))
    assert [each.number for each in short] == [0, 1, 2]


def test_a_portrait_video_is_turned_as_it_is_shown(tmp_path: Path) -> None:
    """The mark of a phone that was held upright is the track's matrix (ISO 14496-12)."""
    file = tmp_path / "phone.mp4"
    filmed.write(file, images(5))
    data = bytearray(file.read_bytes())
    one = (1 << 16).to_bytes(4, "big")
    minus = ((1 << 32) - (1 << 16)).to_bytes(4, "big")
    zero, last = bytes(4), (1 << 30).to_bytes(4, "big")
    plain = one + zero * 3 + one + zero * 3 + last
    at = data.index(plain, data.index(b"tkhd"))
    data[at : at + 36] = zero + one + zero + minus + zero * 4 + last  # a quarter turn, clockwise
    file.write_bytes(bytes(data))
    first = next(iter(frames.open_frames([file])))
    assert first.image.shape == (WIDTH, HEIGHT, 3)
    assert first.image[:36, -36:].mean() > 200  # what was above on the left is on the right
    assert first.image[:36, :36].mean() < 100


@pytest.mark.parametrize("damage", ["cut", "zeros"])
def test_a_video_that_ends_early_is_refused(tmp_path: Path, damage: str) -> None:
    file = tmp_path / "cut.mkv"
    filmed.write(file, images(60))
    data = file.read_bytes()
    half = len(data) // 2
    file.write_bytes(data[:half] if damage == "cut" else data[:half] + bytes(len(data) - half))
    with pytest.raises(ConfigError, match=r"ends after \d+ frames.*--until"):
        list(frames.open_frames([file]))


def test_what_is_no_video_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text.mp4").write_text("no video")
    (tmp_path / "list.mp4").write_text("#EXTM3U\n#EXTINF:1,\n/etc/passwd\n")
    for name in ("text.mp4", "list.mp4"):
        with pytest.raises(ConfigError, match=rf"{name}.*allowed: a whole video"):
            frames.open_frames([tmp_path / name])
    with pytest.raises(ConfigError, match="no such file"):
        frames.open_frames([tmp_path / "absent.mp4"])


def test_pictures_are_of_one_size_and_turned(tmp_path: Path) -> None:
    names = []
    for i, image in enumerate(images(2)):
        names.append(tmp_path / f"{i}.jpg")
        Image.fromarray(image).save(names[-1], exif=_turned() if i == 0 else Image.Exif())
    with pytest.raises(ConfigError, match=r"1\.jpg: 192 × 128 px, and 0.jpg is 128 × 192 px"):
        list(frames.open_frames(names))
    (first,) = frames.open_frames(names[:1])
    assert first.image[:36, -36:].mean() > 200
    assert np.isnan(first.time_s)
    names[0].write_bytes(names[0].read_bytes()[:300])
    with pytest.raises(ConfigError, match=r"0\.jpg: cannot be decoded"):
        list(frames.open_frames(names[:1]))


def _turned() -> Image.Exif:
    """The mark of a camera that was held upright."""
    found = Image.Exif()
    found[0x0112] = 6
    return found


def test_a_large_picture_is_refused_before_it_is_decoded(tmp_path: Path) -> None:
    Image.new("L", (9000, 9000)).save(tmp_path / "large.png")
    with pytest.raises(ConfigError, match=r"9000 × 9000 px; allowed: .* 50 million"):
        list(frames.open_frames([tmp_path / "large.png"]))


def test_a_dots_middle_is_found_between_the_pixels_that_have_colour(tmp_path: Path) -> None:
    """A codec keeps colour at every second pixel; a dot that moves by parts of one is where it is.

    Reference: the places at which the dots are drawn.
    """
    file = tmp_path / "dots.mp4"
    at_px = np.array([[40.0, 40.0], [90.0, 60.0], [140.0, 90.0]])
    shifts = np.arange(8) * np.array([[0.27], [0.41]])
    drawn = []
    for shift in shifts.T:
        image = np.full((2 * HEIGHT, 2 * WIDTH, 3), 150, np.uint8)
        filmed.Filmed.add(image, at_px + shift, 5.5, filmed.RED)
        drawn.append(image)
    filmed.write(file, drawn, crf=0)
    seen = [frame.image for frame in frames.open_frames([file])]
    colour, _ = dots.learn(seen[0], None, 3, 1, None)
    found = [sorted(tuple(dot.centre_px) for dot in dots.find(image, colour)) for image in seen]
    off_px = np.array(found) - at_px - shifts.T[:, None]
    assert off_px.std(axis=0).max() < 0.05
