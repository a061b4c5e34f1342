"""A front that gradients found, on a page."""

from __future__ import annotations

from typing import ClassVar

from dolfingrip.files.front import FrontFile
from dolfingrip.report.design import gradient_front
from dolfingrip.report.page.content import Contribution, FoundResult, KeyNumber, Page, Source
from dolfingrip.report.page.numbers import with_error


class GradientFront(Contribution):
    """The front with its uncertainty, and the best designs along it."""

    marks: ClassVar = {"front": FrontFile.FILE}
    titles: ClassVar = {"front": "front by gradients"}
    place = 50

    def show(self, page: Page, result: FoundResult) -> None:
        front = FrontFile.read(result.folder)
        page.charts += gradient_front(front)
        limited, improved = front.objectives
        if front.levels:
            last = front.levels[-1]
            page.numbers.append(
                KeyNumber(
                    f"{improved.title} on the front",
                    with_error(last.mean, last.deviation, improved.unit), "",
                    f"at {limited.title} {'≤' if limited.sign > 0 else '≥'} {last.limit:g}",
                )
            )  # fmt: skip
        facts = [("simulations", f"{front.simulations}, {front.failed} of them failed")]
        page.sources.append(Source("Front by gradients", str(result.folder), "", facts))
