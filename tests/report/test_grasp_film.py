"""The MP4 of a grasp."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np

from dolfingrip.report.gripper import VIEW, stages, write_film


def test_a_film_shows_each_picture(tmp_path: Path) -> None:
    """Grey levels come back in order, one column less of an odd width."""
    levels = [20, 120, 220]
    write_film(tmp_path / "film.mp4", [np.full((48, 65, 3), at, np.uint8) for at in levels])
    with av.open(str(tmp_path / "film.mp4")) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        assert stream.average_rate == 1000 / VIEW.frame_ms
        found = [frame.to_ndarray(format="rgb24") for frame in container.decode(stream)]
    assert [image.shape for image in found] == 3 * [(48, 64, 3)]
    for image, level in zip(found, levels, strict=True):
        assert abs(float(image.mean()) - level) < 5


def test_the_stages_of_a_grasp() -> None:
    """The start, half-way, where the fingers are closed, and the end of the lift."""
    assert stages(["loading"] * 7 + ["hold"] * 4) == [0, 3, 6, 10]
    assert stages(["loading"] * 2 + ["hold"]) == [0, 1, 2]
    assert stages(["loading"]) == [0]
