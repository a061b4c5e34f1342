"""The design loop on a page: computed designs, the surrogate's front, the shapes of both."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.channels import CHANNELS
from dolfingrip.config import Config
from dolfingrip.report.design import LABELS
from dolfingrip.report.page.content import Axis, Chart, Front, FrontPoint, Series, Table
from dolfingrip.report.page.design_shape import design_shape
from dolfingrip.report.page.numbers import said, with_error
from dolfingrip.report.page.sources import read_json
from dolfingrip.sections.errors import ConfigError
from dolfingrip.sections.units import unit

Rows = list[dict[str, str]]


@dataclass(frozen=True, slots=True)
class FrontPolicy:
    """How much of a design loop a page shows.

    Attributes:
        along: points of the surrogate's front that can be pointed at.
        shapes: designs with a shape; choices come first.
        designs: designs of experiments; others are left out evenly.
    """

    along: int = 12
    shapes: int = 40
    designs: int = 400


POLICY: Final = FrontPolicy()


@dataclass(frozen=True, slots=True)
class Loop:
    """What is known of a design loop; each folder may be missing.

    Attributes:
        surrogate, optimum: folders of the training and of the optimisation.
        designs: computed designs: ``inputs`` and ``outputs`` by name, and the ``config`` of each.
    """

    surrogate: Path | None
    optimum: Path | None
    designs: Sequence[Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class _Design:
    """A design before its shape is made."""

    label: str
    group: str
    inputs: dict[str, float]
    predicted: dict[str, float]
    computed: dict[str, float]
    failure: str = ""


def front(loop: Loop, most_shapes: int = POLICY.shapes) -> Front | None:
    """The front of a design loop; None if fewer than two outputs are known.

    Args:
        loop: what is known of it.
        most_shapes: designs with a shape.
    """
    facts = read_json(loop.surrogate / "surrogate.json") if loop.surrogate else {}
    found = [*_chosen(loop.optimum), *_along(loop.optimum), *_computed(loop)]
    outputs = list(facts.get("outputs", {})) or _outputs(found)
    if len(outputs) < 2 or not found:
        return None
    across, up = outputs[:2]
    errors = {k: v.get("test") for k, v in facts.get("rms_error", {}).items()}
    shapes = _Shapes(base_of(loop), most_shapes)
    points = []
    for each in found:
        values = {**each.predicted, **each.computed}
        if across not in values or up not in values:
            continue
        points.append(
            FrontPoint(
                each.label, values[across], values[up], each.group,
                _rows(each, outputs, errors), shapes.of(each.inputs), each.inputs,
            )
        )  # fmt: skip
    if not points:
        return None
    line = _line(loop.optimum, across, up)
    start = next((i for i, p in enumerate(points) if p.group == "chosen"), 0)
    return Front(
        "Designs", _axis(across), _axis(up), points, line, shapes.packed, start,
        _said(found, errors, shapes),
    )  # fmt: skip


def charts(surrogate: Path | None) -> list[Chart]:
    """How the surrogate learnt."""
    file = surrogate / "learning_curve.csv" if surrogate else None
    if file is None or not file.is_file():
        return []
    rows = _csv(file)
    epoch = np.array([float(row["epoch"]) for row in rows])
    series, columns = [], []
    for name, key in (("training", "training_mse"), ("test", "test_mse")):
        values = np.log10([max(float(row[key]), 1e-30) for row in rows])
        series.append(Series(name, epoch, values, "line" if name == "training" else "dash"))
        columns.append([said(10**v) for v in values])
    cells = [[said(e), a, b] for e, a, b in zip(epoch, *columns, strict=True)]
    return [
        Chart(
            "How the surrogate learnt",
            "Mean squared error of the normalised outputs over the epochs of the training.",
            Axis("Epoch"), Axis("log₁₀ of the MSE"), series,
            Table(["Epoch", "Training error", "Test error"], cells),
        )
    ]  # fmt: skip


def study(folder: Path) -> Table:
    """The best rates of a study of hyperparameters."""
    file = folder / "best.csv"
    rows = _csv(file if file.is_file() else folder / "combinations.csv")
    headings = list(rows[0]) if rows else []
    cells = [[_cell(row[name]) for name in headings] for row in rows[:20]]
    return Table(headings, cells, "How the optimiser's choice scatters")


def _cell(text: str) -> str:
    try:
        return said(float(text))
    except ValueError:
        return text


class _Shapes:
    """Unloaded shapes of designs, each packed once."""

    def __init__(self, base: Config | None, most: int) -> None:
        self._base, self._most = base, most
        self._known: dict[tuple[tuple[str, float], ...], int | None] = {}
        self.packed: list[dict[str, Any]] = []
        self.missed = 0

    def of(self, inputs: Mapping[str, float]) -> int | None:
        """Number of the shape with these inputs; None if there is none."""
        key = tuple(sorted(inputs.items()))
        if key not in self._known:
            self._known[key] = self._made(inputs)
        return self._known[key]

    def _made(self, inputs: Mapping[str, float]) -> int | None:
        if self._base is None or len(self.packed) >= self._most:
            self.missed += 1
            return None
        try:
            scene = design_shape(self._base, inputs)
        except (ConfigError, ValueError):
            self.missed += 1
            return None
        self.packed.append(scene.packed())
        return len(self.packed) - 1


def base_of(loop: Loop) -> Config | None:
    """The configuration that a design's inputs are set in."""
    facts = read_json(loop.surrogate / "surrogate.json") if loop.surrogate else {}
    data = (facts.get("campaign") or {}).get("base")
    if data is None and loop.designs:
        data = loop.designs[0].get("config")
    if not data:
        return None
    try:
        # the tables of other kinds of geometry are absent
        return configuration.from_dict({key: table for key, table in data.items() if table})
    except ConfigError:
        return None


def _chosen(optimum: Path | None) -> list[_Design]:
    """The original and the chosen designs, with finite elements where they were computed."""
    if optimum is None:
        return []
    found = []
    for one in read_json(optimum / "optimum.json").get("designs", ()):
        limit = one.get("cog_max_mm")
        role = str(one.get("role", "chosen"))
        label = role.capitalize() + (f", COG offset ≤ {said(limit, 'mm')}" if limit else "")
        group = "original" if role == "original" else "chosen"
        found.append(
            _Design(
                label, group, dict(one["inputs"]), dict(one.get("surrogate") or {}),
                dict(one.get("fem") or {}), str(one.get("failure", "")),
            )
        )  # fmt: skip
    return found


def _along(optimum: Path | None) -> list[_Design]:
    """Points along the surrogate's front."""
    file = optimum / "front.csv" if optimum else None
    if file is None or not file.is_file():
        return []
    rows = _csv(file)
    keep = np.unique(
        np.linspace(0, len(rows) - 1, min(POLICY.along, len(rows))).round().astype(int)
    )
    found = []
    for number, place in enumerate(keep, 1):
        inputs, outputs = _split(rows[place])
        found.append(_Design(f"Front {number} of {len(keep)}", "front", inputs, outputs, {}))
    return found


def _computed(loop: Loop) -> list[_Design]:
    """Designs of experiments that were computed."""
    done = [row for row in loop.designs if row.get("outputs")]
    if done:
        keep = np.unique(np.linspace(0, len(done) - 1, min(POLICY.designs, len(done))).astype(int))
        return [
            _Design(f"Design {i + 1}", "design", dict(done[i]["inputs"]), {},
                    {k: float(v) for k, v in done[i]["outputs"].items() if v is not None})
            for i in keep
        ]  # fmt: skip
    file = loop.surrogate / "designs.csv" if loop.surrogate else None
    if file is None or not file.is_file():
        return []
    facts = read_json(file.parent / "surrogate.json")
    found = []
    for number, row in enumerate(_csv(file)[: POLICY.designs], 1):
        inputs = {name: float(row[name]) for name in facts.get("inputs", ())}
        outputs = {name: float(row[name]) for name in facts.get("outputs", ())}
        _, predicted = _split({k: v for k, v in row.items() if k.startswith("surrogate.")})
        found.append(_Design(f"Design {number}", "design", inputs, predicted, outputs))
    return found


def _outputs(designs: Sequence[_Design]) -> list[str]:
    return list(dict.fromkeys(name for d in designs for name in (*d.predicted, *d.computed)))


def _split(row: Mapping[str, str]) -> tuple[dict[str, float], dict[str, float]]:
    """Inputs of a row, and the surrogate's outputs by their own names."""
    prefix = "surrogate."
    inputs = {k: float(v) for k, v in row.items() if not k.startswith(prefix)}
    outputs = {k.removeprefix(prefix): float(v) for k, v in row.items() if k.startswith(prefix)}
    return inputs, outputs


def _rows(
    design: _Design, outputs: Sequence[str], errors: Mapping[str, float | None]
) -> list[tuple[str, str]]:
    """Parameters and outputs of a design, the surrogate's with its error on designs held out."""
    found = [(_label(name), said(value)) for name, value in design.inputs.items()]
    for name in outputs:
        error = errors.get(name)
        if name in design.computed:
            found.append((f"{_label(name)}, finite elements", said(design.computed[name])))
        if name in design.predicted:
            value = design.predicted[name]
            told = said(value) if error is None else with_error(value, error)
            found.append((f"{_label(name)}, surrogate", told))
    if design.failure:
        found.append(("Finite elements", f"failed: {design.failure}"))
    return found


def _label(name: str) -> str:
    return LABELS.get(name, CHANNELS[name].label if name in CHANNELS else name)


def _axis(name: str) -> Axis:
    label = _label(name)
    return Axis(label, unit(name), label.partition(" (")[0])


def _line(optimum: Path | None, across: str, up: str) -> tuple[list[float], list[float]] | None:
    file = optimum / "front.csv" if optimum else None
    if file is None or not file.is_file():
        return None
    values = [_split(row)[1] for row in _csv(file)]
    if not values or across not in values[0] or up not in values[0]:
        return None
    values.sort(key=lambda each: each[across])
    return [float(f"{v[across]:.6g}") for v in values], [float(f"{v[up]:.6g}") for v in values]


def _said(
    designs: Sequence[_Design], errors: Mapping[str, float | None], shapes: _Shapes
) -> list[str]:
    count = sum(design.group == "design" for design in designs)
    found = [f"{count} designs were computed. Point at one, or reach it with the Tab key."]
    if errors:
        told = ", ".join(
            f"{_label(name)} {said(error)}" for name, error in errors.items() if error is not None
        )
        found.append(f"± is the surrogate's root mean square error on designs held out: {told}.")
    if shapes.packed:
        text = "Shapes are drawn without load."
        if shapes.missed:
            text += f" {shapes.missed} designs are shown without a shape."
        found.append(text)
    return found


def _csv(file: Path) -> Rows:
    with file.open(encoding="utf-8", newline="") as stream:
        return list(csv.DictReader(stream))
