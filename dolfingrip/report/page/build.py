"""A page of any mix of results: what each contributes, in the order of reading."""

from __future__ import annotations

import importlib
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from PIL import Image as Pillow

from dolfingrip.report import render
from dolfingrip.report.columns import Columns
from dolfingrip.report.page import (
    curves,
    diagnosis,
    finger,
    front,
    gradient,
    key_numbers,
    runs,
    trust,
)
from dolfingrip.report.page.content import Page, Source
from dolfingrip.report.page.run_scene import scene_of
from dolfingrip.report.page.scene import Scene
from dolfingrip.report.page.sources import Source as Found
from dolfingrip.report.page.sources import read_json
from dolfingrip.sections.errors import ConfigError

STILLS: Final = 3
"""Pictures of a run in place of its 3D view."""

STILL_IN: Final = 2.4
"""Height of each, in inches at the pictures' resolution."""

STILL_PX: Final = 1400
"""Largest width of them side by side."""

Designs = Sequence[Mapping[str, Any]]


@dataclass(slots=True)
class _Work:
    """What is gathered on the way."""

    runs: list[runs.Run]
    fields: dict[int, finger.Fields] = field(default_factory=dict)
    scenes: dict[int, int] = field(default_factory=dict)


def build(
    found: Sequence[Found],
    *,
    designs: Mapping[Path, Designs],
    measured: Columns | None = None,
    title: str | None = None,
    pictures: bool = True,
    say: Callable[[str], None] = lambda text: None,
) -> Page:
    """Everything on the page of these results.

    Args:
        found: folders with results.
        designs: the designs of each campaign among them, by folder.
        measured: columns of a measurement, drawn beside the curves.
        title: of the page; None: made of the results.
        pictures: whether pictures are rendered that stand in place of the 3D view.
        say: called with a line on what is being read.

    Raises:
        ConfigError: one line, if a result cannot be read.
    """
    work = _Work(runs.titled([runs.read(each.folder) for each in found if each.kind == "run"]))
    page = Page(title or _title(found, work.runs))
    if work.runs:
        page.conditions = runs.conditions(work.runs[0])
    for place, run in enumerate(work.runs):
        say(f"reading {run.folder}")
        _add_scene(page, work, place, pictures)
        page.remarks += _remarks(run)
        page.sources.append(runs.source(run))
    finest = trust.finest(work.runs)
    page.charts = curves.charts(work.runs, measured, work.scenes, finest)
    _add_designs(page, found, designs, say)
    for each in found:
        if each.kind == "diagnose":
            say(f"reading {each.folder}")
            page.diagnoses.append(diagnosis.read(each.folder))
            page.sources.append(diagnosis.source(each.folder))
    page.checks = trust.checks(work.runs, work.fields, finest, measured)
    designed = [gradient.read(each.folder) for each in found if each.kind == "design"]
    for charts, table, checks, _, source in designed:
        page.charts += charts
        page.tables.append(table)
        page.checks += checks
        page.sources.append(source)
    page.numbers = key_numbers.numbers_of(work.runs, work.fields, page.checks, page.front)
    page.numbers += [n for each in designed for n in each[3]][: 5 - len(page.numbers)]
    page.numbers += [n for part in found if part.kind == "diagnose"
                     for n in diagnosis.numbers(part.folder)][: 5 - len(page.numbers)]  # fmt: skip
    return page


def _title(found: Sequence[Found], read: Sequence[runs.Run]) -> str:
    """The kinds of results, each once."""
    names = {"optimise": "chosen design", "train": "surrogate", "study": "study of the optimiser",
             "doe": "designs", "design": "design by gradients",
             "diagnose": "diagnosis"}  # fmt: skip
    titles = [run.experiment.title.lower() for run in read]
    titles += [names[each.kind] for each in found if each.kind in names]
    once = list(dict.fromkeys(titles))
    text = once[0] if len(once) == 1 else f"{', '.join(once[:-1])} and {once[-1]}"
    return text[0].upper() + text[1:]


def _remarks(run: runs.Run) -> list[str]:
    found = []
    failure = run.facts.get("failure")
    if failure:
        found.append(f"{run.title} {failure['sentence']}")
    outcome = run.facts.get("outcome")
    if outcome:
        found.append(f"{run.title}: {outcome['kind']}, {outcome['sentence']}.")
    return found


def _add_scene(page: Page, work: _Work, place: int, pictures: bool) -> None:
    """Add the run's scene and pictures; a run without fields has curves alone."""
    run = work.runs[place]
    if not run.fields.is_file():
        page.remarks.append(f"{run.title} has no fields on disk, so it is not shown in 3D.")
        return
    try:
        if run.experiment.pictures != "gripper":
            work.fields[place] = finger.read(run.fields)
        scene = scene_of(run, work.fields.get(place))
        page.scenes.append(scene.packed())
        if pictures:
            page.stills += _stills(run, scene)
    except ValueError as error:
        raise ConfigError(str(error)) from None
    work.scenes[place] = len(page.scenes) - 1
    shown = len(scene.load.rows)
    if shown < run.rows:
        page.remarks.append(
            f"{run.title}: the 3D view has {shown} of {run.rows} steps, and shapes between them."
        )


def _stills(run: runs.Run, scene: Scene) -> list[tuple[str, bytes]]:
    """Pictures of the run in place of the 3D view."""
    if run.experiment.pictures != "finger":
        module = importlib.import_module(f"dolfingrip.report.{run.experiment.pictures}")
        image = module.strip(run.folder, run.config, run.table)
        return [(scene.alt, _png(image, STILL_PX))]
    pressures = run.column("pressure_kPa")
    if pressures is None or run.experiment.control.name != "pressure_kPa":
        return []
    loading = np.flatnonzero(np.array(run.branch) == "loading")
    if not len(loading):
        return []
    rows = loading[np.unique(np.linspace(0, len(loading) - 1, STILLS).round().astype(int))]
    wanted = list(dict.fromkeys(float(pressures[row]) for row in rows))
    drawn = render.draw(run.fields, wanted, result=run.table, height_in=STILL_IN)
    with TemporaryDirectory() as folder:
        file = drawn.save_strip(Path(folder) / "strip.png")
        return [(scene.alt, _png(np.asarray(Pillow.open(file).convert("RGB")), STILL_PX))]


def _png(image: np.ndarray, width_px: int) -> bytes:
    picture = Pillow.fromarray(image)
    if picture.width > width_px:
        picture = picture.resize((width_px, round(picture.height * width_px / picture.width)))
    target = io.BytesIO()
    picture.save(target, "PNG", optimize=True)
    return target.getvalue()


def _add_designs(
    page: Page, found: Sequence[Found], designs: Mapping[Path, Designs], say: Callable[[str], None]
) -> None:
    """Add the front, the surrogate's curve and the study of the optimiser."""
    folders = {kind: [each.folder for each in found if each.kind == kind]
               for kind in ("train", "optimise", "doe", "study")}  # fmt: skip
    trained, chosen = folders["train"], folders["optimise"]
    if trained or chosen or folders["doe"]:
        say("making the shapes of the designs")
        rows = [row for folder in folders["doe"] for row in designs.get(folder, ())]
        loop = front.Loop(trained[0] if trained else None, chosen[0] if chosen else None, rows)
        page.front = front.front(loop)
        page.charts += front.charts(loop.surrogate)
    page.tables += [front.study(folder) for folder in folders["study"]]
    names = {"train": "Surrogate", "optimise": "Optimisation", "doe": "Design of experiments",
             "study": "Study of the optimiser"}  # fmt: skip
    files = {"train": "surrogate.json", "optimise": "optimum.json"}
    for kind, places in folders.items():
        for folder in places:
            facts: list[tuple[str, str]] = []
            if kind in files:
                content = read_json(folder / files[kind])
                facts = [(k, str(v)) for k, v in content.get("versions", {}).items()]
            page.sources.append(Source(names[kind], str(folder), "", facts))
