"""A diagnosis on a page: three lines, readings, causes, tables and what stays unexplained."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, Final

import numpy as np
import pandas as pd

from dolfingrip.charts.chart import Chart
from dolfingrip.files.diagnosis import DiagnosisFile
from dolfingrip.files.diagnosis_words import LEAST, cautions, chance, lines, tables
from dolfingrip.report.diagnosis import BAND_STD, overlays, panels, probabilities
from dolfingrip.report.page.content import (
    Contribution,
    DiagnosisPart,
    FoundResult,
    KeyNumber,
    Page,
    Source,
    Verdict,
)
from dolfingrip.report.page.numbers import said

BY_CHANCE: Final = 0.046
"""Share of readings that noise alone puts outside two standard deviations."""

VERDICTS: Final[dict[str, tuple[Verdict, str]]] = {
    "cause": ("fail", ""), "unknown": ("open", "unknown cause"), "none": ("pass", "no cause"),
}  # fmt: skip
"""How each answer is shown, and in which words if it names nothing."""


class Diagnosed(Contribution):
    """Part of the page on what a simulation gets wrong, and why."""

    marks: ClassVar = {"diagnose": DiagnosisFile.FILE}
    titles: ClassVar = {"diagnose": "diagnosis"}
    place = 30

    def show(self, page: Page, result: FoundResult) -> None:
        content = DiagnosisFile.read(result.folder)
        page.diagnoses.append(_part(content, DiagnosisFile.readings_in(result.folder)))
        page.sources.append(_source(result.folder, content))
        kind, words = VERDICTS[content.verdict.answer]
        if content.verdict.answer == "none" and not content.verdict.claimed:
            kind, words = "open", "cannot tell"
        value = words or " or ".join(content.verdict.effects).replace("_", " ")
        sure = f"probability {chance(content.verdict.probability)}"
        page.numbers.append(KeyNumber("Diagnosis", value, kind, sure))


def _source(folder: Path, content: DiagnosisFile) -> Source:
    again = f"dolfingrip diagnose {shlex.join(content.data)}" if content.data else ""
    extended = folder / "extended.toml"
    files = []
    if extended.is_file():
        files.append(("Extended configuration", extended.read_text(encoding="utf-8")))
    return Source("Diagnosis", str(folder), again, [("dolfingrip", content.version)], files)


def _part(content: DiagnosisFile, readings: pd.DataFrame | None) -> DiagnosisPart:
    answer, *others = lines(content)
    charts: Sequence[Chart] = ()
    if readings is not None and len(readings):
        charts = overlays(content, readings)
    bars = probabilities(content, LEAST)
    unexplained = _unexplained(content, readings)
    return DiagnosisPart("Diagnosis", answer, others, bars, charts, tables(content), unexplained)


def _unexplained(content: DiagnosisFile, readings: pd.DataFrame | None) -> list[str]:
    """Sentences on what stays unexplained, and where."""
    said_of_it = [f"Of what the model misses {100 * content.verdict.unexplained:.2g} % stays"]
    said_of_it += cautions(content)
    for panel in panels(readings) if readings is not None and len(readings) else ():
        part, along = panel.part, panel.over
        off = np.abs(part["value"] - part["after"]) > BAND_STD * part["noise"]
        if off.mean() > BY_CHANCE and off.sum() > 1:
            where = part.loc[off, along.name]
            said_of_it.append(
                f"{panel.title}, {panel.channel.title.lower()}: {100 * off.mean():.0f} % of the "
                f"readings lie outside two standard deviations, from "
                f"{said(float(where.min()))} to {said(float(where.max()), along.symbol)}"
            )
    return said_of_it
