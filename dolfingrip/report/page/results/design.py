"""A design by gradients on a page: its steps, its parameters, its constraints."""

from __future__ import annotations

from pathlib import Path
from typing import ClassVar

from dolfingrip.charts.chart import Chart
from dolfingrip.files.design import RUNS, DesignFile
from dolfingrip.files.run import RunFile
from dolfingrip.files.table import read_csv
from dolfingrip.report.design import course, followed, label, sections
from dolfingrip.report.fields import list_steps, read_steps
from dolfingrip.report.page.content import (
    Check,
    Contribution,
    FoundResult,
    KeyNumber,
    Page,
    Source,
)
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import read
from dolfingrip.report.page.trust import MESH_ERROR, OPEN, passes

STEPS = "steps.csv"


class GradientDesign(Contribution):
    """The design that gradients found, and the way to it."""

    marks: ClassVar = {"design": DesignFile.FILE}
    titles: ClassVar = {"design": "design by gradients"}
    inside = RUNS
    place = 40

    def show(self, page: Page, result: FoundResult) -> None:
        content = DesignFile.read(result.folder)
        page.charts += _change(result.folder, content)
        if (file := result.folder / STEPS).is_file():
            page.charts += course(content, read_csv(file))
        content = content.shown
        page.tables.append(content.tables()[0])
        page.checks += [
            Check(
                f"Design: {limit.of}", f"{limit.value:.5g}", f"{limit.sense} {limit.limit:g}",
                "pass" if limit.kept else "fail", "kept" if limit.kept else "not kept",
            )
            for limit in content.constraints
        ]  # fmt: skip
        page.checks.append(_mesh(content))
        page.numbers += _numbers(content)
        page.sources.append(_source(result.folder, content))


def _change(folder: Path, content: DesignFile) -> list[Chart]:
    """Start beside design: their sections, and the lines of what shall follow a curve."""
    folders = {name: folder / name for name in RUNS if RunFile.is_in(folder / name)}
    runs = {name: read(path) for name, path in folders.items()}
    if len(runs) < len(RUNS):
        return []
    charts = []
    if all(run.fields.is_file() for run in runs.values()):
        first = {name: list_steps(run.fields)[:1] for name, run in runs.items()}
        charts = sections({name: read_steps(files)[0] for name, files in first.items()})
    curve, near = runs[RUNS[0]].result.config.curve, content.matched
    if curve is not None and near is not None:
        note = f"Root mean square distance: {said(near.start_rms_mm)} mm at the start, "
        note += f"{said(near.rms_mm)} mm by the design."
        charts += followed(curve, {name: run.result for name, run in runs.items()}, note)
    return charts


def _mesh(content: DesignFile) -> Check:
    """The design's objective against that on a finer mesh."""
    name, goal, refined = "Design: mesh", f"≤ {100 * MESH_ERROR:g} %", content.refined
    if refined is None or not refined.objective:
        why = "the finer mesh was not asked for" if refined is None else refined.failure
        return Check(name, "–", goal, "open", f"{OPEN}: {why}")
    error = abs(content.objective / refined.objective - 1)
    coarse, finer = said(content.objective), said(refined.objective)
    words = f"{content.quantity} {coarse}, on a finer mesh {finer}"
    return Check(name, f"{100 * error:.2g} %", goal, passes(error <= MESH_ERROR), words)


def _numbers(content: DesignFile) -> list[KeyNumber]:
    title, _, tail = label(content.quantity).partition(" (")
    words = f"by {content.simulations} simulations"
    if content.gain is not None:
        words = f"{100 * content.gain:+.1f} % {words}"
    if content.refined is not None and content.refined.gain is not None:
        words += f"; {100 * content.refined.gain:+.1f} % on a finer mesh"
    start, best = (said(value, tail.rstrip(")")) for value in (content.start, content.objective))
    return [
        KeyNumber(f"{title} of the start", start),
        KeyNumber(f"{title} of the design", best, "", words),
    ]


def _source(folder: Path, content: DesignFile) -> Source:
    facts = [
        ("objective", content.of),
        ("simulations", str(content.simulations)),
        ("end", content.ending),
    ]
    problem = folder / "design.toml"
    files = [("Problem", problem.read_text(encoding="utf-8"))] if problem.is_file() else []
    return Source("Design by gradients", str(folder), "", facts, files)
