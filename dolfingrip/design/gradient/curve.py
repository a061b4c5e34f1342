"""Curves that a finger shall follow: of a file, a circle, a cubic, or the tip's way."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Final

import numpy as np

from dolfingrip.channels import CURVE, OBSTACLE, PRESSURE
from dolfingrip.config import KPA, Config, ConfigError, changed
from dolfingrip.design.gradient.descent import Descent, Trial
from dolfingrip.design.gradient.file import Circle, Cubic, Objective
from dolfingrip.design.gradient.problem import Floats, Problem, Scaling
from dolfingrip.design.quantities.quantity import UNITS
from dolfingrip.experiments.ballooning import CHANNEL, thickness_mm
from dolfingrip.files.design import MatchedCurve
from dolfingrip.sections.curve import CurveTarget, Polyline
from dolfingrip.sections.geometry.boxes import TOLERANCE_MM, Box, BoxSolid
from dolfingrip.sections.geometry.geometry import Geometry
from dolfingrip.sections.tables import check_separator, text_of
from dolfingrip.sections.units import UNITS_MM

OPTION: Final = "objective.match"

KEYS: Final = {
    **dict.fromkeys(("match", "match_circle", "match_cubic", "match_path"), CURVE.name),
    "wrap": OBSTACLE[-1].name,
}
"""Keys of an objective that ask for a form, and the reading that is minimised."""

SAMPLES: Final = 40
"""Points on each piece of a path that is not straight."""

MOST_POINTS: Final = 1000
"""Largest number of points that are kept; of more, so many at equal distances are."""

MOST_ROWS: Final = 100
"""Largest number of rows of a tip's way."""

SHORTEST, LONGEST, NEAR = 1 / 3, 3.0, 0.1
"""Lengths of a curve, and the distance of its beginning from the clamp, by the finger's length."""


def given(objective: Objective, folder: Path, base: Config) -> tuple[Config, Objective]:
    """Return a configuration with the curve that an objective asks for, and the objective.

    Args:
        objective: the table of a design file; without a curve both stay as they are.
        folder: that its files are relative to.
        base: configuration of the finger.

    Returns:
        The configuration, and the objective, which is at the pressures of a tip's way.

    Raises:
        ConfigError: one line, where there is no curve that a finger can be compared with.
    """
    length_mm = base.geometry.length_mm
    if objective.wrap is not None:
        kind = {"kind": objective.wrap}
        if objective.wrap.lower().endswith(".stl"):
            kind = {"kind": "file", "file": str((folder / objective.wrap).resolve())}
        return base.changed(obstacle=kind), objective
    curves: list[tuple[str, Floats]] = []
    for file in objective.match or ():
        curves.append((f"{OPTION} = {file.name}", _of_file(folder / file)))
    for circle in objective.match_circle or ():
        curves.append((f"{OPTION}_circle", _circle(circle, length_mm)))
    for cubic in objective.match_cubic or ():
        curves.append((f"{OPTION}_cubic", _cubic(cubic)))
    if curves:
        lines = [_comparable(said, points, length_mm) for said, points in curves]
        return base.changed(curve=_at_pressures(lines, objective)), objective
    if objective.match_path is not None:
        said = f"{OPTION}_path = {objective.match_path.name}"
        rows = _csv(folder / objective.match_path, said, ("pressure_kPa", "x_mm", "z_mm"))
        pressures, x, z = (tuple(map(float, series)) for series in _way(said, rows, length_mm).T)
        for key in (f"at_{column}" for column in UNITS.values()):
            if (value := getattr(objective, key)) is not None:
                words = "allowed: without match_path, whose pressures count"
                raise ConfigError(f"objective.{key} = {value}: {words}")
        objective = objective.model_copy(update={"at_pressure_kPa": pressures})
        return base.changed(curve={"x_mm": x, "z_mm": z, "pressure_kPa": pressures}), objective
    return base, objective


def _at_pressures(lines: Sequence[Floats], objective: Objective) -> dict[str, Any]:
    """The table of a curve at all pressures, or of one for each.

    Raises:
        ConfigError: one line, where there are not as many pressures as curves.
    """
    pressures = objective.at_pressure_kPa
    at = pressures if isinstance(pressures, tuple) else ()
    if len(lines) > 1 and len(set(at)) != len(lines):
        given = "none" if pressures is None else pressures
        words = f"allowed: {len(lines)} that differ, one for each curve"
        raise ConfigError(f"objective.at_pressure_kPa = {given}: {words}")
    order = np.argsort(at) if len(lines) > 1 else [0]
    x, z = (tuple(map(float, series)) for series in np.concatenate([lines[i] for i in order]).T)
    table = {"x_mm": x, "z_mm": z, "ends": objective.ends}
    if len(lines) > 1:
        table["pressure_kPa"] = tuple(at[i] for i in order for _ in lines[i])
    return table


def _comparable(said: str, points: Floats, length_mm: float) -> Floats:
    """Points (n, 2) of a curve that a finger of a length can be compared with.

    Raises:
        ConfigError: one line, where there is none.
    """
    _finite(said, points)
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    apart = np.concatenate([[True], steps > TOLERANCE_MM])[: len(points)]
    points = points[apart]
    _several(said, len(points), "points")
    line = Polyline(points)
    _in_mm(said, line.length_mm, "long", length_mm)
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
    return line.points


def _way(said: str, rows: Floats, length_mm: float) -> Floats:
    """Rows of pressure, x and z of a tip's way that a finger of a length may have.

    Raises:
        ConfigError: one line, where there is none.
    """
    _finite(said, rows)
    _several(said, len(rows), "rows")
    if len(rows) > MOST_ROWS:
        raise ConfigError(f"{said}: {len(rows)} rows; allowed: {MOST_ROWS}, as each takes a solve")
    if not (np.diff(rows[:, 0]) > 0).all():
        raise ConfigError(f"{said}: pressure_kPa does not rise from row to row; allowed: rising")
    _in_mm(said, float(np.hypot(*rows[:, 1:].T).max()), "from the clamp at most", length_mm)
    return rows


def _finite(said: str, numbers: Floats) -> None:
    if not np.isfinite(numbers).all():
        raise ConfigError(f"{said}: a number that is not finite; allowed: millimetres")


def _several(said: str, count: int, what: str) -> None:
    if count < 2:
        name = what if count != 1 else what[:-1]
        raise ConfigError(f"{said}: {count} {name}; allowed: two or more that differ")


def _in_mm(said: str, size_mm: float, what: str, length_mm: float) -> None:
    low, high = SHORTEST * length_mm, LONGEST * length_mm
    if not low <= size_mm <= high:
        raise ConfigError(
            f"{said}: {size_mm:.4g} {what}; allowed: {low:.4g} to {high:.4g} mm for a finger of "
            f"{length_mm:g} mm; is it in mm?"
        )


def _circle(circle: Circle, length_mm: float) -> Floats:
    """Points of a straight piece and a part of a circle."""
    left = max(length_mm - circle.straight_mm, 0.0) / circle.radius_mm
    angle = left if circle.angle_deg is None else math.radians(circle.angle_deg)
    side, turns = math.copysign(circle.radius_mm, angle), np.linspace(0.0, angle, 2 * SAMPLES)
    arc = np.stack([side * (np.cos(turns) - 1), circle.straight_mm + side * np.sin(turns)], axis=1)
    return np.concatenate([[[0.0, 0.0]], arc])


def _cubic(cubic: Cubic) -> Floats:
    """Points of a Bézier curve."""
    share = np.linspace(0.0, 1.0, 2 * SAMPLES)[:, None]
    powers = np.arange(4)
    weights = np.array([1, 3, 3, 1]) * share**powers * (1 - share) ** powers[::-1]
    return np.asarray(weights @ np.array([cubic.x_mm, cubic.z_mm]).T)


def _of_file(file: Path) -> Floats:
    """Points (n, 2) of the curve in a file.

    Args:
        file: ``.csv`` with the columns x_mm and z_mm, ``.svg`` or ``.dxf`` with one path, whose
            second coordinate is z; SVG counts it downwards.
    """
    kind = file.suffix.lower()
    if kind not in READERS:
        raise ConfigError(f"{OPTION} = {file.name}: allowed: a file {', '.join(READERS)}")
    return READERS[kind](file)


def _csv(file: Path, said: str = "", columns: Sequence[str] = ("x_mm", "z_mm")) -> Floats:
    said = said or f"{OPTION} = {file.name}"
    text = text_of(file, said.partition(" ")[0]).splitlines()
    check_separator(said, text[0] if text else "")
    rows = csv.DictReader(text)
    names = [name.strip() for name in rows.fieldnames or ()]
    if not set(columns) <= set(names):
        allowed = ", ".join(columns)
        raise ConfigError(f"{said}: columns {', '.join(names) or 'none'}; allowed: {allowed}")
    rows.fieldnames = names
    numbers = []
    for number, row in enumerate(rows, 2):
        try:
            numbers.append([float(row[name]) for name in columns])
        except (TypeError, ValueError):
            count = {2: "two", 3: "three"}[len(columns)]
            words = f"allowed: {count} numbers, {' and '.join(columns)}"
            raise ConfigError(f"{said}: line {number}: {words}") from None
    return np.array(numbers, dtype=float).reshape(-1, len(columns))


def _svg(file: Path) -> Floats:
    text_of(file, OPTION)
    from svgpathtools import Document, Line

    said = f"{OPTION} = {file.name}"
    try:
        drawing = Document(str(file))
        paths = drawing.paths()  # with the transforms of groups
    except Exception as error:  # of the parsers of XML and of paths
        raise ConfigError(f"{said}: not an SVG that can be read: {error}") from None
    _one(said, len(paths))
    sheet = drawing.root.attrib
    width = sheet.get("width", "mm").strip()
    unit = width.lstrip("0123456789.+-eE ")
    if unit not in UNITS_MM:
        raise ConfigError(f"{said}: width = {width}: allowed: in {', '.join(UNITS_MM)}")
    scale = UNITS_MM[unit]
    box = sheet.get("viewBox", "").replace(",", " ").split()
    if len(box) == 4 and width != "mm":
        scale *= float(width.removesuffix(unit)) / float(box[2])
    places = []
    for piece in paths[0]:
        count = 2 if isinstance(piece, Line) else SAMPLES
        places += [piece.point(share) for share in np.linspace(0, 1, count)]
    return scale * np.array([[place.real, place.imag] for place in places]).reshape(-1, 2)


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
    paths = []
    for entity in drawing.modelspace():
        try:
            paths.append(path.make_path(entity))
        except TypeError:  # a text, a dimension
            continue
    _one(said, len(paths))
    unit = units.InsertUnits(drawing.units)
    scale = units.conversion_factor(unit, units.InsertUnits.Millimeters) if unit else 1.0
    flat = paths[0].flattening(0.01 / scale)
    return scale * np.array([[point.x, point.y] for point in flat]).reshape(-1, 2)


def _one(said: str, count: int) -> None:
    if count != 1:
        raise ConfigError(f"{said}: {count} paths; allowed: one")


READERS: Final[dict[str, Callable[[Path], Floats]]] = {".csv": _csv, ".svg": _svg, ".dxf": _dxf}


def backwards(problem: Problem) -> str:
    """Say what of a problem's curve bends backwards, towards +x, as no bellows does; "" if nothing.

    The nearest curve that only bends forwards has the least root mean square distance, as the
    objective counts it.

    Args:
        problem: whose objective may be a curve.
    """
    curve = problem.nominal.base.curve
    if curve is None or curve.of_tip:
        return ""
    length_mm = problem.nominal.base.geometry.length_mm
    remarks = (_backwards(Polyline(points), curve, length_mm) for points in curve.lines)
    return "; ".join(filter(None, remarks))


def _backwards(line: Polyline, curve: CurveTarget, length_mm: float) -> str:
    """Say of one curve what :func:`backwards` says of all."""
    direction, _, made = _forwards(line)
    off = made - line.at(SHARES)
    if math.sqrt((off**2).sum(axis=1).mean()) < NOTHING * line.length_mm:
        return ""
    near_mm = _nearest_mm(line, curve, length_mm, np.full(PIECES, np.inf))
    back = np.maximum.accumulate(np.maximum(direction, 0.0)) - direction
    first = line.length_mm * float((back > back.max() / 10).argmax()) / len(back)
    return (
        f"{OPTION}: turns backwards by {np.degrees(back.max()):.0f}° beyond {first:.0f} mm of it; "
        "what stops it: pressure bends chambers towards their base alone, so 0° at least; one that "
        f"bends forwards alone comes as near as about {near_mm:.2g} mm (root mean square)"
    )


def _forwards(line: Polyline) -> tuple[Floats, Floats, Floats]:
    """Directions (200,) of a line, the nearest that never fall, and the line (201, 2) of these."""
    from scipy.optimize import isotonic_regression

    steps = np.diff(line.at(SHARES), axis=0)
    direction = np.unwrap(np.arctan2(-steps[:, 0], steps[:, 1]))
    forwards = np.maximum(isotonic_regression(direction).x, 0.0)
    return direction, forwards, line.points[0] + _line(forwards, np.linalg.norm(steps, axis=1))


def _line(directions: Floats, lengths_mm: Floats) -> Floats:
    """Points (n + 1, 2) of n steps from the origin on."""
    steps = lengths_mm[:, None] * np.stack([-np.sin(directions), np.cos(directions)], axis=1)
    return np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])


def _nearest_mm(line: Polyline, curve: CurveTarget, length_mm: float, most: Floats) -> float:
    """The least root mean square distance (mm) of a back that bends forwards from a curve.

    Args:
        line: the curve, or one place for the tip.
        curve: that tells which distances count.
        length_mm: of the back at rest.
        most: largest turns (rad) of its pieces, (PIECES,).
    """
    from scipy.optimize import least_squares

    shares = np.linspace(0, 1, curve.places + 1)

    def distances(turns: Floats) -> Floats:
        """From the curve, of a back's places that turns by the first numbers, and stretches."""
        lengths = np.full(PIECES, length_mm * turns[-1] / PIECES)
        back = Polyline(_line(np.cumsum(turns[:-1]), lengths)).at(shares)
        if curve.of_tip:
            return back[-1] - line.points[0]
        there = line.at(shares) if curve.ends == "fixed" else line.nearest(back)[0]
        return (back - there).ravel()

    starts: list[Floats] = [np.zeros(PIECES)]
    if not curve.of_tip:
        every = len(SHARES) // PIECES
        starts.append(np.diff(_forwards(line)[1][::every], prepend=0.0))
    low, high = np.append(np.zeros(PIECES), 1.0), np.append(most, STRETCHED) + 2 * TINY
    inside = [np.clip(np.append(start, 1.0), low + TINY, high - TINY) for start in starts]
    limits = {"bounds": (low, high), "ftol": ENOUGH, "xtol": ENOUGH}
    costs = [least_squares(distances, start, **limits).cost for start in inside]
    return math.sqrt(2 * min(costs) / (1 if curve.of_tip else len(shares)))


def forecast(problem: Problem) -> str:
    """Say how near a finger of a problem's kind can come to its curve; "" without one.

    The back is a line that bends forwards alone, and turns by what pressure can turn the chambers
    at their softest within the parameters' ranges.

    Args:
        problem: whose objective may be a curve.
    """
    base, objective = problem.nominal.base, problem.objective
    curve, length_mm = base.curve, base.geometry.length_mm
    if curve is None:
        return ""
    pressures = objective.values if objective.where == PRESSURE.name else ()
    softest, within = most_turned(problem), []
    for pressure_kPa in pressures or (base.experiment.max_pressure_kPa,):
        line, most = curve.targets()(pressure_kPa), softest * pressure_kPa
        limits = np.full(PIECES, np.inf), most
        within.append([_nearest_mm(line, curve, length_mm, limit) for limit in limits])
    apart, near = np.sqrt((np.array(within) ** 2).mean(axis=0))
    turned = (
        f"it turns by about {np.degrees(most.sum()):.0f}° at {pressure_kPa:g} kPa (an estimate)"
    )
    shares = {"it bends to one side alone": apart, turned: near - apart}
    why = [said for said, off in shares.items() if off > near / 3 > NOTHING * length_mm / 3]
    said = f"a finger of this kind can follow this curve to about {near:.2g} mm rms at best"
    return ": ".join(filter(None, (said, " and ".join(why))))


def most_turned(problem: Problem) -> Floats:
    """Estimate by how much pieces of the back turn for each kPa at most, (PIECES,) rad.

    A chamber h high and w wide, with walls t and a floor b, turns by C p/μ (h/b)^0.8 (w/t)^1.3.
    Fitted to nine bellows fingers of two chambers, walls of 1.2 to 2.2 mm, depths of 12 to 22 mm,
    floors of 2.5 to 5 mm and widths of 14 and 20 mm at 100 kPa (mesh of 8 mm): within 20 %.

    Args:
        problem: each of whose parameters takes the end of its range at which the finger turns more.

    Returns:
        The turns; infinite where the finger is not made of boxes.
    """
    config = problem.nominal.base
    for variable in problem.variables:
        for end in (variable.low, variable.high):
            with suppress(ConfigError):  # ends of all ranges need not go together
                other = changed(config, {variable.key: end})
                config = max(config, other, key=lambda one: _turned(one).sum())
    turned = _turned(config)
    return turned if turned.any() else np.full(PIECES, np.inf)


def _turned(config: Config) -> Floats:
    """Turns (rad/kPa) of the pieces of one finger's back; zeros where nothing is known."""
    ends, turned = np.linspace(0, config.geometry.length_mm, PIECES + 1), np.zeros(PIECES)
    for i in range(0 if config.mesh.file else len(_chambers(config.geometry))):
        box, wall = _chambers(config.geometry.of(i))[i]
        (height, width, length), floor = np.ptp(box, axis=1), box[0][0]
        slender = (height / floor) ** 0.8 * (width / wall) ** 1.3
        share = np.diff(np.clip((ends - box[2][0]) / length, 0, 1))
        turned += share * TURN * slender * KPA / config.material.shear_MPa
    return turned


def _chambers(geometry: Geometry) -> list[tuple[Box, float]]:
    """Chambers along a finger of boxes, and the wall (mm) of each towards the tip.

    What reaches from one to another is a channel, and none of them.
    """
    solid = geometry.solid()
    if not isinstance(solid, BoxSolid):
        return []
    along = [hollow[2] for hollow in solid.cavity]
    return [
        (box, thickness_mm(box, 2, 1, solid))
        for box in solid.cavity
        if np.ptp(box[2]) <= CHANNEL * max(np.ptp(box[:2], axis=1))
        and not any(box[2][0] <= low < high <= box[2][1] for low, high in {*along} - {box[2]})
    ]


TURN: Final = 0.067
"""Turn (rad) of a chamber by (h/b)^0.8 (w/t)^1.3 p/μ; see :func:`most_turned`."""

SHARES: Final = np.linspace(0, 1, 201)
"""Parts of a curve's length at which its direction is taken."""

PIECES, STRETCHED = 40, 1.2
"""Pieces of a back, and its length under pressure by that at rest, at most, where the nearest curve
that bends forwards is sought."""

ENOUGH: Final = 1e-3
"""Relative change of the squares, or of the turns, at which the search for it ends."""

TINY: Final = 1e-6
"""Width of a range that is none, as a search asks for one."""

NOTHING: Final = 0.005
"""Distance by the length of a curve that bending backwards may cost and is not told."""

TIED_MM: Final = 0.1
"""Root mean square distance below which a change of the line does not count."""

SMALL_PART: Final = 0.05
"""Part of a range by which a parameter changes and is not told, for a whole range of another."""

AT_BOUND: Final = 1e-6
"""Part of its range within which a parameter is at its bound."""


def matched(problem: Problem, descent: Descent) -> MatchedCurve | None:
    """Say how near a design comes to its curve, and which bounds stop it; None without a curve.

    Args:
        problem: that was solved.
        descent: how.
    """
    if not problem.parts:
        return None
    best = descent.best
    rms_mm = math.sqrt(best.objective)
    slopes = best.signed_slopes[int(best.signed.argmax())] / Scaling(problem.variables).size
    stops = {}
    for variable, at, slope in zip(problem.variables, best.scaled, slopes, strict=True):
        outwards = at < AT_BOUND if slope > 0 else at > 1 - AT_BOUND
        if outwards and rms_mm:
            stops[variable.key] = abs(float(slope)) / (2 * rms_mm)
    ranked = dict(sorted(stops.items(), key=lambda pair: -pair[1]))
    return MatchedCurve(
        rms_mm=rms_mm,
        start_rms_mm=math.sqrt(descent.start.objective),
        stops_mm_per_unit=ranked,
        tied=_tied(problem, best),
    )


def weak(trial: Trial) -> Floats:
    """Directions (variables, k) of scaled variables that hardly move the line from its curve.

    These are the singular directions of the parts' derivatives along which a step as long as a
    range changes the root mean square distance by less than :data:`TIED_MM`.

    Args:
        trial: whose distances have parts.
    """
    assert trial.of_parts is not None
    squares, directions = np.linalg.eigh(trial.of_parts / 2)
    return np.asarray(directions[:, squares < TIED_MM**2])


def _tied(problem: Problem, trial: Trial) -> dict[str, dict[str, float]]:
    """Parameters of which each may be chosen, with the changes of others that make up for it."""
    from scipy.linalg import qr

    basis, sizes = weak(trial), Scaling(problem.variables).size
    keys = [variable.key for variable in problem.variables]
    free = qr(basis.T, mode="r", pivoting=True)[1][: basis.shape[1]]
    ties = {}
    for one, row in sorted(zip(free, np.linalg.solve(basis[free].T, basis.T), strict=True)):
        with_it = [i for i in np.flatnonzero(np.abs(row) > SMALL_PART) if i != one]
        ties[keys[one]] = {keys[i]: float(row[i] * sizes[i] / sizes[one]) for i in with_it}
    return ties
