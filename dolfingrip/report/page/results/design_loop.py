"""A design loop on a page: campaign, surrogate and optimisation share one front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from dolfingrip.files.campaign import CampaignFile
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.files.surrogate import SurrogateFile
from dolfingrip.files.table import Columns
from dolfingrip.report.design import learning_curve
from dolfingrip.report.page import front
from dolfingrip.report.page.content import Contribution, FoundResult, KeyNumber, Page, Source
from dolfingrip.report.page.numbers import said


class DesignLoop(Contribution):
    """The front, its designs, and how the surrogate learnt."""

    marks: ClassVar = {
        "optimise": OptimumFile.FILE, "train": SurrogateFile.FILE, "doe": CampaignFile.FILE,
    }  # fmt: skip
    titles: ClassVar = {"optimise": "chosen design", "train": "surrogate", "doe": "designs"}
    place = 20

    def add(
        self, page: Page, results: Sequence[FoundResult], measured: Columns | None
    ) -> list[str]:
        loop = front.Loop.of(results)
        page.front = front.front(loop)
        if loop.surrogate and (curve := SurrogateFile.learning_curve(loop.surrogate)):
            page.charts.append(learning_curve(curve, None))
        if page.front is not None:
            shown = page.front
            for point in [p for p in shown.points if p.group == "chosen"][:1]:
                at = f"at {said(point.x, shown.x.unit)} of {shown.x.short}"
                name = f"{shown.y.short} of the chosen design"
                page.numbers.append(KeyNumber(name, said(point.y, shown.y.unit), "", at))
        return super().add(page, results, measured)

    def show(self, page: Page, result: FoundResult) -> None:
        title, facts = "Design of experiments", dict[str, str]()
        if result.kind == "train":
            title, facts = "Surrogate", SurrogateFile.read(result.folder).versions
        elif result.kind == "optimise":
            title, facts = "Optimisation", OptimumFile.read(result.folder).versions
        page.sources.append(Source(title, str(result.folder), "", list(facts.items())))
