"""``dolfingrip track``: a video or pictures as the two files of the format of measured data."""

from __future__ import annotations

import math
import re
import shlex
import webbrowser
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from dolfingrip import config as configuration
from dolfingrip.cli.console import Screen, console, one_process
from dolfingrip.cli.import_command import named
from dolfingrip.cli.progress import shown
from dolfingrip.cli.settings import TrackSettings
from dolfingrip.config import Config, ConfigError
from dolfingrip.files import whole
from dolfingrip.importing.importing import read_log, read_states
from dolfingrip.importing.told import Question, Told
from dolfingrip.tracking import family, foreign, frames, show, table, track, watch
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
    files, until_s, source = _in_order(args.files), args.until or math.inf, None
    if not _has_points(args):
        source = frames.open_frames(files, until_s)
    request, log = _told(args, files), _log(args)
    if log is None and not request.states:
        raise ConfigError(
            "nothing tells the pressure of the frames; allowed: --log LOG.csv for a video, "
            '--states "{pressure_kPa}.jpg" or a table for pictures'
        )
    if args.silhouette:
        request = replace(request, family=_simulated(config, args, screen))
    if args.pick:
        assert source is not None  # points of another program need none
        request = replace(request, points_px=_picked(source, args, screen))
    watched = None
    try:
        if source is None:
            with screen.status(f"reading {files[0]}"):
                watched, request = foreign.load(files[0], request, until_s)
        else:
            with shown(screen, "frames", total=source.expected) as progress:
                watched = watch.watch(source, request, progress)
        tracked = track.understand(watched, request, log, config)
        written = table.write(tracked, args.out, config, request.name)
    except ConfigError as error:
        raise show.refusal(error, source, watched, args.out) from None
    if args.overlay and source is not None:
        with shown(screen, "frames drawn", total=source.expected) as progress:
            show.show(source, tracked, args.out, progress)
    _tell(tracked, written, args, screen)


def _in_order(files: Sequence[Path]) -> Sequence[Path]:
    """Files by the numbers in their names, where a shell has sorted them by letters."""
    if [*files] != sorted(files):
        return files
    parts = {file: re.split(r"(\d+(?:\.\d+)?)", str(file)) for file in files}
    return sorted(files, key=lambda file: (parts[file][::2], [*map(float, parts[file][1::2])]))


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
    files = " ".join(shlex.quote(str(file)) for file in written)
    config = f" --config {shlex.quote(str(args.config))}" if args.config else ""
    last = f"dolfingrip diagnose {files}{config}"
    for text in lines:
        screen.say(f"- {text}")
    summary = [f"# {written[0].stem}", "", *(f"- {text}" for text in lines)]
    summary += [f"- {name}: {text}" for name, text in tracked.bodies[0].defined.items()]
    summary += ["", "## Doubtful frames", ""] if doubtful else []
    summary += [f"- frame {i}: {text}" for i, text in sorted(doubtful.items())]
    whole.write(args.out / "summary.md", "\n".join([*summary, "", last]) + "\n")
    screen.say(last)


def _log(args: TrackSettings) -> Mapping[str, np.ndarray] | None:
    """The columns of the log, which may be in several files, one after another."""
    for flag, value in (("--light", args.light), ("--knock", args.knock)):
        if value and (args.event is None or not args.log):
            raise ConfigError(f"{flag}: allowed: with --log and --event, its column that shows it")
    if not args.log:
        return None
    try:
        log = read_log(args.log, Told(column=named(args.column)), args.event)
    except Question as question:
        raise ConfigError(f"{args.log[0]}: {question}") from None
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


def _told(args: TrackSettings, files: Sequence[Path]) -> TrackAsked:
    """Turn the texts of options into numbers; the files are in their order."""
    labelled, is_place = _has_points(args), re.fullmatch(f"{NUMBER},{NUMBER}", args.clamp or "")
    points = None if args.points is None or labelled else _points(args.points, "--points")
    clamp = None
    if args.clamp is not None and (is_place or not labelled):
        clamp = _points(args.clamp, "--clamp")[0]
    scales = []
    for text in args.scale:
        match = re.fullmatch(rf"{NUMBER},{NUMBER} {NUMBER},{NUMBER}={NUMBER}mm\s*", text)
        *ends, length = map(float, match.groups()) if match else [0.0] * 5
        ends_px = np.reshape(ends, (2, 2))
        if np.linalg.norm(ends_px[1] - ends_px[0]) < 10 or length <= 0:
            raise ConfigError(
                f'--scale "{text}": allowed: as "312,400 900,402 = 100 mm", of points at least 10 '
                "px apart, and above 0 mm"
            )
        scales.append(Length.pointed_at(ends_px, length))
    states = None if args.states is None else _states(args, [file.name for file in files])
    return TrackAsked(
        colour=args.colour, count=args.dots, points_px=points, tags=args.tags,
        tag_mm=args.tag_side, fingers=args.fingers, scales=scales,
        clamp_px=clamp, clamp_label=args.clamp if clamp is None else None, unit=args.unit,
        labels=[label.strip() for label in (args.points or "").split(",") if labelled and label],
        frame_rate=args.frame_rate,
        first_mm=args.first, in_front_mm=args.in_front, side=args.side,
        light_px=None if args.light is None else _points(args.light, "--light")[0],
        knock=args.knock, shift_s=args.shift, states=states or {},
        name=files[0].stem if args.log or len(files) == 1 else "pictures",
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


def _states(args: TrackSettings, names: Sequence[str]) -> Mapping[str, np.ndarray]:
    """The states of pictures from their names, or from a table with a column ``file``."""
    assert args.states is not None
    file = Path(args.states)
    if file.suffix.lower() == ".csv":
        try:
            texts = pd.read_csv(file, sep=None, engine="python", dtype=str, encoding="utf-8-sig")
            texts = texts.fillna("").set_index("file", verify_integrity=True).loc[[*names]]
        except (OSError, ValueError, KeyError) as error:
            raise ConfigError(
                f"--states {file}: {error}; allowed: a CSV with a column file, which has every "
                f"picture once, and a column such as pressure_kPa"
            ) from None
    else:
        texts = pd.DataFrame(states_of(args.states, names))
    try:
        return read_states(file, texts, Told(column=named(args.column), withdraws=False))
    except Question as question:
        raise ConfigError(f"--states {file}: {question}") from None
