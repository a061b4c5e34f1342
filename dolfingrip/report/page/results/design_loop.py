"""A design loop on a page: campaign, surrogate and optimisation share one front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from dolfingrip.files.campaign import CampaignFile
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.files.surrogate import SurrogateFile
from dolfingrip.report.page import front
from dolfingrip.report.page.content import Contribution, FoundResult, Given, KeyNumber, Page, Source
from dolfingrip.report.page.numbers import said


class DesignLoop(Contribution):
    """The front, its designs, and how the surrogate learnt."""

    marks: ClassVar = {
        "optimise": OptimumFile.FILE, "train": SurrogateFile.FILE, "doe": CampaignFile.FILE,
    }  # fmt: skip
    titles: ClassVar = {"optimise": "chosen design", "train": "surrogate", "doe": "designs"}
    place = 20

    def add(self, page: Page, results: Sequence[FoundResult], given: Given) -> list[str]:
        given.say("making the shapes of the designs")
        loop = front.Loop.of(results)
        page.front = front.front(loop)
        page.charts += front.charts(loop.surrogate)
        if page.front is not None:
            shown = page.front
            for point in [p for p in shown.points if p.group == "chosen"][:1]:
                at = f"at {said(point.x, shown.x.unit)} of {shown.x.short}"
                name = f"{shown.y.short} of the chosen design"
                page.numbers.append(KeyNumber(name, said(point.y, shown.y.unit), "", at))
        titles = {
            "train": "Surrogate",
            "optimise": "Optimisation",
            "doe": "Design of experiments",
        }
        for result in results:
            facts: dict[str, str] = {}
            if result.kind == "train":
                facts = SurrogateFile.read(result.folder).versions
            elif result.kind == "optimise":
                facts = OptimumFile.read(result.folder).versions
            page.sources.append(
                Source(titles[result.kind], str(result.folder), "", list(facts.items()))
            )
        return self.named(results)
