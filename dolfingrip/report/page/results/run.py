"""Results of experiments on a page: scenes, charts, checks and numbers."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar, Final

import numpy as np
from PIL import Image as Pillow

from dolfingrip.charts.chart import Chart
from dolfingrip.experiments.chart import DrawnResult, chart, panels, spectrum
from dolfingrip.experiments.derivatives.bands import band_sentences
from dolfingrip.files.run import RunFile
from dolfingrip.files.table import Columns
from dolfingrip.report import render
from dolfingrip.report.beside import Beside
from dolfingrip.report.drawers import drawer
from dolfingrip.report.page import finger, key_numbers, runs, trust
from dolfingrip.report.page.content import Contribution, FoundResult, Page
from dolfingrip.report.page.run_scene import scene_of
from dolfingrip.report.page.scene import Scene
from dolfingrip.sections.errors import ConfigError

STILLS: Final = 3
"""Pictures of a run in place of its 3D view."""

STILL_IN: Final = 2.4
"""Height of each, in inches at the pictures' resolution."""

STILL_PX: Final = 1400
"""Largest width of them side by side."""


class Runs(Contribution):
    """Part of the page on results of experiments."""

    marks: ClassVar = {"run": RunFile.FILE}
    place = 10

    def add(
        self, page: Page, results: Sequence[FoundResult], measured: Columns | None
    ) -> list[str]:
        read = runs.titled([runs.read(result.folder) for result in results])
        page.conditions = runs.conditions(read[0])
        fields: dict[int, finger.Fields] = {}
        scenes: dict[int, int] = {}
        for place, run in enumerate(read):
            scene = _scene(page, run, fields, place)
            if scene is not None:
                scenes[place] = scene
            page.remarks += _remarks(run)
            page.sources.append(runs.source(run))
        finest = trust.finest(read)
        page.charts += _charts(read, measured, scenes, finest)
        alone = [run for run, one in zip(read, results, strict=True) if not one.inside]
        # what a run belongs to tells the error of its mesh
        names = {trust.of_mesh(run) for run, one in zip(read, results, strict=True) if one.inside}
        checks = trust.checks(read, fields, finest, measured)
        page.checks += [check for check in checks if check.name not in names]
        if alone:
            page.numbers += key_numbers.of_runs(read, fields)
        return [run.experiment.title.lower() for run in alone]


def _remarks(run: runs.Run) -> list[str]:
    result = run.result
    remarks = [f"{run.title}: {said}." for said in band_sentences(run.experiment, result)]
    if result.failure is not None:
        remarks.append(f"{run.title} {result.failure.sentence()}")
    if result.outcome is not None:
        remarks.append(f"{run.title}: {result.outcome.kind}, {result.outcome.sentence}.")
    return remarks


def _scene(page: Page, run: runs.Run, fields: dict[int, finger.Fields], place: int) -> int | None:
    """Add the run's scene and pictures; None if it has no fields, and so has curves alone."""
    if not run.fields.is_file():
        page.remarks.append(f"{run.title} has no fields on disk, so it is not shown in 3D.")
        return None
    try:
        if run.experiment.pictures != "gripper":
            fields[place] = finger.read(run.fields, len(run.result))
        scene = scene_of(run, fields.get(place))
        page.scenes.append(scene.packed())
        page.stills += _stills(run, scene)
    except ValueError as error:
        raise ConfigError(str(error)) from None
    shown = len(scene.load.rows)
    if shown < len(run.result):
        page.remarks.append(
            f"{run.title}: the 3D view has {shown} of {len(run.result)} steps, and shapes between "
            "them."
        )
    return len(page.scenes) - 1


def _stills(run: runs.Run, scene: Scene) -> list[tuple[str, bytes]]:
    """Pictures of the run in place of the 3D view."""
    if (painter := drawer(run.experiment.pictures)) is not None:
        image = painter.strip(run.folder, run.result.config, run.result)
        return [(scene.alt, _png(image, STILL_PX))]
    pressures = run.column("pressure_kPa")
    if pressures is None or run.experiment.control.name != "pressure_kPa":
        return []
    loading = np.flatnonzero(np.array(run.branch) == "loading")
    if not len(loading):
        return []
    rows = loading[np.unique(np.linspace(0, len(loading) - 1, STILLS).round().astype(int))]
    wanted = list(dict.fromkeys(float(pressures[row]) for row in rows))
    others = Beside.of_run(run.result.config, run.result.plate)
    drawn = render.draw(run.fields, wanted, result=run.result, beside=others, height_in=STILL_IN)
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


def _charts(
    read: Sequence[runs.Run],
    measured: Columns | None,
    scenes: dict[int, int],
    finer: dict[int, int],
) -> list[Chart]:
    """The charts of all runs; results of one experiment share theirs."""
    charts = []
    for name in dict.fromkeys(run.experiment.name for run in read):
        group = [i for i, run in enumerate(read) if run.experiment.name == name]
        shown = [DrawnResult(read[i].result, scene=scenes.get(i)) for i in group]
        if len(group) > 1:
            shown = [
                replace(
                    drawn,
                    name=read[i].title.partition(", ")[2]
                    + (" (finest mesh)" if i in finer.values() else ""),
                    style="dash" if i in finer.values() else "line",
                )
                for i, drawn in zip(group, shown, strict=True)
            ]
        experiment, turn = read[group[0]].experiment, read[group[0]].result.turning_point
        for number, panel in enumerate(panels(experiment, shown[0].table)):
            try:
                charts.append(
                    chart(
                        experiment, shown, panel, measured=measured,
                        turning_point=turn if len(group) == 1 and not number else None,
                    )
                )  # fmt: skip
            except ValueError:  # no result has these readings
                continue
        if swings := spectrum(experiment, shown, measured):
            charts.append(swings)
    return charts
