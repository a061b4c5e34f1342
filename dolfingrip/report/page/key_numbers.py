"""The five numbers at the head of a page."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

import numpy as np

from dolfingrip.channels import FORCE, STRETCH, of_band
from dolfingrip.files.run import GraspKind
from dolfingrip.report.page.content import Check, KeyNumber
from dolfingrip.report.page.finger import Fields
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.runs import Run, over

MOST: Final = 5

PRINTED: Final = "neo-hooke"
"""Law of printed NinjaFlex, the default material."""

STRETCH_LIMIT: Final = 2.5
"""Largest stretch up to which printed NinjaFlex follows this law; it stiffens beyond."""


def of_runs(runs: Sequence[Run], fields: dict[int, Fields]) -> list[KeyNumber]:
    """List the main readings of each experiment.

    Args:
        runs: results.
        fields: of the runs that have them, by the run's place.

    Returns:
        Numbers of the first run of each experiment.
    """
    numbers: list[KeyNumber] = []
    seen: set[str] = set()
    for place, run in enumerate(runs):
        if run.experiment.name in seen:
            continue
        seen.add(run.experiment.name)
        numbers += OWN.get(run.experiment.name, _main)(run)
        if run.experiment.name != "grasp":
            numbers += _stretch(run, fields.get(place), {number.name for number in numbers})
    return numbers


def summary(checks: Sequence[Check]) -> list[KeyNumber]:
    """Count the checks that pass.

    Args:
        checks: of all results.

    Returns:
        One number; none without checks.
    """
    done = [check for check in checks if check.verdict in ("pass", "fail")]
    if not checks:
        return []
    failed = [check for check in done if check.verdict == "fail"]
    open_ = len(checks) - len(done)
    value = f"{len(done) - len(failed)} of {len(done)}"
    if failed:
        return [KeyNumber("Checks passed", value, "fail", f"fail: {failed[0].name}")]
    if open_:
        return [KeyNumber("Checks not made", str(open_), "open", f"{value} made pass")]
    return [KeyNumber("Checks passed", value, "pass", "pass")]


def _at(run: Run, row: int) -> str:
    along = over(run)
    values = run.column(along.name)
    return "" if values is None else f"at {said(float(values[row]), along.symbol)}"


def _main(run: Run) -> list[KeyNumber]:
    """The first curve of the experiment's plot, where it is largest."""
    curve = run.experiment.plot.curves[0]
    y = run.column(curve.column)
    if y is None:
        return []
    row = int(np.nanargmax(np.abs(y)))
    channel = next((c for c in run.experiment.table if c.name == curve.column), None)
    name = channel.title if channel else curve.label
    value = said(float(y[row]), channel.symbol if channel else "")
    complete = run.result.facts.complete
    words = "reached" if complete else "the path ended early"
    remarks = [_at(run, row), *_band(run, curve.column, row), words]
    return [KeyNumber(name, value, "pass" if complete else "fail", ", ".join(remarks))]


def _band(run: Run, column: str, row: int) -> list[str]:
    """The band of a reading in words; empty where it has none."""
    low, high = (run.column(end) for end in of_band(column))
    if low is None or high is None:
        return []
    return [f"95 %: {said(float(low[row]))} to {said(float(high[row]))}"]


def _blocked(run: Run) -> list[KeyNumber]:
    shown = _main(run)
    shown = [KeyNumber(f"Blocked {FORCE.title.lower()}", e.value, e.verdict, e.said) for e in shown]
    turn = run.result.turning_point
    if turn:
        value = said(turn.pressure_kPa, "kPa")
        shown.append(KeyNumber("Force turns steeper", value, "", f"turning point; {turn.touch}"))
    return shown


def _grasp(run: Run) -> list[KeyNumber]:
    outcome = run.result.outcome
    kind, words = ("unknown", "") if outcome is None else (outcome.kind, outcome.sentence)
    good = kind == GraspKind.PICKED_UP
    shown = [KeyNumber("Grasp", kind, "pass" if good else "fail", words)]
    for name, title in (("normal_A_N", "Thumb's normal force"), ("slip_mm", "Slip")):
        y = run.column(name)
        if y is not None:
            unit = name.rpartition("_")[2]
            shown.append(KeyNumber(title, said(float(y[-1]), unit), "", "at the end"))
    return shown


def _stretch(run: Run, fields: Fields | None, there: set[str]) -> list[KeyNumber]:
    name = "Largest stretch"
    if fields is None or STRETCH.name not in fields.further or name in there:
        return []
    most = max(float(step.max()) for step in fields.further[STRETCH.name])
    if run.result.config.material.law != PRINTED:
        return [KeyNumber(name, said(most), "", "at a node, over all steps")]
    good = most <= STRETCH_LIMIT
    words = f"{'below' if good else 'above'} {STRETCH_LIMIT:g}, where the print stiffens"
    return [KeyNumber(name, said(most), "pass" if good else "fail", words)]


OWN: Final[dict[str, Callable[[Run], list[KeyNumber]]]] = {
    "blocked_force": _blocked,
    "grasp": _grasp,
}
"""Experiments whose numbers are more than the largest value of their plot."""
