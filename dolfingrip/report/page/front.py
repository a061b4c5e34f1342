"""The design loop on a page: computed designs, the surrogate's front, the shapes of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip import config as configuration
from dolfingrip.charts.chart import Axis
from dolfingrip.config import Config
from dolfingrip.files.campaign import CampaignDesign, CampaignFile
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.files.surrogate import LearntDesign, SurrogateFile
from dolfingrip.report.design import label, unit_of
from dolfingrip.report.page.content import FoundResult, Front, FrontPoint
from dolfingrip.report.page.finger import unloaded_shape
from dolfingrip.report.page.numbers import said, with_error
from dolfingrip.sections.errors import ConfigError

ALONG: Final = 12
"""Points of the surrogate's front that can be pointed at."""

SHAPES: Final = 40
"""Designs with a shape; choices come first."""

DESIGNS: Final = 400
"""Designs of experiments; others are left out evenly."""


@dataclass(frozen=True, slots=True)
class Loop:
    """Results of a design loop; each part may be missing.

    Attributes:
        surrogate: folder of the training.
        learnt: what the surrogate learnt.
        optimum: the optimisation.
        campaigns: computed designs.
    """

    surrogate: Path | None = None
    learnt: SurrogateFile | None = None
    optimum: OptimumFile | None = None
    campaigns: Sequence[CampaignFile] = ()

    @classmethod
    def of(cls, results: Sequence[FoundResult]) -> Loop:
        """Read a design loop.

        Args:
            results: results; the first of a kind counts.

        Returns:
            What is known of it.

        Raises:
            ResultFileError: one line, if a result cannot be read.
        """
        trained, chosen, campaigns = (
            [result.folder for result in results if result.kind == kind]
            for kind in ("train", "optimise", "doe")
        )
        return cls(
            trained[0] if trained else None,
            SurrogateFile.read(trained[0]) if trained else None,
            OptimumFile.read(chosen[0]) if chosen else None,
            [CampaignFile.read(folder) for folder in campaigns],
        )

    @property
    def designs(self) -> list[CampaignDesign]:
        """The designs of all campaigns."""
        return [design for campaign in self.campaigns for design in campaign.designs]

    @property
    def errors(self) -> Mapping[str, float]:
        """Root mean square error of the surrogate on designs held out, by output."""
        return {} if self.learnt is None else self.learnt.errors


@dataclass(frozen=True, slots=True)
class _Design:
    """A design before its shape is made."""

    label: str
    group: str
    inputs: Mapping[str, Any]
    predicted: dict[str, float]
    computed: dict[str, float] = field(default_factory=dict)
    failure: str = ""


def front(loop: Loop, most_shapes: int = SHAPES) -> Front | None:
    """The front of a design loop; None if fewer than two outputs are known.

    Args:
        loop: what is known of it.
        most_shapes: designs with a shape.

    Returns:
        The front with the shapes of its designs.
    """
    designs = [*_chosen(loop.optimum), *_along(loop.optimum), *_computed(loop)]
    outputs = list(loop.learnt.outputs) if loop.learnt else _outputs(designs)
    if len(outputs) < 2 or not designs:
        return None
    across, up = outputs[:2]
    if loop.optimum is not None:
        across, up = (objective.title for objective in loop.optimum.objectives)
    errors = loop.errors
    shapes = _Shapes(base_of(loop), most_shapes)
    points = []
    for design in designs:
        values = {**design.predicted, **design.computed}
        if across not in values or up not in values:
            continue
        points.append(
            FrontPoint(
                design.label, values[across], values[up], design.group,
                _rows(design, outputs, errors), shapes.of(design.inputs), design.inputs,
            )
        )  # fmt: skip
    if not points:
        return None
    line = _line(loop.optimum, across, up)
    start = next((i for i, p in enumerate(points) if p.group == "chosen"), 0)
    return Front(
        "Designs", _axis(across), _axis(up), points, line, shapes.packed, start,
        _said(designs, errors, shapes),
    )  # fmt: skip


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
            scene = unloaded_shape(configuration.changed(self._base, inputs))
        except (ConfigError, ValueError):
            self.missed += 1
            return None
        self.packed.append(scene.packed())
        return len(self.packed) - 1


def base_of(loop: Loop) -> Config | None:
    """The configuration that a design's inputs are set in.

    Args:
        loop: what is known of a design loop.

    Returns:
        The configuration; None if it is not known.
    """
    data = loop.learnt.base if loop.learnt else None
    if data is None and loop.campaigns:
        data = loop.campaigns[0].base
    if not data:
        return None
    try:
        # the tables of other kinds of geometry are absent
        return configuration.from_dict({key: table for key, table in data.items() if table})
    except ConfigError:
        return None


def _chosen(optimum: OptimumFile | None) -> list[_Design]:
    """The original and the chosen designs, with finite elements where they were computed."""
    if optimum is None:
        return []
    limited = optimum.objectives[0]
    words = label(limited.name).partition(" (")[0]
    designs = []
    for one in optimum.designs:
        limit = "" if one.limit is None else f", {words} ≤ {said(one.limit, limited.unit)}"
        designs.append(
            _Design(
                one.role.capitalize() + limit,
                "original" if one.role == "original" else "chosen",
                one.inputs,
                one.surrogate,
                one.fem or {},
                one.failure,
            )
        )
    return designs


def _along(optimum: OptimumFile | None) -> list[_Design]:
    """Points along the surrogate's front."""
    points = () if optimum is None else optimum.front
    keep = np.unique(np.linspace(0, len(points) - 1, min(ALONG, len(points))).round())
    return [
        _Design(f"Front {number} of {len(keep)}", "front", point.inputs, point.surrogate)
        for number, point in enumerate([points[int(i)] for i in keep], 1)
    ]


def _computed(loop: Loop) -> list[_Design]:
    """Designs of experiments that were computed."""
    done = [(design.inputs, design.outputs) for design in loop.designs if design.outputs]
    if done:
        keep = np.unique(np.linspace(0, len(done) - 1, min(DESIGNS, len(done))).astype(int))
        return [_Design(f"Design {i + 1}", "design", done[i][0], {}, done[i][1]) for i in keep]
    learnt: list[LearntDesign] = []
    if loop.learnt is not None and loop.surrogate is not None:
        learnt = loop.learnt.designs(loop.surrogate)
    return [
        _Design(f"Design {number}", "design", design.inputs, design.predicted, design.outputs)
        for number, design in enumerate(learnt[:DESIGNS], 1)
    ]


def _outputs(designs: Sequence[_Design]) -> list[str]:
    return list(dict.fromkeys(name for d in designs for name in (*d.predicted, *d.computed)))


def _rows(
    design: _Design, outputs: Sequence[str], errors: Mapping[str, float]
) -> list[tuple[str, str]]:
    """Parameters and outputs of a design, the surrogate's with its error on designs held out."""
    rows = [(label(name), said(value)) for name, value in design.inputs.items()]
    for name in outputs:
        error = errors.get(name)
        if name in design.computed:
            rows.append((f"{label(name)}, finite elements", said(design.computed[name])))
        if name in design.predicted:
            value = design.predicted[name]
            text = said(value) if error is None else with_error(value, error)
            rows.append((f"{label(name)}, surrogate", text))
    if design.failure:
        rows.append(("Finite elements", f"failed: {design.failure}"))
    return rows


def _axis(name: str) -> Axis:
    return Axis(label(name), unit_of(name), label(name).partition(" (")[0])


def _line(
    optimum: OptimumFile | None, across: str, up: str
) -> tuple[list[float], list[float]] | None:
    points = () if optimum is None else optimum.front
    values = [point.surrogate for point in points if {across, up} <= set(point.surrogate)]
    if not values:
        return None
    values.sort(key=lambda point: point[across])
    return [float(f"{v[across]:.6g}") for v in values], [float(f"{v[up]:.6g}") for v in values]


def _said(designs: Sequence[_Design], errors: Mapping[str, float], shapes: _Shapes) -> list[str]:
    count = sum(design.group == "design" for design in designs)
    notes = [f"{count} designs were computed. Point at one, or reach it with the Tab key."]
    if errors:
        rms = ", ".join(f"{label(name)} {said(error)}" for name, error in errors.items())
        notes.append(f"± is the surrogate's root mean square error on designs held out: {rms}.")
    if shapes.packed:
        text = "Shapes are drawn without load."
        if shapes.missed:
            text += f" {shapes.missed} designs are shown without a shape."
        notes.append(text)
    return notes
