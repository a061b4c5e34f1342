"""What a page shows of a design by gradients: its steps, its parameters, its constraints."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any, Final

from dolfingrip.channels import CHANNELS
from dolfingrip.report.page.content import Axis, Chart, Check, KeyNumber, Series, Source, Table
from dolfingrip.report.page.numbers import said
from dolfingrip.report.page.sources import read_json

FILE: Final = "design.json"
STEPS: Final = "steps.csv"


def read(folder: Path) -> tuple[list[Chart], Table, list[Check], list[KeyNumber], Source]:
    """The chart of the steps, the table of parameters, the checks, the numbers, the source.

    Raises:
        ConfigError: one line, if the result cannot be read.
    """
    content = read_json(folder / FILE)
    source = Source(
        "Design by gradients", str(folder), "",
        [("objective", str(content["of"])), ("simulations", str(content["simulations"])),
         ("end", str(content["ending"]))],
        [("Problem", (folder / "design.toml").read_text(encoding="utf-8"))]
        if (folder / "design.toml").is_file() else (),
    )  # fmt: skip
    return _steps(folder, content), _parameters(content), _checks(content), _gain(content), source


def _objective(content: dict[str, Any]) -> tuple[str, str]:
    """The objective's title and unit."""
    words = str(content["of"]).split()
    column = words[1] if len(words) > 1 else ""
    if column in CHANNELS:
        return CHANNELS[column].title, CHANNELS[column].unit
    return column or "Objective", ""


def _steps(folder: Path, content: dict[str, Any]) -> list[Chart]:
    file = folder / STEPS
    if not file.is_file():
        return []
    with file.open(encoding="utf-8", newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["objective"]]
    title, unit = _objective(content)
    count = [float(row["simulations"]) for row in rows]
    value = [float(row["objective"]) for row in rows]
    taken = [i for i, row in enumerate(rows) if row["accepted"] == "True"]
    series = [
        Series("accepted", [count[i] for i in taken], [value[i] for i in taken]),
        Series("all simulations", count, value, "points"),
    ]
    label = f"{title} ({unit})" if unit else title
    cells = [
        [said(c), said(v, unit), "yes" if row["accepted"] == "True" else "no"]
        for c, v, row in zip(count, value, rows, strict=True)
    ]
    return [
        Chart(
            "Steps of the design",
            f"{title} of each simulated design, {content['of']}.",
            Axis("Simulations", short="Simulations"), Axis(label, unit, title), series,
            Table(["Simulations", label, "Accepted"], cells),
        )
    ]  # fmt: skip


def _parameters(content: dict[str, Any]) -> Table:
    rows = [
        [name, said(each["start"]), said(each["value"]), f"{each['low']:g} to {each['high']:g}"]
        for name, each in content["parameters"].items()
    ]
    return Table(["Parameter", "Start", "Found", "Allowed"], rows, "Parameters of the design")


def _checks(content: dict[str, Any]) -> list[Check]:
    return [
        Check(
            f"Design: {each['of']}", f"{each['value']:.5g}", f"{each['sense']} {each['limit']:g}",
            "pass" if each["kept"] else "fail", "kept" if each["kept"] else "not kept",
        )
        for each in content["constraints"]
    ]  # fmt: skip


def _gain(content: dict[str, Any]) -> list[KeyNumber]:
    title, unit = _objective(content)
    gain = f"{content['gain']:+.1%}".replace("%", " %")
    refined = content.get("refined") or {}
    words = f"{gain} by {content['simulations']} simulations"
    if "gain" in refined:
        words += f"; {refined['gain']:+.1%}".replace("%", " %") + " on a finer mesh"
    value = said(content["objective"], unit)
    return [KeyNumber(f"{title} of the design", value, "", words)]
