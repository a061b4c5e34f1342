"""Readings of a protocol at any strength and with any nuisances, from the library.

A reading is that of the base curve at the pressure that is really there, divided by the modulus
(:mod:`dolfingrip.diagnosis.simulation.modulus`), and the changes that causes and nuisances make
there, quadratic in their strength. What two causes do to one another beyond that is in the cases
with a simulation of their own (:mod:`full`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pandas as pd
from scipy.interpolate import CubicSpline, PchipInterpolator

from benchmarks.blind.generator import BY_SLOPE, DRIFT, STAGES, Cause, generating
from benchmarks.blind.library import Change, Curve, Library
from benchmarks.blind.outsiders import OUTSIDERS
from benchmarks.blind.protocols import Course, Protocol
from dolfingrip.config import Config
from dolfingrip.diagnosis.data.columns import READING_COLUMNS
from dolfingrip.extensions.effect import Effect, Flow

MODULUS_SPREAD: Final = 0.2
WALL_SPREAD: Final = 0.05
GAIN_SPREAD: Final = 0.015
OFFSET_SPREAD_kPa: Final = 2.0
GAP_SPREAD_mm: Final = 0.3
FROM_REST: Final = tuple(name for name in READING_COLUMNS if name != "force_N")
"""Columns that are measured from the pose at rest, the first row's: a regulator whose zero is off
does not show in them there."""
NUISANCES: Final = ("modulus", "wall", "pressure_gain", "pressure_offset", "plate_gap")


@dataclass(frozen=True, slots=True)
class Hidden:
    """A cause that is there.

    Attributes:
        name: of a cause of the catalogue, or of an outsider.
        form: of the cause.
        strength: by the ordinary one.
    """

    name: str
    form: int
    strength: float


@dataclass(frozen=True, slots=True)
class Truth:
    """What is hidden in a case.

    Attributes:
        causes: one, two or none.
        nuisances: standard deviations from what the laboratory believes, by name.
    """

    causes: tuple[Hidden, ...] = ()
    nuisances: Mapping[str, float] = field(default_factory=dict)

    def sigma(self, name: str) -> float:
        """Of a nuisance."""
        return self.nuisances.get(name, 0.0)

    @property
    def modulus(self) -> float:
        """Factor of all moduli."""
        return float(np.exp(MODULUS_SPREAD * self.sigma("modulus")))

    @property
    def gain(self) -> float:
        """Of the regulator."""
        return 1 + GAIN_SPREAD * self.sigma("pressure_gain")

    @property
    def offset_kPa(self) -> float:
        """Of the regulator."""
        return OFFSET_SPREAD_kPa * self.sigma("pressure_offset")


@dataclass(frozen=True, slots=True)
class Catalogue:
    """What readings are made of.

    Attributes:
        protocol: that is followed.
        library: of the generator.
        causes: of the catalogue, by name.
    """

    protocol: Protocol
    library: Library
    causes: Mapping[str, Cause]

    @property
    def config(self) -> Config:
        """The generator's, as the laboratory set the finger up."""
        return generating(self.protocol)

    def readings(self, truth: Truth) -> list[pd.DataFrame]:
        """True readings of each course, without noise: its rows with the columns that are read."""
        return [_read(self, course, truth) for course in self.protocol.courses]

    def vector(self, truth: Truth) -> np.ndarray:
        """(n,) the same in the order of ``Measurement.listed()``."""
        return flat(self.protocol, self.readings(truth))

    def has(self, name: str) -> bool:
        """Whether a cause or outsider can be hidden: its simulations are there."""
        if name in OUTSIDERS:
            return OUTSIDERS[name].overrides is None or self.library.knows(name)
        return not self.causes[name].simulated or self.library.knows(name)


def flat(protocol: Protocol, tables: Sequence[pd.DataFrame]) -> np.ndarray:
    """Readings in the order of ``Measurement.listed()``: row by row, then column by column."""
    parts = []
    for course, table in zip(protocol.courses, tables, strict=True):
        names = [c for c in READING_COLUMNS if c in protocol.columns[course.experiment]]
        parts.append(table[names].to_numpy(dtype=float).ravel())
    return np.concatenate(parts)


def _read(catalogue: Catalogue, course: Course, truth: Truth) -> pd.DataFrame:
    rows = course.rows
    base = catalogue.library.base[course.experiment]
    factor = _modulus(catalogue, course, truth)
    at = _pressure(catalogue, course, truth) / factor
    if course.control == "displacement_mm":
        at = rows[course.control].to_numpy(dtype=float)
    names = [name for name in base.columns if name in READING_COLUMNS]
    found = {}
    for name in names:
        value = CubicSpline(base.at, base.columns[name])(at)
        value += _by_walls(catalogue, course, name, at, truth)
        value += _by_dimensions(base, name, at, truth, catalogue.causes)
        value += _by_plate(catalogue, base, name, at, truth)
        for hidden in truth.causes:
            change = catalogue.library.changes.get((hidden.name, hidden.form, course.experiment))
            if change is not None:
                value += _changed(change, name, hidden.strength, at, rows)
        if name in FROM_REST:
            value -= value[0]
        if name == "force_N" and course.experiment == "blocked_force":
            # the plate is set away from the tip at rest, and does not pull
            value = np.where(np.isclose(at, at[0]), 0.0, np.maximum(value, 0.0))
        found[name] = value * factor if name == "force_N" else value
    shown = displayed(catalogue.causes, course, found, truth)
    read = catalogue.protocol.columns[course.experiment]
    return rows.assign(**{name: shown[name] for name in read})


def effects_on(causes: Mapping[str, Cause], truth: Truth) -> list[Effect]:
    """The hidden effects of the catalogue, at their strengths."""
    found = []
    for hidden in truth.causes:
        if hidden.name in causes:
            cause = causes[hidden.name]
            found.append(cause.effect(**cause.values(hidden.form, hidden.strength)))
    return found


def outsider_pressure(course: Course, truth: Truth) -> np.ndarray:
    """Pressure (kPa) at the gauge's place where it displays that of the rows."""
    pressure = course.rows["pressure_kPa"].to_numpy(dtype=float)
    for hidden in truth.causes:
        outsider = OUTSIDERS.get(hidden.name)
        if outsider is not None and outsider.pressure is not None:
            pressure = outsider.pressure(course.rows, hidden.strength)
    return pressure


def _pressure(catalogue: Catalogue, course: Course, truth: Truth) -> np.ndarray:
    """(rows,) pressure in the cavity."""
    if course.control == "displacement_mm":
        return np.zeros(len(course.rows))
    pressure = outsider_pressure(course, truth)
    pressure = truth.gain * pressure + truth.offset_kPa
    time_s = course.rows["time_s"].to_numpy(dtype=float)
    stages = [each for each in effects_on(catalogue.causes, truth) if each.name() in STAGES]
    for stage in sorted(stages, key=lambda each: each.place):
        pressure = _behind(stage, pressure, time_s)
    return pressure


def _behind(stage: Any, inlet: np.ndarray, time_s: np.ndarray) -> np.ndarray:
    """Pressure behind a stage of the supply, ramps between the rows."""
    out = np.empty_like(inlet)
    before_in, before_out, before_s = inlet[0], inlet[0], time_s[0]
    for i, (value, moment) in enumerate(zip(inlet, time_s, strict=True)):
        flow = Flow(before_in, value, before_out, moment, moment - before_s)
        out[i] = stage.outlet_kPa(flow)
        before_in, before_out, before_s = value, out[i], moment
    return out


def _modulus(catalogue: Catalogue, course: Course, truth: Truth) -> np.ndarray:
    """(rows,) factor of all moduli."""
    factor = np.full(len(course.rows), truth.modulus)
    time_s = course.rows["time_s"].to_numpy(dtype=float)
    for effect in effects_on(catalogue.causes, truth):
        if effect.name() == DRIFT:
            values = effect.model_dump()
            warming = values["warming_degC"] * (1 - np.exp(-time_s / values["tau_s"]))
            factor = factor * (1 + values["modulus_per_degC"] * warming)
    return factor * outsider_modulus(course, truth)


def outsider_modulus(course: Course, truth: Truth) -> np.ndarray:
    """(rows,) factor of all moduli by a cause outside the catalogue."""
    factor = np.ones(len(course.rows))
    for hidden in truth.causes:
        outsider = OUTSIDERS.get(hidden.name)
        if outsider is not None and outsider.modulus is not None:
            factor = factor * outsider.modulus(course.rows, hidden.strength)
    return factor


def _by_walls(
    catalogue: Catalogue, course: Course, name: str, at: np.ndarray, truth: Truth
) -> np.ndarray:
    """(rows,) change by walls, between those that were simulated; beyond them a straight line."""
    part = WALL_SPREAD * truth.sigma("wall")
    walls = catalogue.library.walls.get(course.experiment)
    if not walls or not part:
        return np.zeros(len(at))
    curves = {0.0: catalogue.library.base[course.experiment], **walls}
    parts = sorted(curves)
    values = [_along(curves[p].at, curves[p].columns[name], at) for p in parts]
    along = PchipInterpolator(parts, values)
    inside = min(max(part, parts[0]), parts[-1])
    return np.asarray(along(inside) + (part - inside) * along(inside, 1) - along(0.0))


def _by_dimensions(
    base: Curve, name: str, at: np.ndarray, truth: Truth, causes: Mapping[str, Cause]
) -> np.ndarray:
    """(rows,) change by the base layer."""
    total = np.zeros(len(at))
    for effect in effects_on(causes, truth):
        key = BY_SLOPE.get(effect.name())
        slope = None if key is None else base.slopes.get((name, key))
        if slope is not None:
            total += effect.model_dump()["offset_mm"] * CubicSpline(base.at, slope)(at)
    return total


def _by_plate(
    catalogue: Catalogue, base: Curve, name: str, at: np.ndarray, truth: Truth
) -> np.ndarray:
    """(rows,) change by the plate's place.

    It is set against the tip as it is at rest. A regulator whose zero is off has bent the finger
    there already, towards negative x, so that the plate is further away from where it would be.
    """
    slope = base.slopes.get((name, "plate.gap_mm"))
    if slope is None:
        return np.zeros(len(at))
    free = catalogue.library.base["bending"]
    bent_mm = -float(_along(free.at, free.columns["tip_x_mm"], at[:1])[0])
    by_mm = GAP_SPREAD_mm * truth.sigma("plate_gap") + bent_mm
    return np.asarray(by_mm * CubicSpline(base.at, slope)(at))


def _changed(
    change: Change, name: str, strength: float, at: np.ndarray, rows: pd.DataFrame
) -> np.ndarray:
    """(rows,) change by a cause, where the pressure by modulus is ``at``."""
    if name not in change.columns:
        return np.zeros(len(at))
    values = change.column(name, strength)
    if change.way == "curve":
        return _along(change.at, values, at)
    found = np.array(values)  # a history's stops are the rows
    for _, part in rows.groupby(["cycle", "branch"], sort=False):
        if (part["branch"] == "hold").all() or len(part) < 3:
            continue
        place = part.index.to_numpy()
        found[place] = _along(change.at[place], values[place], at[place])
    return found


def _along(x: np.ndarray, y: np.ndarray, at: np.ndarray) -> np.ndarray:
    """A spline, and beyond its ends a straight line."""
    order = np.argsort(x)
    spline = CubicSpline(x[order], y[order])
    inside = np.clip(at, x.min(), x.max())
    return np.asarray(spline(inside) + (at - inside) * spline(inside, 1))


def displayed(
    causes: Mapping[str, Cause], course: Course, true: Mapping[str, np.ndarray], truth: Truth
) -> dict[str, np.ndarray]:
    """What the instruments display of the true readings."""
    rows = course.rows
    shown = {
        **true,
        "time_s": rows["time_s"].to_numpy(dtype=float),
        course.control: rows[course.control],
    }
    for effect in effects_on(causes, truth):
        if effect.has("reading"):
            shown.update(effect.reading(shown))  # type: ignore[arg-type]
    for hidden in truth.causes:
        outsider = OUTSIDERS.get(hidden.name)
        if outsider is not None and outsider.displayed is not None:
            shown.update(outsider.displayed(course.rows, shown, hidden.strength))
    return shown
