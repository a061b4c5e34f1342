"""``tally.json``: how many fingers were printed, and what a page shows of it."""

from __future__ import annotations

from typing import ClassVar, Literal

from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.files.result_file import ResultFile
from dolfingrip.report.page.content import Contribution, FoundResult, KeyNumber, Page


class TallyFile(ResultFile):
    """Contents of ``tally.json``."""

    FILE: ClassVar[str] = "tally.json"
    MADE_BY: ClassVar[str] = "the workshop"

    schema_version: Literal[1] = 1
    days: tuple[int, ...]
    printed: tuple[int, ...]


class Tally(Contribution):
    """The chart of printed fingers, and their number."""

    marks: ClassVar = {"tally": TallyFile.FILE}
    titles: ClassVar = {"tally": "tally"}
    place = 90

    def show(self, page: Page, result: FoundResult) -> None:
        tally = TallyFile.read(result.folder)
        series = Series("printed", tally.days, tally.printed)
        page.charts.append(Chart("Printed fingers", Axis("Day"), Axis("Fingers"), [series]))
        page.numbers.append(KeyNumber("Printed", f"{sum(tally.printed)} fingers"))
