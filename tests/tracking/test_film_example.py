"""The rendered video of ``examples/film``, whose truth the renderer has written beside it.

``benchmarks/track/render.py`` made it of the package's own finger: ``truth.csv`` has the last dot's
place and the turn of the line between the last two.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from support.command import run_command
from support.example import EXAMPLES

FILM = EXAMPLES / "film"


def test_the_example_is_read_as_it_was_rendered(tmp_path: Path) -> None:
    told = (FILM / "finger.mp4", "--log", FILM / "log.csv", "--in-front", "14", "--no-overlay")
    assert run_command("track", *told, "-o", tmp_path) == 0
    truth = pd.read_csv(FILM / "truth.csv")
    found = pd.read_csv(tmp_path / "finger_frames.csv")
    assert len(found) == len(truth) == len(pd.read_csv(tmp_path / "finger.csv"))
    off = found["angle_deg"] - truth["angle_deg"]
    # an eighth of a pixel of noise at 28 px of distance is 0.36°
    assert np.sqrt((off**2).mean()) < 0.5
    for axis in "xz":
        name = f"marker_6_{axis}_mm"
        away = found[name] - truth[f"tip_{axis}_mm"]
        assert np.sqrt((away**2).mean()) < 0.3
        spread = np.hypot(found[f"noise_{name}"], found[f"common_{name}"])
        assert (np.abs(away) < 2 * spread).all()
