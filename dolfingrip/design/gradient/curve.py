"""A file with a curve that a finger's back shall follow: CSV, or one path of an SVG or a DXF."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from dolfingrip.config import Config, ConfigError
from dolfingrip.design.gradient.problem import Floats, Problem, Scaling
from dolfingrip.design.gradient.trial import Descent
from dolfingrip.files.design import MatchedCurve
from dolfingrip.sections.curve import Polyline
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM
from dolfingrip.sections.tables import check_separator, text_of

OPTION: Final = "objective.match"

TO_MM: Final = {"mm": 1.0, "cm": 10.0, "in": 25.4, "pt": 25.4 / 72}
"""Units of an SVG's width."""

SAMPLES: Final = 40
"""Points on each piece of a path that is not straight."""

MOST_POINTS: Final = 1000
"""Largest number of points that are kept; of more, so many at equal distances are."""

SHORTEST, LONGEST, NEAR = 1 / 3, 3.0, 0.1
"""Lengths of a curve, and the distance of its beginning from the clamp, by the finger's length."""


def load(file: Path, base: Config, ends: str) -> Config:
    """A configuration with the curve of a file.

    Args:
        file: ``.csv`` with the columns x_mm and z_mm, ``.svg`` or ``.dxf`` with one path, whose
            second coordinate is z; SVG counts it downwards.
        base: of the finger.
        ends: ``free`` or ``fixed``.

    Raises:
        ConfigError: one line, where it is no curve that a finger can be compared with.
    """
    kind = file.suffix.lower()
    if kind not in READERS:
        raise ConfigError(f"{OPTION} = {file.name}: allowed: a file {', '.join(READERS)}")
    points = READERS[kind](file)
    said = f"{OPTION} = {file.name}"
    if not np.isfinite(points).all():
        raise ConfigError(f"{said}: a number that is not finite; allowed: millimetres")
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    apart = np.concatenate([[True], steps > TOLERANCE_MM])[: len(points)]
    points = points[apart]
    if len(points) < 2:
        count = f"{len(points)} point{'s' * (len(points) != 1)}"
        raise ConfigError(f"{said}: {count}; allowed: two or more that differ")
    line, length_mm = Polyline(points), base.geometry.length_mm
    low, high = SHORTEST * length_mm, LONGEST * length_mm
    if not low <= line.length_mm <= high:
        raise ConfigError(
            f"{said}: {line.length_mm:.4g} long; allowed: {low:.4g} to {high:.4g} mm for a finger "
            f"of {length_mm:g} mm; is it in mm?"
        )
    starts = np.hypot(*points[[0, -1]].T)
    if starts[0] > NEAR * length_mm:
        other = "; its other end does" if starts[1] <= NEAR * length_mm else ""
        raise ConfigError(
            f"{said}: begins at x = {points[0, 0]:.4g}, z = {points[0, 1]:.4g} mm; allowed: within "
            f"{NEAR * length_mm:.3g} mm of the clamp's, x = z = 0{other}"
        )
    if len(points) > MOST_POINTS:
        line = Polyline(line.at(np.linspace(0, 1, MOST_POINTS)))
    if (at := line.crossing()) is not None:
        raise ConfigError(
            f"{said}: crosses itself at x = {at[0]:.4g}, z = {at[1]:.4g} mm; allowed: a curve that "
            "does not"
        )
    x, z = line.points.T.tolist()
    return base.changed(curve={"x_mm": x, "z_mm": z, "ends": ends})


def _csv(file: Path) -> Floats:
    text = text_of(file, OPTION).splitlines()
    said = f"{OPTION} = {file.name}"
    check_separator(said, text[0] if text else "")
    rows = csv.DictReader(text)
    names = [name.strip() for name in rows.fieldnames or ()]
    if not {"x_mm", "z_mm"} <= set(names):
        raise ConfigError(f"{said}: columns {', '.join(names) or 'none'}; allowed: x_mm, z_mm")
    rows.fieldnames = names
    found = []
    for number, row in enumerate(rows, 2):
        try:
            found.append([float(row["x_mm"]), float(row["z_mm"])])
        except (TypeError, ValueError):
            raise ConfigError(f"{said}: line {number}: allowed: two numbers in mm") from None
    return np.array(found, dtype=float).reshape(-1, 2)


def _svg(file: Path) -> Floats:
    text_of(file, OPTION)
    from svgpathtools import Line, svg2paths2

    said = f"{OPTION} = {file.name}"
    try:
        paths, _, sheet = svg2paths2(str(file))
    except Exception as error:  # of the parsers of XML and of paths
        raise ConfigError(f"{said}: not an SVG that can be read: {error}") from None
    _one(said, len(paths))
    width = sheet.get("width", "mm").strip()
    unit = width.lstrip("0123456789.+-eE ")
    if unit not in TO_MM:
        raise ConfigError(f"{said}: width = {width}: allowed: in {', '.join(TO_MM)}")
    scale = TO_MM[unit]
    box = sheet.get("viewBox", "").replace(",", " ").split()
    if len(box) == 4 and width != "mm":
        scale *= float(width.removesuffix(unit)) / float(box[2])
    places = []
    for piece in paths[0]:
        count = 2 if isinstance(piece, Line) else SAMPLES
        places += [piece.point(share) for share in np.linspace(0, 1, count)]
    return scale * np.array([[each.real, each.imag] for each in places]).reshape(-1, 2)


def _dxf(file: Path) -> Floats:
    import ezdxf
    from ezdxf import path, units

    said = f"{OPTION} = {file.name}"
    try:
        drawing = ezdxf.readfile(file)
    except OSError as error:
        raise ConfigError(f"{said}: {error.strerror or 'not a DXF'}") from None
    except ezdxf.DXFError as error:
        raise ConfigError(f"{said}: not a DXF that can be read: {error}") from None
    found = []
    for entity in drawing.modelspace():
        try:
            found.append(path.make_path(entity))
        except TypeError:  # a text, a dimension
            continue
    _one(said, len(found))
    unit = units.InsertUnits(drawing.units)
    scale = units.conversion_factor(unit, units.InsertUnits.Millimeters) if unit else 1.0
    flat = found[0].flattening(0.01 / scale)
    return scale * np.array([[each.x, each.y] for each in flat]).reshape(-1, 2)


def _one(said: str, count: int) -> None:
    if count != 1:
        raise ConfigError(f"{said}: {count} paths; allowed: one")


READERS: Final[dict[str, Callable[[Path], Floats]]] = {".csv": _csv, ".svg": _svg, ".dxf": _dxf}


def backwards(problem: Problem) -> str:
    """Say what of a problem's curve bends backwards, towards +x, as no bellows does; "" if nothing.

    The nearest curve that only bends forwards is that whose direction is the nearest monotone one.

    Args:
        problem: whose objective may be a curve.
    """
    if problem.nominal.base.curve is None:
        return ""
    from scipy.optimize import isotonic_regression

    curve = problem.nominal.base.curve
    line = Polyline(np.stack([curve.x_mm, curve.z_mm], axis=1))
    points = line.at(np.linspace(0, 1, 201))
    steps = np.diff(points, axis=0)
    direction = np.unwrap(np.arctan2(-steps[:, 0], steps[:, 1]))
    forwards = np.maximum(isotonic_regression(direction).x, 0.0)
    lengths = np.linalg.norm(steps, axis=1)[:, None]
    made = lengths * np.stack([-np.sin(forwards), np.cos(forwards)], axis=1)
    nearest = points[0] + np.concatenate([np.zeros((1, 2)), np.cumsum(made, axis=0)])
    off = float(np.sqrt(((nearest - points) ** 2).sum(axis=1).mean()))
    if off < NOTHING * line.length_mm:
        return ""
    back = np.maximum.accumulate(np.maximum(direction, 0.0)) - direction
    first = line.length_mm * float((back > back.max() / 10).argmax()) / len(back)
    return (
        f"{OPTION}: turns backwards by {np.degrees(back.max()):.0f}° beyond {first:.0f} mm of it; "
        "what stops it: pressure bends chambers towards their base alone, so 0° at least; one that "
        f"bends forwards alone comes as near as about {off:.2g} mm rms"
    )


NOTHING: Final = 0.005
"""Distance by the length of a curve that bending backwards may cost and is not told."""

AT_BOUND: Final = 1e-6
"""Part of its range within which a parameter is at its bound."""


def matched(problem: Problem, found: Descent) -> MatchedCurve | None:
    """Say how near a design comes to its curve, and which bounds stop it; None without a curve.

    Args:
        problem: that was solved.
        found: how.
    """
    if not problem.parts:
        return None
    best = found.best
    rms_mm = math.sqrt(best.objective)
    slopes = best.signed_slopes[int(best.signed.argmax())] / Scaling(problem.variables).size
    stops = {}
    for variable, at, slope in zip(problem.variables, best.scaled, slopes, strict=True):
        outwards = at < AT_BOUND if slope > 0 else at > 1 - AT_BOUND
        if outwards and rms_mm:
            stops[variable.key] = abs(float(slope)) / (2 * rms_mm)
    ranked = dict(sorted(stops.items(), key=lambda each: -each[1]))
    return MatchedCurve(
        rms_mm=rms_mm,
        start_rms_mm=math.sqrt(found.start.objective),
        stops_mm_per_unit=ranked,
    )
