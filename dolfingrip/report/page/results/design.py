"""A design by gradients on a page: its steps, its parameters, its constraints."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar

from dolfingrip.charts.chart import Chart
from dolfingrip.files.design import DesignFile
from dolfingrip.files.table import TextTable, read_csv
from dolfingrip.report.design import course, label
from dolfingrip.report.page.content import (
    Check,
    Contribution,
    FoundResult,
    Given,
    KeyNumber,
    Page,
    Source,
)
from dolfingrip.report.page.numbers import said

STEPS = "steps.csv"


class GradientDesign(Contribution):
    """The design that gradients found, and the way to it."""

    marks: ClassVar = {"design": DesignFile.FILE}
    titles: ClassVar = {"design": "design by gradients"}
    place = 40

    def add(self, page: Page, found: Sequence[FoundResult], given: Given) -> list[str]:
        for each in found:
            content = DesignFile.read(each.folder)
            page.charts += _steps(each.folder, content)
            content = content.shown
            page.tables.append(_parameters(content))
            page.checks += [
                Check(
                    f"Design: {limit.of}", f"{limit.value:.5g}", f"{limit.sense} {limit.limit:g}",
                    "pass" if limit.kept else "fail", "kept" if limit.kept else "not kept",
                )
                for limit in content.constraints
            ]  # fmt: skip
            page.numbers.append(_gain(content))
            page.sources.append(_source(each.folder, content))
        return self.named(found)


def _steps(folder: Path, content: DesignFile) -> list[Chart]:
    file = folder / STEPS
    return course(content, read_csv(file)) if file.is_file() else []


def _parameters(content: DesignFile) -> TextTable:
    rows = [
        [name, said(each.start), said(each.value), f"{each.low:g} to {each.high:g}"]
        for name, each in content.parameters.items()
    ]
    return TextTable(["Parameter", "Start", "Found", "Allowed"], rows, "Parameters of the design")


def _gain(content: DesignFile) -> KeyNumber:
    title, _, rest = label(content.quantity).partition(" (")
    words = f"by {content.simulations} simulations"
    if content.gain is not None:
        words = f"{100 * content.gain:+.1f} % {words}"
    if content.refined is not None and content.refined.gain is not None:
        words += f"; {100 * content.refined.gain:+.1f} % on a finer mesh"
    return KeyNumber(f"{title} of the design", said(content.objective, rest.rstrip(")")), "", words)


def _source(folder: Path, content: DesignFile) -> Source:
    facts = [
        ("objective", content.of),
        ("simulations", str(content.simulations)),
        ("end", content.ending),
    ]
    problem = folder / "design.toml"
    files = [("Problem", problem.read_text(encoding="utf-8"))] if problem.is_file() else []
    return Source("Design by gradients", str(folder), "", facts, files)
