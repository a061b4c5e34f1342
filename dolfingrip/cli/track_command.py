"""``dolfingrip track``: a video or pictures as the two files of the format of measured data."""

from __future__ import annotations

import math
import re
import shlex
import webbrowser
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.channels import PRESSURE
from dolfingrip.cli.console import Screen, console, one_process
from dolfingrip.cli.import_command import named
from dolfingrip.cli.progress import shown
from dolfingrip.cli.settings import TrackSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.files import table as tables
from dolfingrip.files import whole
from dolfingrip.importing.importing import read_log
from dolfingrip.importing.told import Question, Told
from dolfingrip.tracking import family, foreign, frames, show, track, watch
from dolfingrip.tracking.asked import TrackAsked, states_of
from dolfingrip.tracking.family import Family
from dolfingrip.tracking.plane import Length
from dolfingrip.tracking.sheet import SHEETS

NUMBER = r"\s*([-+]?\d+(?:\.\d+)?)\s*"


def track_video(args: TrackSettings) -> None:
    """Write the sheet, or follow the points of a video or of pictures."""
    one_process("dolfingrip track without mpirun")
    screen = console()
    if not args.files:
        if args.sheet is None:
            raise ConfigError("no video; allowed: a video or pictures, or --sheet a4 to print")
        file = args.out if args.out.suffix == ".pdf" else args.out / "sheet.pdf"
        SHEETS[args.sheet].write(file)
        screen.say(f"{file}: print it at 100 %, and measure its ruler")
        return
    config = configuration.load(args.config, overrides=args.overrides)
    request, log, until_s = _told(args), _log(args), args.until or math.inf
    source: frames.FrameSource | None = None
    if _has_points(args):
        with screen.status(f"reading {args.files[0]}"):
            watched, request = foreign.load(args.files[0], request, until_s)
    else:
        source = frames.open_frames(args.files, until_s)
        if args.silhouette:
            request = replace(request, family=_simulated(config, args, screen))
        if args.pick:
            request = replace(request, points_px=_picked(source, args, screen))
        with shown(screen, "frames", total=source.expected) as progress:
            watched = watch.watch(source, request, args.out, progress)
    tracked = track.understand(watched, request, log, config)
    written = track.write(tracked, args.out, config, request.name)
    if args.overlay and source is not None:
        with shown(screen, "frames drawn", total=source.expected) as progress:
            show.show(source, tracked, args.out, progress)
    _tell(tracked, written, args, screen)


def _simulated(config: Config, args: TrackSettings, screen: Screen) -> Family:
    """The shapes of the configuration's finger, which start the search for its silhouette."""
    for name in ("points", "tags", "colour", "pick", "first"):
        if getattr(args, name):
            raise ConfigError(f"--silhouette: allowed: without --{name}")
    if args.fingers > 1:
        raise ConfigError(f"--fingers {args.fingers}: allowed with --silhouette: 1")
    with shown(screen, "simulated shapes", at_once=True) as progress:
        return family.simulate(config, progress)


def _picked(source: frames.FrameSource, args: TrackSettings, screen: Screen) -> np.ndarray:
    """Dots (n, 2) that a person clicks in the browser, told as the option that repeats them."""
    from dolfingrip.serving.guard import Handover
    from dolfingrip.tracking.pick import pick

    for name in ("points", "tags"):
        if getattr(args, name) is not None:
            raise ConfigError(f"--pick: allowed: without --{name}")
    handover = Handover.of(args.out)

    def say(address: str) -> None:
        handover.write(address)
        screen.say(f"click the dots: {address}")
        webbrowser.open(handover.file.as_uri())

    places_px = pick(next(iter(source)), source.name, say)
    text = " ".join(f"{u:.1f},{v:.1f}" for u, v in places_px)
    screen.say(f'the same again: --points "{text}"')
    return places_px


def _tell(tracked: track.Tracked, written: list[Path], args: TrackSettings, screen: Screen) -> None:
    """Print and write the summary; its last line is the command that goes on."""
    lines = [*tracked.told, *(f"doubt: {text}" for text in tracked.doubts)]
    doubtful = watch.doubtful(tracked.watched)
    if doubtful and not _has_points(args):
        lines.append(f"{len(doubtful)} doubtful frames; {args.out / 'doubtful'} shows the worst")
    if PRESSURE.name in tracked.control:
        files = " ".join(shlex.quote(str(file)) for file in written)
        config = f" --config {shlex.quote(str(args.config))}" if args.config else ""
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
    whole.write(args.out / "summary.md", "\n".join([*summary, "", last]) + "\n")
    screen.say(last)


def _log(args: TrackSettings) -> Mapping[str, np.ndarray] | None:
    """The columns of the log."""
    for flag, value in (("--light", args.light), ("--knock", args.knock)):
        if value and (args.event is None or args.log is None):
            raise ConfigError(f"{flag}: allowed: with --log and --event, its column that shows it")
    if args.log is None:
        return None
    try:
        log = read_log(args.log, Told(column=named(args.column)), args.event)
    except Question as question:
        raise ConfigError(f"{args.log}: {question}") from None
    return {str(name): log[name].to_numpy(dtype=float) for name in log}


def _has_points(args: TrackSettings) -> bool:
    """Say if another program has tracked the points, so that there are no pictures.

    Raises:
        ConfigError: one line, for an option that needs pictures, or for several files.
    """
    if not foreign.is_points(args.files[0]):
        return False
    for name in ("light", "tags", "colour", "dots", "states", "pick", "silhouette"):
        if getattr(args, name):
            raise ConfigError(f"--{name}: {args.files[0]} has no pictures; allowed: with a video")
    if len(args.files) > 1:
        raise ConfigError(f"{len(args.files)} files; allowed: one file of points")
    return True


def _told(args: TrackSettings) -> TrackAsked:
    """Turn the texts of options into numbers."""
    labelled, is_place = _has_points(args), re.fullmatch(f"{NUMBER},{NUMBER}", args.clamp or "")
    points = None if args.points is None or labelled else _points(args.points, "--points")
    clamp = None
    if args.clamp is not None and (is_place or not labelled):
        clamp = _points(args.clamp, "--clamp")[0]
    scales = []
    for text in args.scale:
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
    if args.states is not None:
        names = [file.name for file in args.files]
        if Path(args.states).suffix.lower() == ".csv":
            states = _state_table(Path(args.states), names)
        else:
            states = states_of(args.states, names)
    return TrackAsked(
        colour=args.colour, count=args.dots, points_px=points, tags=args.tags,
        tag_mm=args.tag_side, fingers=args.fingers, scales=scales,
        clamp_px=clamp, clamp_label=args.clamp if clamp is None else None, unit=args.unit,
        labels=[label.strip() for label in (args.points or "").split(",") if labelled and label],
        frame_rate=args.frame_rate,
        first_mm=args.first, in_front_mm=args.in_front, side=args.side,
        light_px=None if args.light is None else _points(args.light, "--light")[0],
        knock=args.knock, shift_s=args.shift, states=states, name=args.files[0].stem
        if args.log is not None or len(args.files) == 1 else "pictures",
    )  # fmt: skip


def _points(text: str, flag: str) -> np.ndarray:
    """Points (n, 2) as they are typed."""
    try:
        points = [[float(n) for n in pair.split(",")] for pair in text.split()]
        if not points or any(len(pair) != 2 for pair in points):
            raise ValueError
    except ValueError:
        raise ConfigError(
            f'{flag} "{text}": allowed: as "312,400" or "312,400 315,460" (px)'
        ) from None
    return np.array(points)


def _state_table(file: Path, names: list[str]) -> dict[str, dict[str, float]]:
    """The states of pictures from a table with a column ``file``."""
    try:
        columns = tables.read_csv(file)
        rows = dict(zip(columns.pop("file"), zip(*columns.values(), strict=True), strict=True))
        states = {name: dict(zip(columns, map(float, rows[name]), strict=True)) for name in names}
    except (OSError, ValueError, KeyError) as error:
        raise ConfigError(
            f"--states {file}: {error}; allowed: a CSV with a column file, which has every "
            f"picture, and columns of numbers such as {PRESSURE.name}"
        ) from None
    return states
