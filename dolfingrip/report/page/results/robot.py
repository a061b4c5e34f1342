"""A finger's reduced model beside finite elements, on a page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

from dolfingrip.charts.chart import Axis, Chart, Series
from dolfingrip.files.robot import QuantityError, RobotFile
from dolfingrip.report.page.content import Contribution, FoundResult, Given, KeyNumber, Page, Source


class ReducedModel(Contribution):
    """Each quantity by finite elements and by the chain, at states that were not fitted."""

    marks: ClassVar = {"robot": RobotFile.FILE}
    titles: ClassVar = {"robot": "reduced model"}
    place = 70

    def add(self, page: Page, found: Sequence[FoundResult], given: Given) -> list[str]:
        for each in found:
            robot = RobotFile.read(each.folder)
            for error in robot.comparisons:
                page.charts.append(_chart(error))
                page.numbers.append(
                    KeyNumber(
                        f"Error: {error.title}", f"{error.rms:.2g} {error.unit} rms", "",
                        f"{error.largest:.2g} {error.unit} at most, at states that were not fitted",
                    )
                )  # fmt: skip
            (low, high), gaps = robot.valid.pressure_kPa, robot.valid.gaps_mm
            facts = [
                ("joints", f"{len(robot.joints)}"),
                ("valid", f"{low:g} to {high:g} kPa, up to {robot.valid.force_N:.3g} N"),
                ("valid for plates", f"at {min(gaps):.3g} to {max(gaps):.3g} mm"),
                ("in MuJoCo", f"python -m mujoco.viewer --mjcf={each.folder / 'finger.xml'}"),
                *robot.versions.items(),
            ]
            page.sources.append(Source("Reduced model", str(each.folder), RobotFile.MADE_BY, facts))
        return self.named(found)


def _chart(error: QuantityError) -> Chart:
    series = (
        Series("finite elements", error.pressure_kPa, error.finite_elements, "points"),
        Series("reduced model", error.pressure_kPa, error.chain),
    )
    label = f"{error.title} ({error.unit})"
    note = f"None of these states was fitted. The difference is {error.rms:.2g} {error.unit} rms."
    return Chart(
        f"Reduced model: {error.title}", Axis("Pressure (kPa)", "kPa"),
        Axis(label, error.unit), series, note=note,
    )  # fmt: skip
