"""A study of the optimiser's hyperparameters on a page: the best rates."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.files.table import read_csv
from dolfingrip.files.text_table import TextTable
from dolfingrip.report.page.content import Contribution, FoundResult, Page, Source
from dolfingrip.report.page.numbers import said

MOST = 20
"""Rows of the table."""


class Study(Contribution):
    """How the optimiser's choice scatters."""

    marks: ClassVar = {"study": "combinations.csv"}
    titles: ClassVar = {"study": "study of the optimiser"}
    place = 60

    def show(self, page: Page, result: FoundResult) -> None:
        best = result.folder / "best.csv"
        table = read_csv(best if best.is_file() else result.folder / self.marks["study"])
        rows = [[_cell(text) for text in row] for row in zip(*table.values(), strict=True)]
        title = "How the optimiser's choice scatters"
        page.tables.append(TextTable(list(table), rows[:MOST], title))
        page.sources.append(Source("Study of the optimiser", str(result.folder), ""))


def _cell(text: str) -> str:
    try:
        return said(float(text))
    except ValueError:
        return text
