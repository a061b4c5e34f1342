"""Charts of the design loop: learning curve, fit, front, scatter, a descent and its change."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from dolfingrip.channels import CHANNELS, FORCE, PRESSURE, marker
from dolfingrip.charts.chart import Axis, Chart, Mark, Series
from dolfingrip.files.design import CURVE_RMS, MARKERS, DesignFile, as_shown
from dolfingrip.files.front import FrontFile
from dolfingrip.files.objective import NamedObjective
from dolfingrip.files.optimum import OptimumFile
from dolfingrip.files.surrogate import LearntDesign
from dolfingrip.files.table import Columns, numbers, required
from dolfingrip.report.fields import FieldMesh
from dolfingrip.report.skin import extract_skin
from dolfingrip.sections.curve import CurveTarget
from dolfingrip.sections.units import unit, words

Numbers = npt.NDArray[np.float64]

LABELS: Final = {
    "morph.xi1": "ξ₁",
    "morph.xi2": "ξ₂",
    "cog_offset_mm": "COG offset (mm)",
    "mass_g": "Mass (g)",
    CURVE_RMS: "RMS distance from curve (mm)",
    FORCE.name: FORCE.called("Blocked force").label,
    "finger.wall_mm": "Wall thickness (mm)",
    "finger.base_layer_mm": "Base layer's thickness (mm)",
    "finger.bellows": "Number of bellows",
    "finger.chambers": "Number of chambers",
    "finger.gap_mm": "Gap between bellows (mm)",
    "finger.channel_mm": "Height of the air channel (mm)",
    "finger.base_block_mm": "Length of the clamped block (mm)",
    "finger.tip_mm": "Length of the tip (mm)",
    "material.mu_MPa": "Shear modulus μ (MPa)",
}
"""Labels of quantities and parameters that are no channels, or are called otherwise here."""

OVERRIDE: Final = re.compile(r"finger\.override\.(\d+)\.(\w+)")
"""Key of a dimension of one chamber."""

IN_PLANE: Final = Axis("z from the clamp (mm)", "mm"), Axis("x (mm)", "mm")
"""Axes of charts of the plane in which a finger bends, towards −x."""

PLACES: Final = 4
"""Largest number of parameters whose places along a front are drawn: those that change most."""


def label(name: str) -> str:
    """Say what a quantity or parameter is, with its unit.

    Args:
        name: name in a result, or key of the configuration.

    Returns:
        A label of an axis; of a key of the configuration its name in words, and the name itself,
        which carries its unit, where nothing else is known.

    >>> label("finger.chamber_height_mm"), label("finger.override.3.wall_mm")
    ('Chamber height (mm)', 'Wall thickness of chamber 3 (mm)')
    """
    name, at, place = name.partition(" at ")
    chamber = OVERRIDE.fullmatch(name)
    if chamber:
        name, at, place = f"finger.{chamber[2]}", " of chamber ", chamber[1]
    title = LABELS.get(name, CHANNELS[name].label if name in CHANNELS else name)
    if title == name and "." in name:
        title = words(name) + (f" ({unit(name)})" if unit(name) else "")
    text, bracket, tail = title.partition(" (")
    return f"{text}{at}{place}{bracket}{tail}"


def unit_of(name: str) -> str:
    """Return the unit of a quantity, which may have a place.

    Args:
        name: as ``force_N at 250 kPa``.

    Returns:
        The unit that the name ends in; "" for a pure number.
    """
    return unit(name.partition(" at ")[0])


def axis(objective: NamedObjective, ending: str = "") -> Axis:
    """Make the axis of an objective.

    Args:
        objective: what it shows.
        ending: words after its name.

    Returns:
        The axis with the objective's unit.
    """
    words, bracket, tail = label(objective.title).partition(" (")
    text = f"{words} {ending}".rstrip()
    return Axis(f"{text}{bracket}{tail}", objective.unit, words)


def learning_curve(curve: Mapping[str, Any], goal: float | None) -> Chart:
    """Make the chart of a surrogate's errors.

    Args:
        curve: ``epoch``, ``training_mse`` and ``test_mse`` of the normalised outputs.
        goal: error that is aimed at; None: it is not drawn.

    Returns:
        The chart.
    """
    epoch, floor = np.asarray(curve["epoch"], dtype=float), 1e-30
    series = []
    for name, style in (("training", "line"), ("test", "dash")):
        values = np.maximum(np.asarray(curve[f"{name}_mse"], dtype=float), floor)
        series.append(Series(f"{name}, last {values[-1]:.1e}", epoch, values, style))  # type: ignore[arg-type]
    marks = [] if goal is None else [Mark(goal, f"goal, {goal:g}", colour="grey")]
    return Chart(
        "How the surrogate learnt",
        Axis("Epoch", ends=(0.0, float(epoch[-1]))),
        Axis("Mean squared error (normalised outputs)", short="MSE", log=True),
        series,
        marks,
    )


def fit(
    names: Sequence[str], computed: Numbers, predicted: Numbers, test: npt.NDArray[np.bool_]
) -> list[Chart]:
    """Make charts of predicted against computed outputs.

    Args:
        names: names of the outputs.
        computed: outputs by finite elements, shape (designs, outputs).
        predicted: outputs by the surrogate, shape (designs, outputs).
        test: whether a design was held out of the training, shape (designs,).

    Returns:
        A chart for each output.
    """
    charts = []
    for name, x, y in zip(names, computed.T, predicted.T, strict=True):
        both = [min(x.min(), y.min()), max(x.max(), y.max())]
        rms = np.sqrt(np.mean((y - x)[test] ** 2))
        error = f"test, RMS error {rms:.2g} {unit_of(name)}".strip()
        text = label(name)
        charts.append(
            Chart(
                f"{text}: the surrogate's fit",
                Axis(f"{text}, finite elements", unit_of(name)),
                Axis(f"{text}, surrogate", unit_of(name)),
                [
                    Series("", both, both, colour="grey"),
                    Series("training", x[~test], y[~test], "points", colour="blue", marker="."),
                    Series(error, x[test], y[test], "points", colour="orange", marker="D"),
                ],
                equal=True,
            )
        )
    return charts


def surrogate_front(
    optimum: OptimumFile, failed: int = 0, learnt: Sequence[LearntDesign] = ()
) -> Chart:
    """Make the chart of a front and of the designs it was learnt from (the paper's Fig. 7d).

    Args:
        optimum: the front, its choices, and what of it was computed again.
        failed: number of designs of experiments that failed, for the key.
        learnt: designs of experiments.

    Returns:
        The chart.
    """
    first, second = optimum.objectives

    def place(values: Mapping[str, float]) -> tuple[float, float]:
        return values[first.title], values[second.title]

    def solved(*roles: str) -> list[tuple[float, float]]:
        designs = [design for design in optimum.designs if design.role in roles]
        return [place(design.fem) for design in designs if design.fem is not None]

    series = []
    if learnt:
        lost = f"; {failed} failed, not shown" if failed else ""
        name = f"design of experiments ({len(learnt)}{lost})"
        series.append(_points(name, [place(design.outputs) for design in learnt], "grey", "."))
    name = f"Pareto front of the surrogate ({len(optimum.front)} points)"
    series.append(_points(name, [place(p.surrogate) for p in optimum.front], "blue", "."))
    again = solved("chosen") + [place(e.fem) for e in optimum.front if e.fem is not None]
    if again:
        series.append(_points("computed again by finite elements", again, "ink", "D"))
    if solved("original"):
        series.append(_points("original", solved("original"), "green", "s"))
    chosen = [design for design in optimum.designs if design.role == "chosen"]
    if chosen:
        word = "largest" if second.sense == "maximise" else "smallest"
        name = f"chosen: {word} {label(second.name).partition(' (')[0].split()[-1].lower()}"
        places = [place(design.surrogate) for design in chosen]
        series.append(_points(f"{name} in a limit", places, "orange", "*"))
    limits = sorted(design.limit for design in chosen if design.limit is not None)
    marks = [
        Mark(
            limit,
            f"{'≤' if first.sign > 0 else '≥'} {limit:g} {first.unit}",
            "x",
            colour="orange",
            beside=True,
        )
        for limit in limits
    ]
    return Chart("Front of the surrogate", axis(first), axis(second), series, marks)


def _points(name: str, places: Sequence[tuple[float, float]], colour: str, marker: str) -> Series:
    """Points at their places."""
    x, y = np.array(places, dtype=float).reshape(-1, 2).T
    return Series(name, x, y, "points", colour=colour, marker=marker)


def scatter(names: Sequence[str], sd: Mapping[int, tuple[Sequence[int], Numbers]]) -> list[Chart]:
    """Make charts of the chosen inputs' scatter over seeds (the paper's Fig. 8).

    Args:
        names: names of the inputs.
        sd: by population the numbers of generations, shape (numbers,), and standard deviations,
            shape (numbers, inputs).

    Returns:
        A chart for each input.
    """
    return [
        Chart(
            f"({'abcdefgh'[column % 8]})",
            Axis("Generations", zero=True),
            Axis(f"Standard deviation of {label(name)}", unit(name), zero=True),
            [
                Series(f"population {population}", generations, spread[:, column], marker=marker)
                for (population, (generations, spread)), marker in zip(
                    sorted(sd.items()), "os^Dvx" * 9, strict=False
                )
            ],
        )
        for column, name in enumerate(names)
    ]


def course(design: DesignFile, steps: Columns) -> list[Chart]:
    """Make the charts of a descent: objective and limits against simulations.

    Args:
        design: content of ``design.json``.
        steps: columns of ``steps.csv``.

    Returns:
        The chart of the objective, and that of the limits if there are any; none if no design was
        solved.
    """
    at, value = required(steps, "simulations"), numbers(steps, "objective")
    if value is None:
        return []
    value = np.array([as_shown(design.quantity, v) for v in value])
    design = design.shown
    taken = np.array([str(entry) == "True" for entry in steps["accepted"]])
    failed = np.isnan(value)
    along = Axis("Load paths simulated", whole=True)
    series = [Series("accepted", at[taken], value[taken], colour="blue", marker="o")]
    rejected = ~taken & ~failed
    if rejected.any():
        name = "not accepted: step shortened"
        points = at[rejected], value[rejected]
        series.append(Series(name, *points, "points", colour="orange", marker="x"))
    marks = [
        Mark(place, "" if i else "solve failed", "x", colour="grey")
        for i, place in enumerate(at[failed])
    ]
    up = Axis(label(design.quantity), unit(design.quantity))
    charts = [Chart("Steps of the design", along, up, series, marks, alt=design.of)]
    names = list(steps)
    keys = names[names.index("objective") + 1 : names.index("radius")] if "radius" in names else ()
    limits = []
    for limit, name in zip(design.constraints, keys, strict=False):
        sign = 1.0 if limit.sense == "at most" else -1.0
        left = sign * (limit.limit - required(steps, name)[taken]) / (abs(limit.limit) or 1.0)
        limits.append(Series(name, at[taken], 100 * left, marker="o"))
    if limits:
        percent = Axis("Left to the limit (% of it)", "%")
        charts.append(Chart("Limits of the design", along, percent, limits, [Mark(0.0)]))
    return charts


def sections(meshes: Mapping[str, FieldMesh]) -> list[Chart]:
    """Make the chart of the sections y = 0 of half fingers at rest.

    Args:
        meshes: of start and design, by their names.

    Returns:
        One chart; none of whole fingers.
    """
    series = []
    for (name, mesh), colour in zip(meshes.items(), ("grey", "blue"), strict=True):
        try:
            skin = extract_skin(mesh, cut=True)
        except ValueError:
            return []
        ends = skin.points[skin.creases]
        apart = np.concatenate([ends, np.full_like(ends[:, :1], np.nan)], axis=1).reshape(-1, 3)
        series.append(Series(name, apart[:, 2], apart[:, 0], colour=colour))
    alt = "Sections of the finger at rest, of the start and of the design."
    return [Chart("Section at rest", *IN_PLANE, series, alt=alt, equal=True)]


def followed(target: CurveTarget, tables: Mapping[str, Columns], note: str = "") -> list[Chart]:
    """Make charts of the back's middle line, or of the tip's way, beside the curve that is wanted.

    Args:
        target: the curve.
        tables: results of start and design, by their names, with the places of markers.
        note: of each chart.

    Returns:
        A chart for each pressure with a curve of its own.
    """
    lines, at_kPa = target.lines, target.pressure_kPa
    pressures = [None] * len(lines) if at_kPa is None or target.of_tip else np.unique(at_kPa)
    charts = []
    for line, pressure in zip(lines, pressures, strict=True):
        title = "Way of the tip"
        series = [Series("wanted", line[:, 1], line[:, 0], "dash", colour="ink")]
        for (name, table), colour in zip(tables.items(), ("grey", "blue"), strict=True):
            p = required(table, PRESSURE.name)
            x, z = (
                np.array([required(table, marker(i, axis).name) for i in range(1, MARKERS + 1)])
                for axis in "xz"
            )
            if target.of_tip:
                series.append(Series(name, z[-1], x[-1], colour=colour, marker="o"))
                continue
            at = p[-1] if pressure is None else pressure
            title = f"Back of the finger at {at:g} kPa"
            back_x, back_z = ([0.0, *(np.interp(at, p, row) for row in axis)] for axis in (x, z))
            series.append(Series(name, back_z, back_x, colour=colour))
        charts.append(Chart(title, *IN_PLANE, series, note=note, equal=True))
    return charts


def gradient_front(front: FrontFile) -> list[Chart]:
    """Make the charts of a front with its uncertainty.

    Args:
        front: the front.

    Returns:
        Charts of the front, of the best designs' places, and of how the front settled.
    """
    limited, improved = front.objectives
    along = axis(limited, limited.sense)
    limit, mean, sd = (
        np.array([getattr(level, name) for level in front.levels])
        for name in ("limit", "mean", "deviation")
    )
    designs = [design.values for design in front.simulated]
    curve = Series("front", limit, mean, low=mean - 2 * sd, high=mean + 2 * sd, colour="blue")
    points = _points("simulated", designs, "ink", "D")
    note = "Band: two standard deviations."
    charts = [Chart("Front", along, axis(improved), [curve, points], note=note)]
    places = {
        key: (np.array([level.inputs[key] for level in front.levels]) - low) / (high - low)
        for key, (low, high) in front.ranges.items()
    }
    moving = sorted(places, key=lambda key: -float(np.ptp(places[key][:, 0])))[:PLACES]
    series = [
        Series(label(key), limit, places[key][:, 0], low=places[key][:, 1], high=places[key][:, 2])
        for key in moving
    ]
    part = Axis("Best design, part of its range", ends=(-0.03, 1.03))
    note = "Bands: central 90 % of each parameter."
    charts.append(Chart("Best designs along the front", along, part, series, note=note))
    unsure = 100 * np.array(front.unsure, dtype=float)
    areas = np.array(front.hypervolumes, dtype=float)
    at = len(designs) - len(areas) + 1.0 + np.arange(len(areas))
    apart = 100 * np.maximum(np.abs(areas[:-1] / areas[-1] - 1), 1e-6) if len(areas) else areas
    settled = [
        Series("largest deviation (% of the front's range)", at, unsure, marker="o"),
        Series("hypervolume, from the last one (%)", at[:-1], apart, marker="s"),
    ]
    count = Axis("Load paths simulated", short="Simulations", whole=True)
    charts.append(
        Chart(
            "How the front settled",
            count,
            Axis("Deviation and change (%)", "%", "deviation (%)", log=True),
            settled,
        )
    )
    return charts
