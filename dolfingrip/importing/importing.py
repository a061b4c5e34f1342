"""Table of a laboratory to the format of measured data: columns, questions, and the two files."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import tomlkit

from dolfingrip.channels import ANGLE, CHANNELS, OF_CAVITIES, TIME, WHO, cavity_of_supply
from dolfingrip.config import Config, ConfigError
from dolfingrip.diagnosis.data import table as measured
from dolfingrip.diagnosis.data.lab_setup import SetupFile
from dolfingrip.diagnosis.data.table import (
    CONTROL,
    IGNORED,
    MEASURED,
    READINGS,
    allowed,
    of_any_number,
    of_markers,
)
from dolfingrip.experiments.material_fit import coupons
from dolfingrip.experiments.material_fit.coupons import STRAIN, STRESS
from dolfingrip.experiments.material_fit.first_loading import first_loading, is_hollow, pressed
from dolfingrip.files import whole
from dolfingrip.importing import cells as reading
from dolfingrip.importing.cells import AmbiguousDate, Cells
from dolfingrip.importing.header import (
    DATED,
    DOUBTFUL,
    IGNORE,
    UNNAMED,
    ColumnReading,
    Recognised,
    factor,
    level,
    recognise,
    told_columns,
)
from dolfingrip.importing.told import ORDERS, Question, Told, column_line, line
from dolfingrip.sections import tables

CLOCK: Final = "time of day"
"""What stands for the unit of such a column."""

BENDING: Final = ("angle_deg", "chord_angle_deg", "tip_x_mm", "tip_z_mm")

BLOWN: Final = ("pressure_kPa", "suction_kPa")

SEVERAL: Final = "several"
"""Stands for the experiment of a table whose rows are of several."""

REST: Final = (*BENDING, "force_N", "displacement_mm")
"""Columns that count from the state at rest."""

AT_REST_SIGMA: Final = 3.0
"""Noises of an ordinary instrument within which a first reading is at rest."""

AIR_KPA: Final = (80.0, 110.0)
"""Pressures of the air at which people live; a gauge that begins there may be an absolute one."""

UNSTRETCHED: Final = 0.9
"""A stretch begins above this, a strain below it."""

DAY_S: Final = 86400.0
"""No experiment begins later than this after its clock was set to zero."""

ZERO_KPA: Final = 10.0
"""A gauge's zero is not farther off than this."""

ALIKE: Final = 0.02
"""Part of a range by which what a machine measured and what it worked out of it may differ."""


@dataclass(slots=True)
class ImportedTable:
    """A table and all that an import found in it.

    Attributes:
        file: the table.
        cells: its header and rows.
        taken: a reading for each column of the table; None: passed over.
        table: columns of the format.
        setup: tables and keys of the TOML file.
        notes: sentences on what was done.
        questions: what is not certain; where there is one, nothing is written.
        fixed: columns that a person tells, by header.
    """

    file: Path
    cells: Cells
    taken: dict[str, ColumnReading | None] = field(default_factory=dict)
    table: pd.DataFrame = field(default_factory=pd.DataFrame)
    setup: dict[str, Any] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    questions: list[Question] = field(default_factory=list)
    fixed: Mapping[str, ColumnReading] = field(default_factory=dict)

    def mapping(self) -> list[tuple[str, str, str]]:
        """Header, column and what was done to the numbers, of each column of the table."""
        asked = {q.text.partition(":")[0]: "?" for q in self.questions}
        found = []
        for header in self.cells.header:
            taken = self.taken.get(header)
            name = taken.target if taken else asked.get(header, "passed over")
            if taken and taken.target not in self.table and not self.questions:
                timed = any(each and each.target == TIME.name for each in self.taken.values())
                by_frames = taken.target == "frame" and TIME.name in self.table and not timed
                name = TIME.name if by_frames else f"passed over ({taken.target})"
            found.append((header, name, _done(taken) if taken else ""))
        return found


def _done(taken: ColumnReading) -> str:
    parts = [taken.unit] if taken.unit else []
    if taken.factor != 1:
        parts.append(f"× {taken.factor:.6g}")
    if taken.offset:
        parts.append(f"{taken.offset:+.6g}")
    return " ".join(parts)


def is_format(header: Sequence[str]) -> bool:
    """Say whether all names of a header are columns of the format, or of nominal coupons.

    Args:
        header: names of columns.
    """
    own = {*MEASURED, *of_any_number(header), *IGNORED, "mode"}
    own |= {*coupons.STRETCHES, *coupons.STRESSES}
    return all(name in own or name.startswith(OF_CAVITIES) for name in header)


def understand(file: Path, told: Told) -> ImportedTable:
    """Find what each column of a table is, and turn it into the format.

    A TOML file of the same stem beside the table tells the set-up, as for ``diagnose``.

    Args:
        file: CSV, TSV, text or XLSX.
        told: what a person tells.

    Returns:
        The columns of the format, or the questions where a column has two readings.

    Raises:
        ConfigError: one line, where the file is no table or what is told does not fit it.
        Question: the sheet, the encoding or the decimal sign is not certain.
    """
    known: dict[tuple[Any, ...], Cells] = {}
    for cells in reading.readings(file, told):
        found = [_with_clock(recognise(name), cells, i) for i, name in enumerate(cells.header)]
        named = sum(any(name in text for text in told.column) for name in cells.header)
        score = named + sum(bool(each.readings) or 0.5 * bool(each.why) for each in found)
        # a unit's accents may differ and mean the same
        taken = tuple((r.target, r.factor, r.offset) for each in found for r in each.readings)
        known.setdefault((score, taken), cells)
    best = max(score for score, _ in known)
    likely = [cells for (score, _), cells in known.items() if score == best]
    if len(likely) > 1 and best:
        names = [cells.how.partition(",")[0] for cells in likely]
        raise Question("its encoding is not certain:", [line("encoding", name) for name in names])
    return _understood(file, likely[0], told)


def read_log(file: Path, told: Told, event: str | None = None) -> pd.DataFrame:
    """Read times and pressures of a log, where another instrument has the readings.

    Args:
        file: CSV, TSV, text or XLSX.
        told: what a person tells.
        event: header of a further column of numbers.

    Returns:
        ``time_s`` and ``pressure_kPa``, and ``event``, in rows that have all of them.

    Raises:
        ConfigError: one line, where the file lacks one of them, or its time runs backwards.
        Question: a column has two readings.
    """
    found = _named(file, next(iter(reading.readings(file, told))), told)
    if not found.questions:
        _convert(found)
        names = [TIME.name, *(name for name in BLOWN if name in found.table)]
        if len(names) < 2 or TIME.name not in found.table:
            has = ", ".join(found.table) or "no column that is known"
            line_ = column_line(found.cells.header[0], TIME.name)
            raise ConfigError(f"{file}: {has}; allowed: time and pressure; name one by {line_}")
        _finger(found, told, SEVERAL)
    if found.questions:
        raise found.questions[0]
    table = found.table[[TIME.name, "pressure_kPa"]]
    if event is not None:
        if event not in found.cells.header:
            there = ", ".join(found.cells.header)
            raise ConfigError(f"--event {event}: not in {file}; allowed: {there}")
        texts = found.cells.column(found.cells.header.index(event))
        table = table.assign(event=_numbers(found, event, texts))
    table = table.dropna()
    if len(table) < 2 or (np.diff(table[TIME.name]) < 0).any():
        raise ConfigError(
            f"{file}: {len(table)} rows with time and pressure; allowed: at least 2, in the order "
            "of time"
        )
    return table


def _named(file: Path, cells: Cells, told: Told) -> ImportedTable:
    """Find what each column of a table is, or the questions where it has two readings."""
    found = ImportedTable(file, cells, setup=_setup(file))
    found.fixed = fixed = told_columns(told.column, cells.header)
    names = [_with_clock(recognise(name), cells, i) for i, name in enumerate(cells.header)]
    certain = {each.header: each.readings[0] for each in names if each.readings and not each.why}
    taken = {**dict.fromkeys(cells.header), **certain, **fixed}
    found.taken = {
        name: None if each is None or each.target == IGNORE else each
        for name, each in taken.items()
    }
    there = {each.target for each in found.taken.values() if each}
    found.questions = [
        _about(each) for each in names
        if each.why and each.header not in fixed
        and (each.why not in (UNNAMED, DOUBTFUL) or {name for _, name in each.offered} - there)
    ]  # fmt: skip
    _one_each(found)
    return found


def _understood(file: Path, cells: Cells, told: Told) -> ImportedTable:
    found = _named(file, cells, told)
    if found.questions:
        return found
    _convert(found)
    experiment = _experiment(found, told)
    if experiment is None:
        return found
    if experiment != "coupon":
        _finger(found, told, experiment)
    if experiment == "coupon" or set(found.table) & set(coupons.STRETCHES):
        _coupon(found, told, experiment)
    if is_format(cells.header) and (
        "experiment" in cells.header or file.with_suffix(".toml").exists()
    ):
        found.notes.append("it is in the format already, and its readings are taken as they are")
    else:
        _at_rest(found, told)
    if not found.questions:
        _arrange(found, experiment)
    return found


def _about(known: Recognised) -> Question:
    lines = [column_line(known.header, column, change) for change, column in known.offered]
    return Question(f"{known.header}: {known.why};", [*lines, column_line(known.header, IGNORE)])


def _with_clock(known: Recognised, cells: Cells, place: int) -> Recognised:
    """A column of times of day, whose unit they tell."""
    texts = cells.column(place)
    try:
        if reading.seconds(texts) is not None:
            return Recognised(known.header, (ColumnReading(TIME.name, CLOCK),))
    except AmbiguousDate as date:
        offered = tuple(("", each) for each in DATED)
        return Recognised(known.header, (), f"{date} may begin with a day or a month", offered)
    if known.offered[:1] == (("", TIME.name),) and (unit := reading.since_1970(texts)):
        since = ColumnReading(TIME.name, f"{unit} since 1970", factor(unit, TIME.name)[0])
        return Recognised(known.header, (since,))
    if reading.pairs(texts) is None or any(each.unit in ("min", "h") for each in known.readings):
        return known
    why = f"{texts[0]} may be minutes and seconds, or hours and minutes"
    return Recognised(known.header, (), why, (("", "time_min"), ("", "time_h")))


def _one_each(found: ImportedTable) -> None:
    """Ask where two columns are the same quantity; one that is told counts."""
    targets: dict[str, list[str]] = {}
    for header, taken in found.taken.items():
        if taken:
            name = "pressure_kPa" if taken.target == "suction_kPa" else taken.target
            targets.setdefault(name, []).append(header)
    for target, headers in targets.items():
        told = [header for header in headers if header in found.fixed]
        if len(told) > 1:
            raise ConfigError(
                f"--column: {' and '.join(told)} are both {target}; allowed: one of them"
            )
        if told:
            found.taken |= {header: None for header in headers if header not in told}
        elif len(headers) > 1 and target not in ("setpoint", "frame"):
            lines = [column_line(header, target) for header in headers]
            if target == "pressure_kPa":  # of an arm with a supply for each of its chambers
                lines += [column_line(headers[0], "cavity_1_supply_kPa")]
            names = " and ".join(headers)
            each = "both are" if len(headers) == 2 else "each is"
            found.questions.append(Question(f"{names}: {each} {target}: which?", lines))


def _convert(found: ImportedTable) -> None:
    """Fill the table with the numbers of the columns that are taken."""
    columns: dict[str, Any] = {}
    for place, header in enumerate(found.cells.header):
        taken = found.taken[header]
        if taken is None or taken.target == "setpoint":
            continue
        texts = found.cells.column(place)
        if taken.target in (*WHO, "mode") and taken.target != "cycle":
            columns[taken.target] = texts
        elif taken.unit in (CLOCK, *ORDERS):
            columns[taken.target] = np.array(reading.seconds(texts, taken.unit))
        elif taken.unit in ("min", "h") and (parts := reading.pairs(texts)) is not None:
            columns[taken.target] = taken.factor * np.array(parts)
        else:
            numbers = _numbers(found, header, texts)
            if np.isnan(numbers).all():
                found.taken[header] = None
                found.notes.append(f"{header}: passed over, as no cell of it has a number")
            else:
                columns[taken.target] = taken.factor * numbers + taken.offset
    found.table = pd.DataFrame(columns)
    if TIME.name in columns:
        _since_first(found)


def _since_first(found: ImportedTable) -> None:
    """Count the times of clocks and calendars from the first: a file has ten digits of each."""
    taken = next(each for each in found.taken.values() if each and each.target == TIME.name)
    first = found.table[TIME.name].min()
    if taken.unit in (CLOCK, *ORDERS) or first > DAY_S:
        found.table[TIME.name] -= first


def _numbers(found: ImportedTable, header: str, texts: Sequence[str]) -> np.ndarray:
    values = []
    for (number, _), text in zip(found.cells.rows, texts, strict=True):
        try:
            values.append(reading.number(text, found.cells.decimal))
        except ValueError:
            raise ConfigError(
                f"{found.file}: line {number}: {header} = {text}: not a number; allowed: numbers "
                f"with a decimal {found.cells.how.rpartition(' ')[2]}, or nothing; "
                f"remove a line that is no reading, or add {column_line(header, IGNORE)}"
            ) from None
    return np.array(values)


def _setup(file: Path) -> dict[str, Any]:
    """The set-up that a TOML file beside the table tells."""
    beside = file.with_suffix(".toml")
    if not beside.exists():
        return {}
    told = SetupFile(beside)
    try:
        Config().changed(coupon=told.table("coupon"))
    except ConfigError as error:
        raise ConfigError(f"{beside}: {error}") from None
    return dict(tables.whole(beside, ""))


def _experiment(found: ImportedTable, told: Told) -> str | None:
    """The experiment, by what is told or by the columns; None where it is asked for."""
    columns = set(found.table)
    named = told.experiment or found.setup.get("experiment")
    named = [named] if isinstance(named, str) else list(named or ())
    of_rows = [each for each in dict.fromkeys(found.table.get("experiment", ())) if each]
    for name in of_rows:
        if name not in READINGS:
            raise ConfigError(f"{found.file}: experiment = {name}: {allowed(name, [*READINGS])}")
    pulled, resists = columns & set(coupons.STRETCHES), columns & set(coupons.STRESSES)
    blown = columns & {*BLOWN, *filter(cavity_of_supply, columns)}
    if len(of_rows) > 1:
        if not blown:
            raise ConfigError(_lacking(found, next(each for each in of_rows if each != "coupon")))
        return SEVERAL
    named = of_rows or named
    fits = {
        "bending": bool(blown and columns & {*BENDING, *of_markers(columns)}),
        "blocked_force": bool(blown and "force_N" in columns),
        "coupon": bool(pulled and resists | (columns & {"transverse_strain"})),
    }
    can = [name for name, fit in fits.items() if fit]
    if len(named) == 1 and named[0] in fits:
        if named[0] not in can:
            raise ConfigError(_lacking(found, named[0]))
        can = named
    if not can:
        raise ConfigError(_lacking(found, ""))
    if len(can) > 1:
        lines = [line("experiment", name) for name in can]
        found.questions.append(Question("its columns fit several experiments: which?", lines))
        return None
    found.setup["experiment"] = can[0]
    return can[0]


def _lacking(found: ImportedTable, experiment: str) -> str:
    """Say which columns an experiment needs."""
    has = ", ".join(found.table) or "no column that is known"
    rest = [header for header, taken in found.taken.items() if taken is None]
    more = ""
    if rest:
        example = column_line(rest[0], "pressure_kPa")
        more = f"; not known, or without numbers: {', '.join(rest)}: name one by {example}"
    needs = {
        "bending": "pressure and an angle or a place of the tip",
        "blocked_force": "pressure and force",
        "coupon": "displacement, strain or stretch, and force or nominal stress",
    }
    allowed = needs[experiment] if experiment else "; or ".join(needs.values())
    return f"{found.file}: {has}{more}; allowed: {allowed}"


def _finger(found: ImportedTable, told: Told, experiment: str) -> None:
    """Pressure above that of the air, suction as a positive one, times of frames."""
    table = found.table
    if not set(table) & set(BLOWN):
        found.table["pressure_kPa"] = table[[*filter(cavity_of_supply, table)]].max(axis=1)
        found.notes.append(
            "no column is pressure_kPa: it is the greatest of the supplies' pressures in each row, "
            "and acts on cavities without a supply of their own"
        )
        return _times(found, told, "rate_kPa_per_s")
    name = "suction_kPa" if "suction_kPa" in table else "pressure_kPa"
    value = table[name].to_numpy()
    finite = value[np.isfinite(value)]
    header, own = next((h, t) for h, t in found.taken.items() if t and t.target == name)
    certain = header in found.fixed or level(own.unit)[1] == "gauge"
    if not certain and len(finite) and AIR_KPA[0] <= finite[0] <= AIR_KPA[1]:
        air = finite[0] / own.factor
        lines = [column_line(header, name, change) for change in (f"-{air:.6g}", "")]
        found.questions.append(
            Question(
                f"{header}: begins at {finite[0]:.4g} kPa: above vacuum, or above the air?", lines
            )
        )
    low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
    if name == "suction_kPa":
        if min(-low, high) > ZERO_KPA:
            raise ConfigError(
                f"{found.file}: {header} = {low:.4g} to {high:.4g} kPa: suction and pressure in "
                "one table; allowed: one sign, each in a table of its own"
            )
        sign = 1.0 if -low >= high else -1.0  # of a pressure below that of the air
        found.taken[header] = replace(own, target="pressure_kPa", factor=sign * own.factor)
        table = table.drop(columns=name).assign(pressure_kPa=sign * value + 0.0)  # 0 and not -0
    found.table = table
    if experiment in CONTROL:
        _times(found, told, "rate_kPa_per_s")


def _times(found: ImportedTable, told: Told, rate: str) -> None:
    """Times by time stamps, frames or the rate."""
    if told.rate is not None:
        found.setup[rate] = told.rate
    if TIME.name in found.table:
        return
    if "frame" in found.table and told.frame_rate is not None:
        frames = found.table["frame"]
        found.table[TIME.name] = (frames - frames.iloc[0]) / told.frame_rate
        found.notes.append(f"time_s is the frame's number by {told.frame_rate:g} Hz")
    elif rate in found.setup:
        found.notes.append(f"times follow from {rate} = {found.setup[rate]:g}")
    elif "frame" in found.table:
        lines = [line("frame_rate"), line("rate")]
        unit = rate.removeprefix("rate_").replace("_per_", "/")
        found.questions.append(
            Question(
                f"frames in place of time: pictures per second (Hz), or the rate ({unit})?", lines
            )
        )
    else:
        found.notes.append(f"no time: diagnose assumes a rate, unless {line('rate')} tells it")


def _coupon(found: ImportedTable, told: Told, experiment: str) -> None:
    """Travel and force where length and cross-section are told; else nominal strain and stress."""
    table, setup = found.table, found.setup
    for name in ("true_stress_MPa", "true_strain"):
        if name in table and not set(table) & {*coupons.STRETCHES, *coupons.STRESSES}:
            raise ConfigError(f"{found.file}: {name}: allowed: nominal strain and stress")
    own = {**setup, **setup.get("coupon", {})}
    area = (
        told.area or own.get("area_mm2") or own.get("width_mm", 0.0) * own.get("thickness_mm", 0.0)
    )
    length = told.gauge_length or own.get("gauge_length_mm")
    nominal = "displacement_mm" not in table and "force_N" not in table
    if not nominal:
        for key, value, name, needs in (
            ("gauge_length", length, "displacement_mm", "length between the grips (mm)"),
            ("area", area, "force_N", "cross-section at rest (mm²)"),
        ):
            if name in table and not value:
                found.questions.append(Question(f"{needs}: not told;", [line(key)]))
    if length:
        setup["gauge_length_mm"] = float(length)
    if area:
        setup["area_mm2"] = float(area)
    mode = told.mode or setup.get("mode")
    setup["mode"] = coupons.MODES[0] if mode in (None, coupons.COMPRESSION) else mode
    if "mode" in table:
        del setup["mode"]
    _unlike_its_name(found)
    if not found.questions:
        for name, scale in (("stretch", length), (STRAIN, length), (STRESS, area)):
            if name in table:
                table = _from_nominal(found, table, name, scale if length and area else None)
    _pressed_or_pulled(found, table, mode, length or math.nan)
    if nominal and not (length and area):
        found.notes.append(
            "for coupon --fit; diagnose needs a travel and a force: --gauge-length and --area"
        )
    found.table = table
    if experiment in CONTROL and (not nominal or (length and area)):
        _times(found, told, "rate_mm_per_s")


def _pressed_or_pulled(
    found: ImportedTable, table: pd.DataFrame, mode: str | None, length_mm: float
) -> None:
    """Turn the signs of a press to those of compression; ask where a pulled one looks like it."""
    ways, loads = (
        [n for n in names if n in table] for names in (coupons.STRETCHES, coupons.STRESSES)
    )
    if mode == coupons.COMPRESSION:
        for name in (*ways, *loads):
            rest = float(name == "stretch")
            turned = rest + pressed(table[name].to_numpy() - rest)
            if (turned != table[name]).any():
                header, own = next((h, t) for h, t in found.taken.items() if t and t.target == name)
                offset = 2 * rest - own.offset
                found.taken[header] = replace(own, factor=-own.factor, offset=offset)
            table[name] = turned
    elif mode is None and "mode" not in table and ways and loads:
        both = table[[ways[0], loads[0]]].dropna().to_numpy()
        strain = (both[:, 0] - both[0, 0]) / (length_mm if ways[0] == "displacement_mm" else 1.0)
        first = first_loading(1 + strain, both[:, 1])
        if first.any() and strain[first].min() >= 0 and is_hollow(strain[first], both[first, 1]):
            lines = [line("mode", each) for each in (coupons.COMPRESSION, coupons.MODES[0])]
            what = f"{loads[0]} rises ever more steeply, as that of rubber in compression: which?"
            found.questions.append(Question(what, lines))


def _from_nominal(
    found: ImportedTable, table: pd.DataFrame, name: str, scale: float | None
) -> pd.DataFrame:
    """The table without a nominal column: what was measured counts, or it is worked out of it.

    Where both are there and disagree, a note has both numbers.

    Args:
        found: takes the note, and how the column was turned.
        table: of a coupon.
        name: of the nominal column, which stays where nothing takes its place.
        scale: length between the grips (mm) or cross-section (mm²); None: no number is worked out.
    """
    of, key, unit = (
        ("force_N", "area", "mm²") if name == STRESS else ("displacement_mm", "gauge_length", "mm")
    )
    if of not in table and (scale is None or name not in table):
        return table.drop(columns=name) if name == STRAIN and "stretch" in table else table
    header, own = next((h, t) for h, t in found.taken.items() if t and t.target == name)
    if of not in table and scale is not None:
        shift = own.offset - (name == "stretch")
        found.taken[header] = replace(
            own, target=of, factor=own.factor * scale, offset=shift * scale
        )
        worked_out = (table[name] - (name == "stretch")) * scale
        return table.assign(**{of: worked_out}).drop(columns=name)
    # differences, as zeros may differ, and slopes, as noise may stand at the ends
    one, other = (table[each] - table[each].mean() for each in (of, name))
    implied = float((one * other).sum() / ((other * other).sum() or math.nan))
    if scale is not None and abs(implied / scale - 1) > ALIKE:
        found.notes.append(
            f"{of} and {header} disagree: {of} was measured and is taken; by both the "
            f"{key.replace('_', ' ')} is {implied:.4g} {unit}, and {scale:.4g} {unit} is told"
        )
    return table.drop(columns=name)


def _unlike_its_name(found: ImportedTable) -> None:
    """Ask where a strain begins at 1, as a stretch does, or a stretch far below it."""
    for header, taken in found.taken.items():
        if taken is None or taken.target not in (STRAIN, "stretch") or header in found.fixed:
            continue
        begins = float(found.table[taken.target].dropna().iloc[0])
        if (taken.target == STRAIN) == (begins >= UNSTRETCHED):
            lines = [column_line(header, name) for name in (STRAIN, "stretch")]
            what = f"{header}: begins at {begins:.4g}: a strain, or a stretch?"
            found.questions.append(Question(what, lines))


def _at_rest(found: ImportedTable, told: Told) -> None:
    """Subtract first readings, or ask where they are not those of the state at rest."""
    table = found.table
    groups = [n for n in ("experiment", "specimen") if n in table]
    alike = [table[n] for n in groups] or [pd.Series(0, index=table.index)]
    for name in [each for each in REST if each in table]:
        first = table[name].groupby(alike, sort=False).transform("first")
        begins = float(first.loc[first.abs().idxmax()])
        noise = AT_REST_SIGMA * CHANNELS[name].noise
        if told.zero_at_rest:
            table[name] = table[name] - first
        elif told.zero_at_rest is None and abs(begins) > noise and _begins_at_rest(table, name):
            lines = ["--zero-at-rest", "--no-zero-at-rest"]
            found.questions.append(
                Question(
                    f"{name} begins at {begins:.4g} {CHANNELS[name].symbol}: zero there?", lines
                )
            )
    if told.zero_at_rest:
        found.notes.append("first readings are subtracted: they are those at rest")
    _signs(found)


def _begins_at_rest(table: pd.DataFrame, name: str) -> bool:
    """Say if the control is at rest in the first row, so that the reading should be zero."""
    if "pressure_kPa" not in table:
        return True
    pressure = table["pressure_kPa"].abs()
    return bool(pressure.iloc[0] <= max(1.0, 0.02 * float(pressure.max())))


def _signs(found: ImportedTable) -> None:
    """Ask where a reading falls as the control rises, which a convention of signs may explain."""
    table = found.table
    control = next((n for n in ("pressure_kPa", "displacement_mm") if n in table), None)
    for name in (ANGLE.name, "chord_angle_deg", "force_N"):
        header = next((h for h, r in found.taken.items() if r and r.target == name), "")
        if (
            control is None
            or name not in table
            or header in found.fixed
            or found.setup.get("cavity")
        ):
            continue
        both = table[[control, name]].dropna()
        farthest = both[name].iloc[int(both[control].to_numpy().argmax())] - both[name].iloc[0]
        if farthest < -AT_REST_SIGMA * CHANNELS[name].noise:
            lines = [column_line(header, name, change) for change in ("*-1", "")]
            found.questions.append(
                Question(f"{header}: falls as {control} rises: turn its sign?", lines)
            )


def _arrange(found: ImportedTable, experiment: str) -> None:
    """Columns of the format in its order, rows with a control alone."""
    own = of_any_number(found.table)
    known = [*MEASURED, *own, "mode", *coupons.STRETCHES, *coupons.STRESSES]
    foreign = set()
    if experiment in READINGS:
        others = {name for each in READINGS.values() for name in each}
        foreign = (others | set(CONTROL.values())) - {*READINGS[experiment], CONTROL[experiment]}
    columns = [name for name in dict.fromkeys(known) if name in found.table and name not in foreign]
    table = found.table[columns]
    controls = [name for name in (*CONTROL.values(), STRAIN, "stretch") if name in table]
    kept = table.dropna(subset=controls, how="all")
    if len(kept) < len(table):
        found.notes.append(f"{len(table) - len(kept)} rows without a control are left out")
    if "cycle" in kept:
        kept = kept.assign(
            cycle=kept["cycle"].map(lambda each: "" if math.isnan(each) else f"{each:g}")
        )
    found.table = kept


def write(found: ImportedTable, out: Path) -> tuple[Path, Path]:
    """Write the two files of the format; the TOML says in comments what was taken for what.

    Args:
        found: without questions.
        out: folder.

    Returns:
        The CSV and the TOML.

    Raises:
        ConfigError: one line, if the table is not valid in the format; nothing stays then.
    """
    target = out / f"{found.file.stem}.csv"
    if target.resolve() == found.file.resolve():
        raise ConfigError(f"--out {out}: the table lies there; allowed: another folder")
    document = tomlkit.document()
    for text in (f"from {found.file.name} ({found.cells.how})", *_comments(found)):
        document.add(tomlkit.comment(" ".join(text.split())))
    for key, value in sorted(found.setup.items(), key=lambda item: isinstance(item[1], Mapping)):
        document.add(key, value)
    text = found.table.to_csv(index=False, float_format="%.10g", lineterminator="\n")
    _check(found, text, tomlkit.dumps(document))
    whole.write_together({target: text, target.with_suffix(".toml"): tomlkit.dumps(document)})
    return target, target.with_suffix(".toml")


def _comments(found: ImportedTable) -> list[str]:
    lines = [f"{name} <- {header} {done}".rstrip() for header, name, done in found.mapping()]
    return [*lines, *found.notes, *(f"passed over: {text}" for text in found.cells.passed_over)]


def _check(found: ImportedTable, rows: str, setup: str) -> None:
    """Read both files as ``diagnose`` does, unless the rows are nominal."""
    import tempfile

    if STRESS in found.table or STRAIN in found.table or "stretch" in found.table:
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / f"{found.file.stem}.csv"
        whole.write(file, rows)
        whole.write(file.with_suffix(".toml"), setup)
        try:
            told = SetupFile(file)
            read = measured.read(file, told.experiments)
            told.check_specimens(set(read["specimen"]))
            for experiment, specimen in read.groupby(["experiment", "specimen"]).groups:
                told.of(experiment, specimen)
        except ConfigError as error:
            raise ConfigError(str(error).replace(folder + "/", "")) from None
