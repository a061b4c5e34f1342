"""``dolfingrip track``: a video or pictures as the two files of the format of measured data."""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.channels import PRESSURE
from dolfingrip.cli.console import Screen, check_writable, console, one_process
from dolfingrip.cli.progress import shown
from dolfingrip.cli.settings import TrackSettings
from dolfingrip.config import ConfigError
from dolfingrip.files import table as tables
from dolfingrip.files import whole
from dolfingrip.importing.importing import read_log
from dolfingrip.importing.told import Question, Told
from dolfingrip.tracking import frames, show, track, watch
from dolfingrip.tracking.asked import TrackAsked, states_of
from dolfingrip.tracking.plane import Length
from dolfingrip.tracking.sheet import SHEETS

NUMBER = r"\s*([-+]?\d+(?:\.\d+)?)\s*"


def track_video(asked: TrackSettings) -> None:
    """Write the sheet, or follow the points of a video or of pictures."""
    one_process("dolfingrip track without mpirun")
    screen = console()
    if not asked.files:
        if asked.sheet is None:
            raise ConfigError("no video; allowed: a video or pictures, or --sheet a4 to print")
        file = asked.out if asked.out.suffix == ".pdf" else asked.out / "sheet.pdf"
        SHEETS[asked.sheet].write(file)
        screen.say(f"{file}: print it at 100 %, and measure its ruler")
        return
    check_writable(asked.out)
    config = configuration.load(asked.config, overrides=asked.overrides)
    source = frames.open_frames(asked.files, asked.until or math.inf)
    log = _log(asked)
    told = _told(asked, source)
    with shown(screen, "frames", total=source.expected) as progress:
        watched = watch.watch(source, told, asked.out, progress)
    tracked = track.understand(watched, told, log, config)
    written = track.write(tracked, asked.out, config, told.name)
    if asked.overlay:
        with shown(screen, "frames drawn", total=source.expected) as progress:
            show.show(source, tracked, asked.out, progress)
    _tell(tracked, written, asked, screen)


def _tell(
    tracked: track.Tracked, written: list[Path], asked: TrackSettings, screen: Screen
) -> None:
    """Print and write the summary; its last line is the command that goes on."""
    lines = [*tracked.told, *(f"doubt: {text}" for text in tracked.doubts)]
    doubtful = watch.doubtful(tracked.watched)
    if doubtful:
        lines.append(f"{len(doubtful)} doubtful frames; {asked.out / 'doubtful'} shows the worst")
    if PRESSURE.name in tracked.control:
        files = " ".join(shlex.quote(str(file)) for file in written)
        config = f" --config {shlex.quote(str(asked.config))}" if asked.config else ""
        last = f"dolfingrip diagnose {files}{config}"
    else:
        names = ", ".join(tracked.control)
        last = f"{written[0]} has {names}; diagnose takes {PRESSURE.name}"
    for text in lines:
        screen.say(f"- {text}")
    summary = [f"# {written[0].stem}", "", *(f"- {text}" for text in lines)]
    summary += [f"- {name}: {text}" for name, text in tracked.bodies[0].defined.items()]
    summary += ["", "## Doubtful frames", ""] if doubtful else []
    summary += [f"- frame {i}: {text}" for i, text in sorted(doubtful.items())]
    whole.write(asked.out / "summary.md", "\n".join([*summary, "", last]) + "\n")
    screen.say(last)


def _log(asked: TrackSettings) -> Mapping[str, np.ndarray] | None:
    """The columns of the log."""
    for flag, value in (("--light", asked.light), ("--knock", asked.knock)):
        if value and (asked.event is None or asked.log is None):
            raise ConfigError(f"{flag}: allowed: with --log and --event, its column that shows it")
    if asked.log is None:
        return None
    try:
        found = read_log(asked.log, Told(column=asked.column), asked.event)
    except Question as question:
        raise ConfigError(f"{asked.log}: {question}") from None
    return {str(name): found[name].to_numpy(dtype=float) for name in found}


def _told(asked: TrackSettings, source: frames.FrameSource) -> TrackAsked:
    """Turn the texts of options into numbers."""
    points = None if asked.points is None else _points(asked.points, "--points")
    scales = []
    for text in asked.scale:
        match = re.fullmatch(rf"{NUMBER},{NUMBER} {NUMBER},{NUMBER}={NUMBER}mm\s*", text)
        if match is None:
            raise ConfigError(f'--scale "{text}": allowed: as "312,400 900,402 = 100 mm"')
        u, v, s, t, length = map(float, match.groups())
        ends = np.array([[u, v], [s, t]])
        away = float(np.linalg.norm(ends[1] - ends[0]))
        if away < 10 or length <= 0:
            raise ConfigError(
                f'--scale "{text}": allowed: points at least 10 px apart, and above 0 mm'
            )
        scales.append(Length.pointed_at(ends, length))
    states: dict[str, dict[str, float]] = {}
    if asked.states is not None:
        names = [file.name for file in asked.files]
        if Path(asked.states).suffix.lower() == ".csv":
            states = _state_table(Path(asked.states), names)
        else:
            states = states_of(asked.states, names)
    return TrackAsked(
        colour=asked.colour, count=asked.dots, points_px=points, tags=asked.tags,
        tag_mm=asked.tag_side, fingers=asked.fingers, scales=scales,
        clamp_px=None if asked.clamp is None else _points(asked.clamp, "--clamp")[0],
        first_mm=asked.first, in_front_mm=asked.in_front, side=asked.side,
        light_px=None if asked.light is None else _points(asked.light, "--light")[0],
        knock=asked.knock, shift_s=asked.shift, states=states, name=asked.files[0].stem
        if asked.log is not None or len(asked.files) == 1 else "pictures",
    )  # fmt: skip


def _points(text: str, flag: str) -> np.ndarray:
    """Points (n, 2) as they are typed."""
    try:
        found = [[float(n) for n in each.split(",")] for each in text.split()]
        if not found or any(len(each) != 2 for each in found):
            raise ValueError
    except ValueError:
        raise ConfigError(
            f'{flag} "{text}": allowed: as "312,400" or "312,400 315,460" (px)'
        ) from None
    return np.array(found)


def _state_table(file: Path, names: list[str]) -> dict[str, dict[str, float]]:
    """The states of pictures from a table with a column ``file``."""
    try:
        columns = tables.read_csv(file)
        rows = dict(zip(columns.pop("file"), zip(*columns.values(), strict=True), strict=True))
        found = {name: dict(zip(columns, map(float, rows[name]), strict=True)) for name in names}
    except (OSError, ValueError, KeyError) as error:
        raise ConfigError(
            f"--states {file}: {error}; allowed: a CSV with a column file, which has every "
            f"picture, and columns of numbers such as {PRESSURE.name}"
        ) from None
    return found
